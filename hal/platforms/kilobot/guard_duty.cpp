// What the process of StandGuard does: watches its program, and speaks in its place.
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <syslog.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <memory>
#include <optional>

#include "hal/platforms/kilobot/descriptor_stream.hpp"
#include "hal/platforms/kilobot/guard_words.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "hal/platforms/kilobot/overhead_controller.hpp"
#include "hal/platforms/kilobot/port_lock.hpp"
#include "hal/platforms/kilobot/stand_guard.hpp"

namespace arkmesh::hal::kilobot {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;

constexpr milliseconds speaks_for = 60s;             // robots may walk
constexpr milliseconds speaks_briefly_for = 2500ms;  // they stood when the program went
constexpr milliseconds guards_stop_takes = 300ms;
constexpr milliseconds says_again_each = 100ms;
constexpr milliseconds looks_each = 20ms, looks_at_program_each = 100ms;
constexpr milliseconds is_taken_within = 5s;               // by a program that wants it
constexpr milliseconds others_see_the_end_within = 50ms;   // of a connection: some take one at a time
constexpr milliseconds others_byte_takes = 50ms;           // of a program that does not hang after all
constexpr milliseconds kills_after = 10s;                  // a program that hangs and has no line to speak on
constexpr milliseconds longest_silence_of_a_look = 250ms;  // on a machine that starves the guard, too

volatile std::sig_atomic_t told_to_leave = 0;

// The controller may start anew when its port opens, or not: it is told at once, and again and again.
class Speaker {
 public:
  Speaker(std::unique_ptr<ByteStream> stream, FleetCommand::Kind wanted) : line_(std::move(stream), counters_) {
    controller_.command({.kind = wanted});
  }
  // Stops the controller's sending, as far as it can.
  void stop() {
    controller_.stop_sending(time_.now());
    const TimePoint until = time_.now() + guards_stop_takes;
    while (line_.is_open() && !controller_.is_silent(time_.now()) && time_.now() < until) poll(until);
  }
  // Says what is due, and waits for what is next, until then at most.
  void poll(TimePoint until) {
    controller_.poll(time_.now());
    controller_.urge(time_.now());
    time_.wait_until(std::min({controller_.due(time_.now()), until, time_.now() + looks_each}));
  }
  bool is_open() const { return line_.is_open(); }
  bool has_said() const { return controller_.said_since().has_value(); }

 private:
  WallTime& time_ = machine_time();
  const ArenaInfo info_{kind_of(ark_layout, WholeMessages::to_nobody)};  // it says what all robots understand
  Counters counters_;
  PacketPort line_;
  OverheadController controller_{info_, line_, {.again_after = says_again_each, .settle = 0us}, counters_};
};

// One that is open, and is not opened again.
std::unique_ptr<ByteStream> stream_of(Handle open) {
  const auto held = std::make_shared<Handle>(std::move(open));
  Line line;
  line.open = [held]() -> Handle {
    if (!*held) throw PortError("the line is lost");
    return std::move(*held);
  };
  line.why_lost = [](bool, int) { return "the line is lost"; };
  return std::make_unique<DescriptorStream>(std::move(line));
}

class GuardDuty {
 public:
  GuardDuty(std::string port, int word, milliseconds hung_after)
      : port_(std::move(port)), word_(word), hung_after_(hung_after) {
    ucred maker{};
    socklen_t length = sizeof maker;
    if (::getsockopt(word_.get(), SOL_SOCKET, SO_PEERCRED, &maker, &length) == 0) program_ = maker.pid;
  }

  // Until the program is gone.
  void watch() {
    for (TimePoint before = now(); hear();) {
      const TimePoint at = now();
      silent_ += std::min(std::chrono::duration_cast<milliseconds>(at - before), longest_silence_of_a_look);
      before = at;
      if (has_lived_ && hung_after_ > 0ms && !(state_ && state_->ended)) look_whether_it_hangs();
      if (speaker_)
        speaker_->poll(at + looks_each);
      else
        wait_for_word(looks_at_program_each);
    }
    speaker_.reset();
    line_ = Handle();
  }

  // A wish that it ends does not count before: the program that it watches may get one as well, and need its time.
  void stand_in() {
    told_to_leave = 0;
    if (!state_ || (state_->ended && state_->all_stand)) return;
    const milliseconds lasts = state_->all_stand ? speaks_briefly_for : speaks_for;
    const Handle here = stand_by(port_);
    for (TimePoint until = now() + lasts; told_to_leave == 0; machine_time().wait_until(now() + looks_each)) {
      std::shared_ptr<PortLock> lock;
      try {
        auto stream =
            claim_byte_stream(port_, std::string(StandGuard::process_name) + ", for a program that is gone", &lock);
        if (is_others(lock->former())) return;
        lock->write(PortHolder::State::trying);
        speak(std::move(stream), *lock, until);
        if (told_to_leave != 0 || !lock->is_wanted()) return;
        machine_time().wait_until(now() + others_see_the_end_within);
        lock->release();
        // the program that wants it has it, or leaves it
        for (const TimePoint end = now() + is_taken_within; lock->is_wanted() && now() < end;)
          machine_time().wait_until(now() + looks_each);
        until = now() + lasts;
      } catch (const PortError&) {
        const auto holder = port_holder(port_);
        const bool tries = holder && holder->state == PortHolder::State::trying && !holder->is_guard();
        if ((holder && is_others(*holder)) || (!tries && now() >= until)) return;
      }
    }
  }

 private:
  static TimePoint now() { return machine_time().now(); }

  // Robots are in the charge of another program, which said so.
  bool is_others(const PortHolder& holder) const {
    return holder.state != PortHolder::State::trying && !holder.is_guard() && holder.process != program_;
  }

  // Until it is time, or another program wants the port. The line is closed then.
  void speak(std::unique_ptr<ByteStream> stream, PortLock& lock, TimePoint until) {
    Speaker speaker(std::move(stream), state_->wanted);
    for (bool said = false; told_to_leave == 0 && now() < until && !lock.is_wanted(); speaker.poll(until))
      if (!std::exchange(said, speaker.has_said()) && speaker.has_said()) lock.write(PortHolder::State::speaking);
    speaker.stop();
  }

  void wait_for_word(milliseconds at_most) {
    pollfd state{word_.get(), POLLIN, 0};
    ::poll(&state, 1, static_cast<int>(at_most.count()));
  }

  // All that was said. False: the program is gone.
  bool hear() {
    for (;;) {
      std::array<std::uint8_t, 4> bytes{};
      int descriptor = -1;
      const ssize_t n = receive_word(word_.get(), bytes.data(), bytes.size(), descriptor);
      Handle line(descriptor);
      if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) return false;
      if (n < 0) return true;
      silent_ = 0ms;
      if (speaker_) wakes();
      has_lived_ = has_lived_ || bytes[0] == guard_word::lives;
      if (bytes[0] == guard_word::state)
        state_ = {static_cast<FleetCommand::Kind>(bytes[1]), bytes[2] != 0, bytes[3] != 0};
      if (bytes[0] == guard_word::line || bytes[0] == guard_word::no_line) line_ = std::move(line);
      if (bytes[0] == guard_word::no_line) say_word(guard_word::leaves_line);
    }
  }

  void say_word(std::uint8_t word) const { send_word(word_.get(), &word, 1); }

  void look_whether_it_hangs() {
    if (silent_ >= hung_after_ && line_ && !speaker_) return speak_for_hung();
    if (silent_ < std::max(kills_after, hung_after_) || (speaker_ && speaker_->is_open())) return;
    say(
        fmt::format("the program (process {}) has hung for {} s, and while it holds the port nothing can stop its "
                    "robots; the guard ends it",
                    program_, kills_after / 1s));
    ::kill(program_, SIGKILL);
    silent_ = 0ms;
  }

  // It learns so before its next byte, however soon it goes on.
  void speak_for_hung() {
    say_word(guard_word::takes_line);
    machine_time().wait_until(now() + others_byte_takes);
    if (!hear() || silent_ == 0ms) return;
    note_holder(port_, program_, PortHolder::State::hung);
    say(
        fmt::format("the program (process {}) has given no sign of life for {} s; its robots are stopped until it "
                    "continues",
                    program_, std::chrono::duration<double>(hung_after_).count()));
    speaker_ = std::make_unique<Speaker>(stream_of(Handle(::fcntl(line_.get(), F_DUPFD_CLOEXEC, 0))),
                                         state_ ? state_->wanted : FleetCommand::Kind::pause);
  }

  void wakes() {
    speaker_.reset();
    note_holder(port_, program_, PortHolder::State::speaking);
  }

  // In the system's log, and where the program says things.
  void say(const std::string& sentence) const {
    ::openlog(StandGuard::process_name, LOG_PID, LOG_DAEMON);
    ::syslog(LOG_WARNING, "%s: %s", port_.c_str(), sentence.c_str());
    const std::string text = fmt::format("{}: {}: {}\n", StandGuard::process_name, port_, sentence);
    const Handle out(::open(fmt::format("/proc/{}/fd/2", program_).c_str(),
                            O_WRONLY | O_APPEND | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    if (out) [[maybe_unused]]
      const ssize_t written = ::write(out.get(), text.data(), text.size());
  }

  const std::string port_;
  const Handle word_;
  const milliseconds hung_after_;
  pid_t program_ = 0;
  std::optional<StandGuard::State> state_;
  bool has_lived_ = false;  // it has said so, so that its silence tells something
  milliseconds silent_{0};
  Handle line_;                       // a copy of the program's
  std::unique_ptr<Speaker> speaker_;  // on it, while the program hangs
};

}  // namespace

int stand_guard(const std::string& port, int word, milliseconds hung_after) {
  struct sigaction leave {};
  leave.sa_handler = [](int) { told_to_leave = 1; };
  ::sigaction(SIGTERM, &leave, nullptr);
  GuardDuty duty(port, word, hung_after);
  duty.watch();
  duty.stand_in();
  return 0;
}

}  // namespace arkmesh::hal::kilobot
