#include "view/viewer_outbox.hpp"

#include <boost/endian/conversion.hpp>
#include <utility>

namespace arkmesh::view {
namespace {

using namespace std::string_view_literals;

constexpr std::size_t max_bundle_bytes = 256 << 10;
constexpr std::string_view bundle_head = "\3\0\0\0"sv;

template <class Number>
void put(std::string& out, Number number) {
  boost::endian::native_to_little_inplace(number);
  out.append(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace

std::string frame(Kind kind, int lab, std::uint32_t request, std::int64_t t_us, std::string_view channel,
                  std::span<const std::byte> data) {
  channel = channel.substr(0, 255);
  std::string out;
  out.reserve(16 + channel.size() + data.size());
  put(out, static_cast<std::uint8_t>(kind));
  put(out, static_cast<std::uint8_t>(lab));
  put(out, static_cast<std::uint8_t>(channel.size()));
  put(out, std::uint8_t{0});
  put(out, request);
  put(out, t_us);
  out += channel;
  out.append(reinterpret_cast<const char*>(data.data()), data.size());
  return out;
}

std::string bundle(std::span<const std::string> frames) {
  std::string out(bundle_head);
  for (const std::string& one : frames) {
    put(out, static_cast<std::uint32_t>(one.size()));
    out += one;
  }
  return out;
}

bool ViewerOutbox::say(std::string text) {
  if (words_.size() >= max_words) return false;
  words_.push_back({std::make_shared<const std::string>(std::move(text)), true});
  return true;
}

bool ViewerOutbox::answer(std::string bytes, bool text) {
  if (answer_bytes_ + bytes.size() > max_answer_bytes) return false;
  answer_bytes_ += bytes.size();
  answers_.push_back({std::make_shared<const std::string>(std::move(bytes)), text});
  return true;
}

void ViewerOutbox::event(Parcel event) {
  event_bytes_ += event.bytes->size();
  events_.push_back(std::move(event));
  while (events_.size() > max_events || (event_bytes_ > max_event_bytes && events_.size() > 1)) {
    event_bytes_ -= events_.front().bytes->size();
    events_.pop_front();
    ++replaced_;
  }
}

void ViewerOutbox::newest(std::size_t slot, Parcel parcel) {
  if (slot >= slots_.size()) slots_.resize(slot + 1);
  if (slots_[slot].bytes)
    ++replaced_;
  else
    waiting_.push_back(slot);
  slots_[slot] = std::move(parcel);
}

std::optional<Parcel> ViewerOutbox::take() {
  const auto pop = [](std::deque<Parcel>& from) {
    Parcel out = std::move(from.front());
    from.pop_front();
    return out;
  };
  if (!words_.empty()) return pop(words_);
  if (!answers_.empty()) {
    answer_bytes_ -= answers_.front().bytes->size();
    return pop(answers_);
  }
  if (!events_.empty()) {
    event_bytes_ -= events_.front().bytes->size();
    return pop(events_);
  }
  if (waiting_.empty()) return std::nullopt;
  return waiting_.size() > 1 ? take_bundle() : take_newest();
}

Parcel ViewerOutbox::take_newest() {
  const std::size_t slot = waiting_.front();
  waiting_.pop_front();
  return std::exchange(slots_[slot], Parcel{});
}

// Each message costs a system call at both ends, so what waits goes as one, as far as it is no text and not too long.
Parcel ViewerOutbox::take_bundle() {
  const auto is_bundle = [](const Parcel& parcel) { return parcel.bytes->starts_with(bundle_head); };
  const auto next = [&]() -> const Parcel& { return slots_[waiting_.front()]; };
  if (next().text || next().bytes->size() > max_bundle_bytes) return take_newest();
  std::string out(bundle_head);
  while (!waiting_.empty() && !next().text && out.size() + next().bytes->size() <= max_bundle_bytes) {
    const Parcel one = take_newest();
    if (!is_bundle(one)) put(out, static_cast<std::uint32_t>(one.bytes->size()));
    out += is_bundle(one) ? one.bytes->substr(bundle_head.size()) : *one.bytes;
  }
  return {std::make_shared<const std::string>(std::move(out))};
}

}  // namespace arkmesh::view
