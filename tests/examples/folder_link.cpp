// Every file appears by a rename, so that nobody reads half of one.
#include "tests/examples/folder_link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "gateway/frame/frame.hpp"
#include "hal/arenas/messages.hpp"

namespace arkmesh::examples {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_files = 64;  // that lie in the folder; the rest waits in the outbox

// With its frames.
std::size_t longest_file(std::size_t max_message_bytes) {
  const std::size_t payload = max_message_bytes + gateway::message_overhead_bytes + hal::max_channel_name;
  return payload + (payload / gateway::max_frame_payload_bytes + 1) * gateway::frame_header_bytes;
}

bool write_file(const fs::path& file, std::span<const std::byte> bytes) {
  fs::path partial = file;
  partial += ".partial";
  std::ofstream out(partial, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  std::error_code error;
  if (out) fs::rename(partial, file, error);
  return out && !error;
}

// The messages in a folder, oldest first: their names are boot id and number.
std::vector<fs::path> messages_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator each(folder, error), end; !error && each != end; each.increment(error))
    if (each->path().extension() == ".message") files.push_back(each->path());
  std::ranges::sort(files);
  return files;
}

}  // namespace

FolderLink::FolderLink(boost::asio::io_context& io, FolderLinkSettings settings)
    : settings_(std::move(settings)),
      inbox_(settings_.folder / settings_.lab / settings_.peer),
      outbox_folder_(settings_.folder / settings_.peer / settings_.lab),
      outbox_(settings_.outbox_bytes),
      timer_(io) {
  outbox_.set_longest(settings_.max_message_bytes);
  stats_.why = "not met yet";
}

void FolderLink::start(Events events) {
  events_ = std::move(events);
  started_ = true;
  std::error_code error;
  for (const fs::path& file : messages_in(inbox_))
    if (fs::remove(file, error)) stats_.counters.add("received.dropped.before_start");
  timer_.expires_after(settings_.look_period);
  timer_.async_wait([this, alive = std::weak_ptr(alive_)](auto cancelled) {
    if (!cancelled && !alive.expired()) look();
  });
}

void FolderLink::stop() {
  if (std::exchange(stopped_, true)) return;
  events_ = {};
  timer_.cancel();
  std::error_code error;
  if (started_) fs::remove(outbox_folder_ / "alive", error);
  stats_.up = false;
  stats_.why = "stopped";
}

void FolderLink::offer(const gateway::Rule& rule, std::string_view, std::span<const std::byte> bytes) {
  if (!stopped_) outbox_.put(rule, bytes, std::chrono::steady_clock::now());
}

gateway::LinkStats FolderLink::stats() const {
  gateway::LinkStats stats = stats_;
  stats.counters.merge(outbox_.counters());
  return stats;
}

void FolderLink::look() {
  const auto now = Clock::now();
  const std::string why = why_down(now);
  change(why.empty(), why.empty() ? "connected" : why);
  beat(now);
  if (stats_.up) send();
  if (stats_.up) receive();
  if (stopped_) return;
  timer_.expires_after(settings_.look_period);
  timer_.async_wait([this, alive = std::weak_ptr(alive_)](auto cancelled) {
    if (!cancelled && !alive.expired()) look();
  });
}

// Empty: the peer is at work. A file that an end left when it was killed looks like that of a living one, so that only
// one that changes counts.
std::string FolderLink::why_down(Clock::time_point now) {
  std::error_code error;
  Beat beat;
  if (!fs::is_directory(settings_.folder, error)) {
    peer_beat_.reset();
    beat_at_.reset();
    return fmt::format("the folder {} is not there", settings_.folder.string());
  }
  if (!(std::ifstream(inbox_ / "alive") >> beat.boot_id >> beat.count)) {
    peer_beat_.reset();
    beat_at_.reset();
    return fmt::format("no gateway of lab {} uses the folder {}", settings_.peer, settings_.folder.string());
  }
  if (!peer_beat_ || peer_beat_->boot_id != beat.boot_id)
    beat_at_.reset();
  else if (*peer_beat_ != beat)
    beat_at_ = now;
  peer_beat_ = beat;
  if (!beat_at_) return fmt::format("lab {} has not been met yet", settings_.peer);
  if (now - *beat_at_ > settings_.longest_silence)
    return fmt::format("lab {} has been silent for {} s", settings_.peer, settings_.longest_silence.count() / 1000.0);
  return {};
}

void FolderLink::change(bool up, const std::string& why) {
  if (stopped_ || (stats_.up == up && stats_.why == why)) return;
  if (up) {
    stats_.peer_boot_id = peer_beat_->boot_id;
    stats_.counters.add("session.opened");
  }
  stats_.up = up;
  stats_.why = why;
  if (const auto tell = events_.changed) tell(up, why);
}

void FolderLink::beat(Clock::time_point now) {
  std::error_code error;
  if (stopped_ || now < beat_due_ || !fs::is_directory(settings_.folder, error)) return;
  beat_due_ = now + settings_.beat_period;
  fs::create_directories(inbox_, error);
  fs::create_directories(outbox_folder_, error);
  const std::string text = fmt::format("{} {}\n", settings_.boot_id, ++beats_);
  if (!write_file(outbox_folder_ / "alive", std::as_bytes(std::span(text)))) stats_.counters.add("sent.failed");
}

void FolderLink::send() {
  for (std::size_t lying = messages_in(outbox_folder_).size(); lying < max_files; ++lying) {
    const std::span<const std::byte> message = outbox_.whole_message(std::chrono::steady_clock::now());
    if (message.empty()) return;
    const std::string name = fmt::format("{:020}-{:020}.message", settings_.boot_id, files_);
    if (!write_file(outbox_folder_ / name, message)) {
      outbox_.session_lost();
      outbox_.send_again(false);
      return stats_.counters.add("sent.failed");
    }
    ++files_;
    const gateway::Outbox::Sent sent = outbox_.written(message.size());
    outbox_.acknowledged(sent.messages);
    stats_.sent_messages += sent.messages;
    stats_.sent_bytes += sent.bytes;
  }
}

void FolderLink::receive() {
  std::vector<fs::path> files = messages_in(inbox_);
  files.resize(std::min(files.size(), max_files));
  for (const fs::path& file : files)
    if (!stopped_) deliver(file);
}

// A file that cannot be removed is left alone: it would arrive again and again.
void FolderLink::deliver(const fs::path& file) {
  std::error_code error;
  std::vector<std::byte> bytes(
      std::min<std::uintmax_t>(fs::file_size(file, error), longest_file(settings_.max_message_bytes)));
  if (!error) std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(bytes.data()), std::ssize(bytes));
  if (error || !fs::remove(file, error)) return;

  const auto message = gateway::decode_message(bytes);
  if (!message) return stats_.counters.add("received.refused.damaged");
  ++stats_.received_messages;
  stats_.received_bytes += message->bytes.size();
  if (const auto tell = events_.arrived) tell(message->channel, message->bytes);
}

gateway::LinkKind folder_links() {
  return {"folder",
          [](std::string_view address) {
            return std::string(address.starts_with('/') ? "" : "must be folder:// and an absolute path");
          },
          [](const gateway::LinkSurroundings& gateway, const std::string& peer, std::string_view address) {
            return std::unique_ptr<gateway::Link>(
                std::make_unique<FolderLink>(gateway.io, FolderLinkSettings{
                                                             .lab = gateway.lab,
                                                             .peer = peer,
                                                             .boot_id = gateway.boot_id,
                                                             .folder = address,
                                                             .outbox_bytes = gateway.config.outbox_bytes,
                                                             .max_message_bytes = gateway.config.max_message_bytes,
                                                         }));
          }};
}

}  // namespace arkmesh::examples
