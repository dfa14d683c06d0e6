// A lab on an emulated testbed, whatever it waits for, says how it is and shows its arena: people see that it lives.
#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <string>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "hal/messages.hpp"
#include "tests/support/labs/lab_processes.hpp"

using namespace arkmesh;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using tests::LabProcesses;

namespace {

constexpr std::uint16_t window_port = 7990;

// Watches a stream of pictures; comes again until there is one.
class Viewer {
 public:
  ~Viewer() { ::close(fd_); }
  // Pictures that have begun to come so far.
  std::size_t pictures() {
    std::array<char, 65536> some;
    const ssize_t n = fd_ < 0 ? 0 : ::recv(fd_, some.data(), some.size(), 0);
    if (n > 0)
      got_.append(some.data(), static_cast<std::size_t>(n));
    else if (n == 0 || (errno != EAGAIN && errno != EINTR))
      ask();
    std::size_t count = 0;
    for (std::size_t at = 0; (at = got_.find("Content-Length: ", at)) != std::string::npos; ++at) ++count;
    return count;
  }

 private:
  void ask() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(window_port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const std::string request = "GET /camera0 HTTP/1.1\r\n\r\n";
    const timeval soon{.tv_sec = 0, .tv_usec = 2000};
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &soon, sizeof soon);
    if (::connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0)
      ::send(fd_, request.data(), request.size(), MSG_NOSIGNAL);
  }

  int fd_ = -1;
  std::string got_;
};

// What came while the lab's state began with some words.
struct Seen {
  std::vector<Clock::time_point> statuses, pictures;
};

Clock::duration longest_gap(const std::vector<Clock::time_point>& moments) {
  Clock::duration longest{};
  for (std::size_t i = 1; i < moments.size(); ++i) longest = std::max(longest, moments[i] - moments[i - 1]);
  return longest;
}

// Looks until so many statuses of that state, and as many pictures if there are any, have come.
Seen look(LabProcesses& labs, const std::string& lab, const std::string& state, bool pictured = true) {
  Seen seen;
  std::string current;
  hal::Bus bus(labs.bus_url(lab));
  const auto status = bus.subscribe(hal::channel::status, [&](std::string_view, std::span<const std::byte> bytes) {
    lab_status_t message;
    REQUIRE(hal::decode(bytes, message));
    current = message.state;
    if (current.starts_with(state)) seen.statuses.push_back(Clock::now());
  });
  Viewer viewer;
  std::size_t before = 0;
  CHECK(tests::eventually(50s, [&] {
    bus.drain(2ms);
    const std::size_t now = viewer.pictures();
    if (now > before && current.starts_with(state)) seen.pictures.push_back(Clock::now());
    before = now;
    return !labs.lab(lab).running() || (seen.statuses.size() >= 5 && (!pictured || seen.pictures.size() >= 5));
  }));
  CAPTURE(labs.lab_output(lab));
  CHECK(labs.lab(lab).running());
  return seen;
}

LabProcesses::Options emulated(std::vector<std::string> overrides) {
  overrides.insert(overrides.end(), {"arena.use=emulated", fmt::format("arena.kilobot.window_port={}", window_port)});
  return {.overrides = std::move(overrides)};
}

void check_lively(const Seen& seen) {
  CHECK(seen.statuses.size() >= 5);
  CHECK(seen.pictures.size() >= 5);
  CHECK(longest_gap(seen.statuses) < 8s);
  CHECK(longest_gap(seen.pictures) < 8s);
}

}  // namespace

TEST_CASE("a lab that waits for an absent peer shows its arena and answers") {
  // Emulated time stands still meanwhile: what there is, is shown again.
  LabProcesses labs(emulated({}));
  labs.start_lab("roark");
  check_lively(look(labs, "roark", "waiting for shark"));
}

TEST_CASE("a lab that identifies its robots shows its arena and answers") {
  // Robot 12 is nowhere, so that the search lasts.
  LabProcesses labs(emulated({"arena.robots=13"}));
  labs.start_lab("roark");
  check_lively(look(labs, "roark", "waiting for the testbed"));
}

TEST_CASE("a lab that waits for the next frame of a slow arena answers") {
  // Frames are five seconds apart; the lab says each second how it is nonetheless.
  LabProcesses labs(
      {.labs = {"shark"},
       .overrides = {"arena.use=null", "arena.pace=1.0", "arena.frame_period_s=5.0", "gate.period_s=5.0"}});
  labs.start_lab("shark");
  const Seen seen = look(labs, "shark", "running", false);
  CHECK(seen.statuses.size() >= 5);
  CHECK(longest_gap(seen.statuses) < 8s);
}
