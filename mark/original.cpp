#include "mark/original.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

namespace arkmesh::mark {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t read_within = 2;   // ticks
constexpr hal::LabTime quiet_after = 5s;   // as other labs: a peer of which nothing has counted for so long is lost
constexpr auto ark_qt_reads_each = 250ms;  // it looks each 100 ms
constexpr std::uint64_t surely = 3;        // NULs behind messages: no accident

}  // namespace

Original::Original(const Settings& settings, Role role, const Grammar& grammar, Conversation& conversation,
                   std::unique_ptr<Link> link, Away away, hal::Counters& counters, hal::WallTime& wall)
    : settings_(settings),
      role_(role),
      away_(away),
      conversation_(conversation),
      counters_(counters),
      wall_(wall),
      splitter_(grammar),
      link_(std::move(link)) {
  link_->start(*this);
}

void Original::open() {
  if (!std::exchange(open_, true)) link_->open();
}

void Original::serve() {
  if (!open_) return;
  link_->serve();
  if (settings_.flavour == Flavour::ark_qt && begun_ && quiet() && !std::exchange(quiet_, true)) {
    spdlog::warn("{}", absence());
    conversation_.gone();
  }
  skip();
  say();
}

hal::TimePoint Original::next_service() const {
  // Patience, and what is due by the wall.
  return std::min(link_->next_service(), wall_.now() + 20ms);
}

// ---------------------------------------------------------------- what it says

void Original::came() {
  hear_waiting();
  splitter_.reset();
  ticks_ = answered_ = unended_ = 0;
  unread_.clear();
  said_.clear();
  said_at_ = {};
  heard_at_ = wall_.now();
  quiet_ = false;
  if (away_since_)
    spdlog::warn("{} is connected again at {}, at {:.1f} s of lab time", name(), link_->place(), seconds(told_));
  else
    spdlog::info("{} is connected at {}", name(), link_->place());
  away_since_.reset();
  counters_.add("mark.connections");
  conversation_.came();
}

void Original::gone(const std::string& why) {
  hear_waiting();
  away_since_ = wall_.now();
  told_before_ = told_;
  quiet_ = false;
  counters_.add("mark.lost");
  spdlog::warn("{} is disconnected: {}", name(), why);
  conversation_.gone();
}

void Original::heard(std::string_view bytes) {
  const std::uint64_t before = ticks_;
  for (Message& message : splitter_.feed(bytes)) {
    ++ticks_;
    counters_.add("mark.messages_heard");
    // Its operator may have stopped a server and run it again, with other sites, which does not end the connection; it
    // is later than usual then. When the lab has ended nothing of its world changes.
    const bool is_late = wall_.now() - std::exchange(heard_at_, wall_.now()) > settings_.period * 5 / 4;
    if (settings_.flavour == Flavour::ark_qt && role_ == Role::client && begun_ && !ended_ && is_late)
      conversation_.came();
    quiet_ = false;
    if (!begun_ || ended_ || settings_.flavour == Flavour::ark_qt) {
      hear(message);
      continue;
    }
    to_hear_.push_back(std::move(message));
  }
  unended_ = ticks_ == before ? unended_ + bytes.size() : 0;
  if (splitter_.counters()["mark.refused.nul"] >= surely)
    conversation_.conflict(
        fmt::format("{} ends its messages with NUL, so it is ARGoS; set mark.flavour = \"argos\"", name()));
}

void Original::hear(const Message& message) {
  if (message.word == Word::stopped) {
    counters_.add("mark.stopped");
    spdlog::warn("{} was stopped by its operator", name());
    conversation_.gone();
  } else {
    conversation_.hear(message);
  }
}

// Ticks, each of which takes so long.
void Original::hear_ticks(std::size_t ticks, hal::LabTime each) {
  for (; ticks > 0 && !to_hear_.empty(); --ticks, to_hear_.pop_front()) {
    hear(to_hear_.front());
    told_ += each;
  }
}

void Original::hear_waiting() {
  skip();
  hear_ticks(to_hear_.size(), settings_.period);
}

// Connected, and for longer than usual without a message.
bool Original::quiet() const {
  return link_->up() && wall_.now() - heard_at_ > std::max(quiet_after, 3 * settings_.period);
}

std::optional<hal::TimePoint> Original::away_since() const {
  return quiet_ ? heard_at_ : away_since_;
}

// ---------------------------------------------------------------- its time

bool Original::reached(hal::LabTime t) {
  const bool argos = settings_.flavour == Flavour::argos;
  if (!std::exchange(begun_, true)) {
    zero_ = heard_at_ = wall_.now();  // before it need not have said anything
    ticks_before_ = ticks_;
    if (argos) spdlog::info("lab time starts at tick {} of {}", ticks_, name());
  }
  const bool goes_on = !away_since() || away_ == Away::goes_on;
  if (!argos && goes_on && wall_.now() >= zero_ + t) told_ = t;
  while (told_ < t && !to_hear_.empty()) hear_ticks(1, settings_.period);
  if (argos && away_since() && goes_on && told_ < t) {
    const auto passed = std::chrono::duration_cast<hal::LabTime>(wall_.now() - *away_since_);
    if (t <= told_before_ + passed) told_ = t;
  }
  if (standing_ > hal::LabTime{0} && told_ - stood_at_ >= settings_.ahead) say_skipped();
  return told_ >= t;
}

// It waits for nobody. What it does while labs stand still is heard at the lab time at which they do, and has no time:
// labs that caught up would act for moments that have passed, and it would hear of that late.
void Original::skip() {
  if (!begun_ || ended_) return;
  const bool argos = settings_.flavour == Flavour::argos;
  const hal::LabTime ahead = argos ? static_cast<std::int64_t>(to_hear_.size()) * settings_.period
                                   : std::chrono::duration_cast<hal::LabTime>(wall_.now() - zero_) - told_;
  const hal::LabTime more = ahead - settings_.ahead;
  if (more <= hal::LabTime{0}) return;
  if (standing_ == hal::LabTime{0}) stood_at_ = told_;
  const bool stood = standing_ > settings_.ahead;
  skipped_ += more;
  standing_ += more;
  counters_.set("mark.skipped.ms", static_cast<std::uint64_t>(skipped_ / 1ms));
  if (!stood && standing_ > settings_.ahead && !away_since()) {
    spdlog::warn("lab time stopped at {:.1f} s, {:.1f} s behind {}, which continues on its own", seconds(told_),
                 seconds(settings_.ahead), name());
    conversation_.gone();
  }
  zero_ += more;
  hear_ticks(static_cast<std::size_t>(more / settings_.period), hal::LabTime{0});
}

// Where both are now, once that is more than Settings::ahead from where it was said to be.
void Original::say_skipped() {
  standing_ = hal::LabTime{0};
  if (skipped_ - skipped_said_ < settings_.ahead) return;
  const std::string tick =
      settings_.flavour == Flavour::argos ? fmt::format(" is tick {} of {}", ticks_ - to_hear_.size(), name()) : "";
  spdlog::warn(
      "lab time {:.1f} s{}: skipped {:.1f} s of the original, because labs stopped or were slow; {:.1f} s in all",
      seconds(told_), tick, seconds(skipped_ - skipped_said_), seconds(skipped_));
  skipped_said_ = skipped_;
}

void Original::end() {
  if (ended_) return;
  say_skipped();
  ended_ = true;
  conversation_.end();
  hear_waiting();
}

// ---------------------------------------------------------------- what it is told

bool Original::may_say(std::size_t size) {
  if (settings_.flavour == Flavour::ark_qt) return true;
  while (!unread_.empty() && ticks_ >= unread_.front().ticks + read_within) unread_.pop_front();
  std::size_t all = size;
  for (const Unread& each : unread_) all += each.size;
  return all <= static_cast<std::size_t>(settings_.read_bytes);
}

void Original::say() {
  if (!link_->up()) return;
  const bool argos = settings_.flavour == Flavour::argos;
  // One for each of its own: what it has not read it would take together with the next, and ARK-Qt would die of that.
  // ARK-Qt says nothing before the first, and answers no acknowledgement.
  if (ticks_ == answered_ && (argos || !(said_.empty() || said_ == ack_text(Flavour::ark_qt)))) return;
  const hal::TimePoint now = wall_.now();
  if (!argos && now - said_at_ < ark_qt_reads_each) return;
  const std::optional<std::string> text = conversation_.say();
  if (!text) return;
  if (!argos && *text == said_ && now - said_at_ < settings_.period) return;
  std::string message = *text;
  if (argos) message += '\0';
  if (message.size() > static_cast<std::size_t>(settings_.read_bytes)) return counters_.add("mark.not_sent.too_long");
  answered_ = ticks_;
  if (!link_->settled()) return counters_.add("mark.held.not_arrived");
  if (!may_say(message.size())) return counters_.add("mark.held.unread");
  unread_.push_back({message.size(), ticks_});
  said_ = *text;
  said_at_ = now;
  counters_.add("mark.messages_sent");
  link_->send(message);
  conversation_.said();
}

// ---------------------------------------------------------------- for people

std::string Original::name() const {
  return fmt::format("the original M-ARK {} ({})", other_of(role_), name_of(settings_.flavour));
}

std::string Original::absence() const {
  if (quiet())
    return fmt::format("{}, which is connected but has sent nothing for {} s{}", name(),
                       std::chrono::floor<std::chrono::seconds>(wall_.now() - heard_at_).count(),
                       unended_ == 0 ? "" : fmt::format(" except {} bytes without an end (mark.flavour)", unended_));
  if (link_->up()) return {};
  const std::string error = link_->error();
  if (away_since_) return fmt::format("{}, which is disconnected: {}", name(), error);
  if (role_ == Role::server)
    return fmt::format("{}, which has not connected to {}{}", name(), link_->place(),
                       error.empty() ? "" : fmt::format(" ({})", error));
  return fmt::format("{} at {}{}", name(), link_->place(), error.empty() ? "" : fmt::format(": {}", error));
}

}  // namespace arkmesh::mark
