// How late a machine is: what a test leaves out when it judges how long something took.
#pragma once

#include <chrono>
#include <fstream>
#include <string>

namespace arkmesh::tests {

// For how long a thread wanted a processor and had none, since it began. `who`: a path below /proc: a process's id
// means its first thread, "self/task/ID" any. 0 when there is none, or where Linux does not count it.
inline std::chrono::nanoseconds run_delay(const std::string& who = "thread-self") {
  long long ran = 0, delayed = 0;
  std::ifstream("/proc/" + who + "/schedstat") >> ran >> delayed;
  return std::chrono::nanoseconds(delayed);
}

// The time since it was made without the calling thread's delay: what would have passed on a machine with nothing else
// to do.
class OwnTime {
 public:
  std::chrono::nanoseconds passed() const {
    return std::chrono::steady_clock::now() - begun_ - (run_delay() - delayed_);
  }

 private:
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::chrono::nanoseconds delayed_ = run_delay();
};

}  // namespace arkmesh::tests
