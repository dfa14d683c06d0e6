#include "scenarios/python/one_processor.hpp"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <string>

namespace arkmesh::scenarios::python {
namespace {

namespace fs = std::filesystem;
constexpr int this_thread = 0;
constexpr int free_answers = 4;  // in which the system may give our thread another processor

cpu_set_t only(int processor) {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(processor, &one);
  return one;
}

}  // namespace

OneProcessor::OneProcessor(pid_t child) : child_(child) {
  ::sched_getaffinity(this_thread, sizeof thread_may_, &thread_may_);
}

OneProcessor::~OneProcessor() {
  if (joined_) ::sched_setaffinity(this_thread, sizeof thread_may_, &thread_may_);
}

void OneProcessor::answered(Duration took) {
  mean_ += (took - mean_) / 32;
  if (joined_ && mean_ > slow) return part();
  if (joined_ && ::sched_getcpu() != processor_) bind_child();  // the thread has moved
  ++answers_;
  if (joined_ && answers_ % looks_every == looks_every - free_answers)
    ::sched_setaffinity(this_thread, sizeof thread_may_, &thread_may_);
  if (joined_ ? answers_ % looks_every == 0 : answers_ % joins_after == 0 && mean_ < quick) join();
}

void OneProcessor::join() {
  if (!joined_ && ::sched_getaffinity(child_, sizeof child_may_, &child_may_) != 0) return;  // it has ended
  joined_ = true;
  bind_child();
  const cpu_set_t one = only(processor_);
  ::sched_setaffinity(this_thread, sizeof one, &one);
}

void OneProcessor::bind_child() {
  processor_ = ::sched_getcpu();
  const cpu_set_t one = only(processor_);
  ::sched_setaffinity(child_, sizeof one, &one);
}

// Threads that the child started meanwhile are bound as it was.
void OneProcessor::part() {
  joined_ = false;
  answers_ = 0;
  ::sched_setaffinity(this_thread, sizeof thread_may_, &thread_may_);
  std::error_code ended;
  for (fs::directory_iterator task(fmt::format("/proc/{}/task", child_), ended), end; !ended && task != end;
       task.increment(ended)) {
    const std::string name = task->path().filename();
    pid_t id = 0;
    std::from_chars(name.data(), name.data() + name.size(), id);
    ::sched_setaffinity(id, sizeof child_may_, &child_may_);
  }
}

}  // namespace arkmesh::scenarios::python
