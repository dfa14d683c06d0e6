#include "scenarios/python/one_processor.hpp"

#include <doctest/doctest.h>

#include "hal/child_process.hpp"

namespace arkmesh::scenarios::python {
namespace {

using namespace std::chrono_literals;

int processors_of(pid_t who) {
  cpu_set_t may;
  REQUIRE(::sched_getaffinity(who, sizeof may, &may) == 0);
  return CPU_COUNT(&may);
}

}  // namespace

TEST_CASE("a child that answers quickly shares the thread's processor, a slow one has all, and none keeps the thread") {
  const int all = processors_of(0);
  const hal::ChildProcess child({.command = {"sleep", "600"}});
  const auto answer = [&](OneProcessor& processor, int times, std::chrono::nanoseconds took) {
    for (int k = 0; k < times; ++k) processor.answered(took);
  };
  {
    OneProcessor processor(child.id());
    answer(processor, 4 * OneProcessor::joins_after, 500us);
    CHECK(processors_of(0) == all);
    answer(processor, 4 * OneProcessor::joins_after, 100us);
    CHECK(processors_of(0) == 1);
    CHECK(processors_of(child.id()) == 1);
    answer(processor, OneProcessor::looks_every, 500us);
    CHECK(processors_of(child.id()) == 1);
    answer(processor, OneProcessor::looks_every, 5ms);
    CHECK(processors_of(0) == all);
    CHECK(processors_of(child.id()) == all);
    answer(processor, 4 * OneProcessor::joins_after, 100us);
    CHECK(processors_of(child.id()) == 1);
  }
  CHECK(processors_of(0) == all);
}

}  // namespace arkmesh::scenarios::python
