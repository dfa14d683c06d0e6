#include "app/live/lab_feed.hpp"

#include <algorithm>

#include "app/live/frame_part.hpp"
#include "hal/arenas/messages.hpp"

namespace arkmesh::app {
namespace {

constexpr std::int64_t max_stamp_us = std::int64_t{1} << 53;  // what the page's numbers hold

}  // namespace

void LabFeed::hear(view::Server& server, int lab, std::string_view channel, std::span<const std::byte> bytes) {
  view::Part part;
  // lab time ten times a second, where the status has it once
  if (const auto frame = frame_part(channel, bytes)) {
    newest_us_ = std::min(frame->stamp_us, max_stamp_us);
    part = frame->part;
  }
  if (channel == hal::channel::status) {
    for (const std::string& line : news_.read(bytes)) server.tell(lab, news_.stamp_us(), line);
    history_.note(news_.stamp_us(), news_.counts());
  }
  server.show(lab, newest_us_, channel, bytes, part);
}

}  // namespace arkmesh::app
