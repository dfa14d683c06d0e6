// A PoseSource for arenas that make frames faster than somebody takes them: holds the newest one, counts the rest.
#pragma once

#include <optional>
#include <utility>

#include "hal/arenas/arena.hpp"
#include "hal/counters.hpp"

namespace arkmesh::hal {

class NewestFrame final : public PoseSource {
 public:
  // `counters` outlives this; frames that nobody took are counted there as `poses.skipped`.
  explicit NewestFrame(Counters& counters) : counters_(counters) {}
  void put(PoseFrame frame) {
    if (frame_) skip(1);
    frame_ = std::move(frame);
  }
  // Frames that were never made because newer ones came at once.
  void skip(std::uint64_t frames) { counters_.add("poses.skipped", frames); }
  std::optional<PoseFrame> latest() override { return std::exchange(frame_, std::nullopt); }

 private:
  Counters& counters_;
  std::optional<PoseFrame> frame_;
};

}  // namespace arkmesh::hal
