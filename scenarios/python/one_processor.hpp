// Keeps a lab's thread and a child that answers it quickly on one processor: to wake another one takes longer than such
// an answer does (in a virtual machine some 0.1 ms). A child whose answers take long may run on any processor.
#pragma once

#include <sched.h>
#include <sys/types.h>

#include <chrono>

namespace arkmesh::scenarios::python {

class OneProcessor {
 public:
  using Duration = std::chrono::nanoseconds;
  // Where the mean of some answers is between these, all stays as it is.
  static constexpr Duration quick = std::chrono::microseconds(300), slow = std::chrono::milliseconds(1);
  static constexpr int joins_after = 64, looks_every = 1024;  // answers

  explicit OneProcessor(pid_t child);
  ~OneProcessor();
  OneProcessor(const OneProcessor&) = delete;
  OneProcessor& operator=(const OneProcessor&) = delete;

  // The child has answered after so long. Called by one thread, which is the one that is kept.
  void answered(Duration took);

 private:
  void join();
  void bind_child();
  void part();

  pid_t child_;
  cpu_set_t thread_may_, child_may_;  // the processors that they had before
  Duration mean_ = slow;
  int answers_ = 0, processor_ = 0;
  bool joined_ = false;
};

}  // namespace arkmesh::scenarios::python
