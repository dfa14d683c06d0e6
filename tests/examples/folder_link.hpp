// A link through a folder that both labs see, on this machine or mounted: each message is a file. An end puts its
// messages into FOLDER/PEER/LAB and takes those for it from FOLDER/LAB/PEER; a file `alive`, rewritten again and again,
// tells the other end that it is at work. The link is as fast as the folder: a mount that hangs stops the gateway.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "gateway/link.hpp"
#include "gateway/links/links.hpp"
#include "gateway/outbox/outbox.hpp"

namespace arkmesh::examples {

struct FolderLinkSettings {
  std::string lab, peer;
  std::uint64_t boot_id = 0;
  std::filesystem::path folder;  // must be there while the link is up
  std::size_t outbox_bytes = 4 << 20;
  std::uint32_t max_message_bytes = 1 << 20;
  std::chrono::milliseconds look_period{20}, beat_period{500};  // at the folder; of `alive`
  std::chrono::milliseconds longest_silence{3000};              // of the peer's `alive`
};

// Beside what an outbox counts: `session.opened`, `received.refused.damaged`, `received.dropped.before_start` (files
// that an earlier gateway of this lab left) and `sent.failed` (files that could not be written, and are tried again).
class FolderLink final : public gateway::Link {
 public:
  FolderLink(boost::asio::io_context& io, FolderLinkSettings settings);
  ~FolderLink() override { stop(); }

  const std::string& peer() const override { return settings_.peer; }
  void start(Events events) override;
  void offer(const gateway::Rule& rule, std::string_view channel, std::span<const std::byte> bytes) override;
  void keep_only(const Passes& passes) override { outbox_.keep_only(passes); }
  gateway::LinkStats stats() const override;
  void stop() override;

 private:
  using Clock = std::chrono::steady_clock;
  struct Beat {
    std::uint64_t boot_id = 0, count = 0;
    bool operator==(const Beat&) const = default;
  };

  void look();
  std::string why_down(Clock::time_point now);
  void change(bool up, const std::string& why);
  void beat(Clock::time_point now);
  void send();
  void receive();
  void deliver(const std::filesystem::path& file);

  const FolderLinkSettings settings_;
  const std::filesystem::path inbox_, outbox_folder_;
  Events events_;
  gateway::Outbox outbox_;
  gateway::LinkStats stats_;
  bool started_ = false, stopped_ = false;
  std::uint64_t beats_ = 0, files_ = 0;
  Clock::time_point beat_due_{};
  std::optional<Beat> peer_beat_;             // the newest one
  std::optional<Clock::time_point> beat_at_;  // when it came while we were looking
  boost::asio::steady_timer timer_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // handlers hold it weakly
};

// gateway.peers.connect = "folder:///an/absolute/path", the same in both labs.
gateway::LinkKind folder_links();

}  // namespace arkmesh::examples
