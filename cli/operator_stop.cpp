#include "cli/operator_stop.hpp"

#include <csignal>
#include <initializer_list>

namespace arkmesh::cli {
namespace {

volatile std::sig_atomic_t wished = 0;

}  // namespace

bool operator_stops() {
  static const bool listens = [] {
    for (const int each : {SIGINT, SIGTERM})
      std::signal(each, [](int number) {
        wished = 1;
        std::signal(number, SIG_DFL);
      });
    return true;
  }();
  return listens && wished;
}

}  // namespace arkmesh::cli
