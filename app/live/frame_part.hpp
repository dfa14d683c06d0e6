// Which part of which frame a message is, for the page: frames of more than 1000 robots come as several.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "view/channels.hpp"

namespace arkmesh::app {

struct FramePart {
  std::int64_t stamp_us = 0;  // lab time
  view::Part part;
};
// From the first bytes of an encoded pose_frame_t. Nothing when the channel has none, or the bytes are none or
// contradict themselves: then the message stands alone.
std::optional<FramePart> frame_part(std::string_view channel, std::span<const std::byte> bytes);

}  // namespace arkmesh::app
