// What a lab that runs elsewhere says, as its page gets it: messages by lab time, lines of the event log, curves.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "app/live/count_history.hpp"
#include "app/live/status_news.hpp"
#include "view/server.hpp"

namespace arkmesh::app {

class LabFeed {
 public:
  // A message of lab number `lab` of the page, in the lab's own name of the channel.
  void hear(view::Server& server, int lab, std::string_view channel, std::span<const std::byte> bytes);
  // As its status says it; empty before the first.
  const std::string& name() const { return news_.lab(); }
  const CountHistory& history() const { return history_; }

 private:
  StatusNews news_;
  CountHistory history_;  // since this program listens
  std::int64_t newest_us_ = 0;
};

}  // namespace arkmesh::app
