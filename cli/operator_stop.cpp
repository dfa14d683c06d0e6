#include "cli/operator_stop.hpp"

#include <initializer_list>

namespace arkmesh::cli {
namespace {

volatile std::sig_atomic_t wished = 0, other_failed = 0;

void wish(int number) {
  wished = 1;
  std::signal(number, SIG_DFL);
}

void end_with_other(int) {
  if (wished != 0) return;
  other_failed = 1;
  wished = 1;
}

bool listen() {
  std::signal(group_failed_signal, end_with_other);
  for (const int each : {SIGINT, SIGTERM}) std::signal(each, wish);
  // the terminal is gone; nohup ignores that
  if (std::signal(SIGHUP, wish) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  return true;
}

}  // namespace

OperatorStop::OperatorStop() {
  [[maybe_unused]] static const bool listens = listen();
}

const char* OperatorStop::failure() {
  return other_failed != 0 ? "another process of the same arkmesh up has ended" : nullptr;
}

bool OperatorStop::stopped() {
  return wished != 0;
}

}  // namespace arkmesh::cli
