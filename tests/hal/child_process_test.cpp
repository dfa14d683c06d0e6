// Programs that are started: how they end, what they say, and what ends with them.
#include "hal/child_process.hpp"

#include <doctest/doctest.h>
#include <sched.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <string>
#include <utility>

#include "tests/support/processes/process.hpp"

namespace arkmesh {
namespace {

using namespace std::chrono_literals;

hal::ChildStart shell(const std::string& words) {
  return {.command = {"sh", "-c", words}};
}

// A zombie that nobody reaps yet counts as gone.
bool is_gone(pid_t process) {
  const std::string status = tests::read_file("/proc/" + std::to_string(process) + "/status");
  return status.empty() || status.find("State:\tZ") != std::string::npos;
}

TEST_CASE("a program runs to its end, and says both outputs and its code") {
  const hal::Finished done = hal::run_to_end(shell("echo one; echo two >&2; cat; exit 3"));
  CHECK(done.output == "one\ntwo\n");
  CHECK(done.status == 3);
  CHECK_FALSE(done.too_long);
}

TEST_CASE("a program that there is not ends with 127, one that is killed with -1") {
  CHECK(hal::run_to_end({.command = {"/nonexistent/program"}}).status == 127);
  CHECK(hal::run_to_end(shell("kill -9 $$")).status == -1);
}

TEST_CASE("after its limit a program is killed with all that it started") {
  const auto begun = std::chrono::steady_clock::now();
  const hal::Finished done = hal::run_to_end(shell("sleep 600 & echo $!; wait"), 500ms);
  CHECK(done.too_long);
  CHECK(std::chrono::steady_clock::now() - begun < 300s);
  const auto started = static_cast<pid_t>(std::stol(done.output));
  CHECK(tests::eventually(300s, [&] { return is_gone(started); }));
}

TEST_CASE("a child's waits for a processor are counted, and its sleep is not") {
  cpu_set_t ours, first;
  ::sched_getaffinity(0, sizeof ours, &ours);
  CPU_ZERO(&first);
  CPU_SET(static_cast<unsigned>(::sched_getcpu()), &first);
  REQUIRE(::sched_setaffinity(0, sizeof first, &first) == 0);
  const auto busy = [] {
    for (volatile unsigned turns = 0;;) turns = turns + 1;
    return 0;
  };
  const hal::ChildProcess sleeps(shell("exec sleep 600")), one({.function = busy}), other({.function = busy});
  const bool both_wait = tests::eventually(300s, [&] { return one.run_delay() > 50ms && other.run_delay() > 50ms; });
  // once it is asleep
  const bool sleep_is_none = tests::eventually(300s, [&] {
    const std::chrono::nanoseconds slept = sleeps.run_delay(), waited = one.run_delay();
    return tests::eventually(300s, [&] { return one.run_delay() > waited + 50ms; }) && sleeps.run_delay() == slept;
  });
  ::sched_setaffinity(0, sizeof ours, &ours);
  CHECK(both_wait);
  CHECK(sleep_is_none);
}

TEST_CASE("a program that says much is read to its end, and its first 64 KiB are kept") {
  const hal::Finished done = hal::run_to_end(shell("head -c 1000000 /dev/zero | tr '\\0' x; exit 4"));
  CHECK(done.output == std::string(64 << 10, 'x'));
  CHECK(done.status == 4);
}

TEST_CASE("one that never stops saying something has a limit, too") {
  CHECK(hal::run_to_end(shell("yes"), 300ms).too_long);
}

TEST_CASE("variables of the environment are set beside ours, and in place of them") {
  ::setenv("ARKMESH_TEST_OURS", "ours", 1);
  ::setenv("ARKMESH_TEST_BOTH", "ours", 1);
  hal::ChildStart start = shell("echo $ARKMESH_TEST_OURS $ARKMESH_TEST_BOTH");
  start.environment = {"ARKMESH_TEST_BOTH=given"};
  CHECK(hal::run_to_end(std::move(start)).output == "ours given\n");
}

TEST_CASE("a child ends by itself or by a signal, and what its group holds ends with it") {
  pid_t started = 0;
  {
    hal::ChildProcess child(shell("sleep 600 & echo $!; exit 5"));
    const hal::ChildProcess::End end = child.wait();
    CHECK(end.code == 5);
    CHECK(end.signal == 0);
    std::string said;
    child.read(said);
    started = static_cast<pid_t>(std::stol(said));
    CHECK_FALSE(is_gone(started));
  }
  CHECK(tests::eventually(300s, [&] { return is_gone(started); }));

  hal::ChildProcess other(shell("echo begun; exec sleep 600"));
  std::string said;
  CHECK(tests::eventually(300s, [&] { return other.read(said) && !said.empty(); }));
  CHECK_FALSE(other.end());
  other.signal(SIGTERM);
  CHECK(other.wait().signal == SIGTERM);
  CHECK(other.end()->code == 128 + SIGTERM);
}

TEST_CASE("a line to a child is its descriptor 3") {
  hal::ChildStart start = shell("read -r word <&3; echo \"$word back\" >&3; echo done");
  start.has_line = true;
  hal::ChildProcess child(std::move(start));
  REQUIRE(::send(child.line(), "there\n", 6, MSG_NOSIGNAL) == 6);
  CHECK(child.wait().code == 0);
  char answer[32];
  CHECK(std::string(answer, static_cast<std::size_t>(::recv(child.line(), answer, sizeof answer, 0))) ==
        "there back\n");
  std::string said;
  child.read(said);
  CHECK(said == "done\n");
  CHECK_FALSE(child.read(said));
  CHECK(child.output() == -1);
}

TEST_CASE("a child in the group of this process runs a function of it") {
  const pid_t group = ::getpgrp();
  hal::ChildProcess child({.function = [=] { return ::getpgrp() == group ? 7 : 1; }, .own_group = false});
  CHECK(child.wait().code == 7);
}

}  // namespace
}  // namespace arkmesh
