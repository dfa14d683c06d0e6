// main() of every test program. Both names, since the precompiled headers have doctest.h already.
#define DOCTEST_CONFIG_IMPLEMENT
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/processes/thorough.hpp"

// Compiled controllers are kept beside the tests, for them and the programs that they start, and not in the user's
// cache.
[[maybe_unused]] static const int arkmesh_test_cache = setenv("XDG_CACHE_HOME", ARKMESH_TEST_CACHE, 1);

// libnats forgets the message that it was reading when its connection ends: gateway/federation/nats_connection.cpp
// bounds what that costs. Read by AddressSanitizer, which declares it nowhere.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:natsBuf_Create\n";
}

namespace {

// Ends a program in which nothing has been asserted for ten minutes (twenty, if thorough), and tells how each case
// that failed is repeated alone: lines that begin with "again: ", which scripts/test shows last.
class Watch final : public doctest::IReporter {
 public:
  explicit Watch(const doctest::ContextOptions&) {}

  void test_case_start(const doctest::TestCaseData& test) override {
    again() = "again: " + command(test.m_name) + "\n";
    struct sigaction action {};
    action.sa_handler = hung;
    ::sigaction(SIGALRM, &action, nullptr);
    progress(true);
  }
  void test_case_reenter(const doctest::TestCaseData&) override { progress(true); }
  void log_assert(const doctest::AssertData&) override { progress(false); }
  void test_case_end(const doctest::CurrentTestCaseStats& stats) override {
    ::alarm(0);
    if (stats.failure_flags != 0) failed_.push_back(again());
  }
  void test_run_end(const doctest::TestRunStats&) override {
    for (const std::string& each : failed_) std::cout << each;
    std::cout << std::flush;
  }
  void report_query(const doctest::QueryData&) override {}
  void test_run_start() override {}
  void test_case_exception(const doctest::TestCaseException&) override {}
  void subcase_start(const doctest::SubcaseSignature&) override {}
  void subcase_end() override {}
  void log_message(const doctest::MessageData&) override {}
  void test_case_skipped(const doctest::TestCaseData&) override {}

 private:
  static std::string& again() {
    static std::string line;
    return line;
  }
  // Commas separate doctest's patterns, quotes end the shell's words.
  static std::string command(std::string_view name) {
    std::string words = arkmesh::tests::thorough() ? "ARKMESH_THOROUGH=1 " : "";
    words += "scripts/alone " + std::filesystem::read_symlink("/proc/self/exe").string() + " --test-case='";
    for (const char c : name) {
      if (c == ',' || c == '\\') words += '\\';
      words += c == '\'' ? std::string("'\\''") : std::string(1, c);
    }
    return words + "'";
  }
  // The alarm is of this process alone: children have none. It is set again once a second at most.
  void progress(bool at_once) {
    const auto now = std::chrono::steady_clock::now();
    if (!at_once && now - set_ < std::chrono::seconds(1)) return;
    set_ = now;

    ::alarm(arkmesh::tests::thorough() ? 1200 : 600);
  }
  static void hung(int) {
    static constexpr std::string_view why = "\nhung: nothing was asserted for too long\n";
    [[maybe_unused]] ssize_t written = ::write(STDOUT_FILENO, why.data(), why.size());
    written = ::write(STDOUT_FILENO, again().data(), again().size());
    ::abort();  // doctest names the case
  }

  std::vector<std::string> failed_;
  std::chrono::steady_clock::time_point set_{};
};

}  // namespace

DOCTEST_REGISTER_LISTENER("watch", 0, Watch);
