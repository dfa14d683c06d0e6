#include "hal/platforms/kilobot/ohc_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "hal/platforms/kilobot/port_lock.hpp"
#include "hal/time/wall_time.hpp"

namespace arkmesh::hal::kilobot {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::seconds opening_takes_at_most = 6s;
constexpr std::chrono::milliseconds heard_within = 300ms;  // by robots, on a line that is still open then

TimePoint now() {
  return machine_time().now();
}
double seconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

OhcSession::OhcSession(const std::string& port, std::chrono::microseconds settle, StopRequest& stop, Progress& progress)
    : port_(claim_byte_stream(port, "arkmesh ohc", &lock_), counters_),
      sender_(port_, settle, counters_),
      stop_(stop),
      status_(progress) {
  const TimePoint begun = now();
  while (!stop_.stopped() && !sender_.is_up()) {
    sender_.poll(now());
    if (!port_.is_open() && !port_.error().empty()) throw std::runtime_error(port_.error() + lock_->guarded_words());
    if (!port_.is_open() && now() - begun > opening_takes_at_most)
      throw std::runtime_error(fmt::format("{}: no answer for {} s; is that machine on, and is the address right?{}",
                                           port, opening_takes_at_most.count(), lock_->guarded_words()));
    status_.show(port_.is_open() ? "waiting for the controller, which may be starting"
                                 : fmt::format("connecting with {}", port));
    wait();
  }
}

OhcSession::~OhcSession() {
  sender_.cut_short(now());
  for (const TimePoint end = now() + 300ms; now() < end && sender_.is_up(); wait()) {
    sender_.poll(now());
    if (!sender_.is_ready(now())) continue;
    // on the air already, or now; what may have to go between is a stop as well
    std::ignore = sender_.send(stop_packet(), stop_spacing, now());
    return;
  }
}

void OhcSession::wait() {
  machine_time().wait_until(sender_.due(now()));
}

OhcSaid OhcSession::say(const OhcCommand& command) {
  const double all_s = seconds(command.each) * static_cast<double>(command.packets.size());
  std::optional<TimePoint> begun;  // of the first packet
  const auto said_s = [&] { return begun ? std::min(all_s, seconds(now() - *begun)) : 0.0; };
  for (std::size_t next = 0; !stop_.stopped(); wait()) {
    const TimePoint present = now();
    sender_.poll(present);
    if (!port_.is_open())
      throw std::runtime_error(fmt::format("{}; {} had been sent for {:.1f} of {:.1f} s{}", port_.error(), command.name,
                                           said_s(), all_s, lock_->guarded_words()));
    if (command.is_for_robots && begun &&
        present - *begun >= std::min<std::chrono::microseconds>(command.each, heard_within))
      lock_->take_over();
    if (!sender_.is_ready(present)) {
      if (begun && all_s >= 2) status_.show(fmt::format("{}: {:.0f} of {:.0f} s", command.name, said_s(), all_s));
    } else if (next == command.packets.size()) {
      if (!sender_.is_repeating()) return {true, said_s(), all_s};
      std::ignore = sender_.send(stop_packet(), stop_spacing, present);
    } else if (sender_.send(command.packets[next], command.each, present)) {
      ++next;
      if (!begun) begun = present;
    }
  }
  status_.done();
  return {false, said_s(), all_s};
}

void OhcSession::upload(FirmwareUpload& upload) {
  const TimePoint begun = now();
  for (; !stop_.stopped(); wait()) {
    const TimePoint present = now();
    upload.poll(sender_, present);
    if (!upload.is_calling()) lock_->take_over();
    if (upload.is_finished() && sender_.is_ready(present)) break;
    if (!sender_.is_up())
      status_.show(port_.is_open() ? "the controller is starting again" : port_.error() + "; trying again");
    else if (upload.is_calling() || (upload.round() == 0 && upload.page() == 0))
      status_.show("calling the robots to their boot loaders; they flash blue");
    else
      status_.show(fmt::format("round {}, page {} of {}, {:.0f} s", upload.round() + 1, upload.page(), upload.pages(),
                               seconds(present - begun)));
  }
  status_.done();
}

}  // namespace arkmesh::hal::kilobot
