// What waits for one viewer. Of each channel the newest message alone; what must not be lost in order, up to a limit.
// Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"

namespace arkmesh::view {

// One WebSocket message; several viewers may wait for the same bytes.
struct Parcel {
  std::shared_ptr<const std::string> bytes;
  bool text = false;
};

enum class Kind : std::uint8_t { message = 1, picture = 2 };

// The bytes of a message or picture as view/PROTOCOL.md has them. `channel` has at most 255 bytes; longer ones are
// cut.
std::string frame(Kind kind, int lab, std::uint32_t request, std::int64_t t_us, std::string_view channel,
                  std::span<const std::byte> data);

// Several of them as one binary message.
std::string bundle(std::span<const std::string> frames);

class ViewerOutbox {
 public:
  static constexpr std::size_t max_words = 64, max_events = 512, max_event_bytes = 1 << 20, max_answer_bytes = 32 << 20;

  // Words of the server, which go first. False: too many wait, so this viewer is to be sent away.
  bool say(std::string text);
  // In their order. False: no room; nothing was taken.
  bool answer(std::string bytes, bool text);
  // In their order; the oldest give way when too many wait, which is counted (`replaced`).
  void event(Parcel event);
  // The newest of place `slot`, which the server numbers from 0 on: what waits there is replaced, and that is counted.
  void newest(std::size_t slot, Parcel parcel);

  // What goes next; nothing when nothing waits. Several messages that are the newest of their channels go as one
  // bundle.
  std::optional<Parcel> take();
  bool empty() const { return words_.empty() && answers_.empty() && events_.empty() && waiting_.empty(); }
  // So many answers wait that nothing more is read from the viewer until some have gone.
  bool busy() const { return answer_bytes_ > max_answer_bytes / 4 || words_.size() > max_words / 2; }
  std::uint64_t replaced() const { return replaced_; }

 private:
  Parcel take_newest();
  Parcel take_bundle();

  std::deque<Parcel> words_, answers_, events_;
  std::size_t answer_bytes_ = 0, event_bytes_ = 0;
  std::vector<Parcel> slots_;        // without bytes: nothing waits
  std::deque<std::size_t> waiting_;  // slots that hold something, the longest waiting first
  std::uint64_t replaced_ = 0;
};

}  // namespace arkmesh::view
