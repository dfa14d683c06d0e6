#include "cli/operator_stop.hpp"

#include <csignal>
#include <initializer_list>

namespace arkmesh::cli {
namespace {

volatile std::sig_atomic_t wished = 0;

void wish(int number) {
  wished = 1;
  std::signal(number, SIG_DFL);
}

bool listen() {
  for (const int each : {SIGINT, SIGTERM}) std::signal(each, wish);
  // the terminal is gone; nohup ignores that
  if (std::signal(SIGHUP, wish) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  return true;
}

}  // namespace

OperatorStop::OperatorStop() {
  [[maybe_unused]] static const bool listens = listen();
}

bool OperatorStop::stopped() {
  return wished != 0;
}

}  // namespace arkmesh::cli
