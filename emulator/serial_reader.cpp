// The thread waits in poll() without the mutex, for a few milliseconds at most, so that nobody has to wake it.
#include "emulator/serial_reader.hpp"

#include <poll.h>

#include <array>
#include <utility>

namespace arkmesh::emulator {
namespace {

// Enough for what a line takes in a second; what is more stays with the writer, as at a real port.
constexpr std::size_t max_held_bytes = 4096;
constexpr int wait_ms = 20;

}  // namespace

SerialReader::SerialReader(const std::string& address, std::uint16_t port, const std::string& link)
    : link_(link),
      terminal_(std::make_unique<PseudoTerminal>(link)),
      tcp_(address, port, "the overhead controller (emulator.ohc_port)") {
  tcp_port_ = tcp_.port();
  thread_ = std::thread([this] { run(); });
}

SerialReader::~SerialReader() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  thread_.join();
}

void SerialReader::run() {
  for (;;) {
    std::array<pollfd, 3> wanted{};
    bool full = false;
    {
      const std::lock_guard lock(mutex_);
      if (ends_) return;
      full = held_bytes_ >= max_held_bytes;
      wanted[0] = {terminal_ && !full ? terminal_->handle() : -1, POLLIN, 0};
      wanted[1] = {full ? -1 : tcp_.client(), POLLIN, 0};
      wanted[2] = {tcp_.listener(), POLLIN, 0};
    }
    // a closed descriptor that has a number anew does no harm: reads never block
    ::poll(wanted.data(), wanted.size(), full ? 2 : wait_ms);

    const std::lock_guard lock(mutex_);
    tcp_.accept();
    if (!terminal_) {
      tcp_.send_away();
      continue;
    }
    const TimePoint now = std::chrono::steady_clock::now();
    for (const bool from_terminal : {true, false}) {
      const std::size_t room = max_held_bytes - std::min(max_held_bytes, held_bytes_);
      std::vector<std::uint8_t> bytes = from_terminal ? terminal_->read(room) : tcp_.read(room);
      if (bytes.empty()) continue;
      held_bytes_ += bytes.size();
      chunks_.push_back({now, std::move(bytes)});
    }
  }
}

std::deque<SerialReader::Chunk> SerialReader::take(TimePoint& until) {
  const std::lock_guard lock(mutex_);
  until = std::chrono::steady_clock::now();
  held_bytes_ = 0;
  return std::exchange(chunks_, {});
}

void SerialReader::set_plugged(bool plugged) {
  const std::lock_guard lock(mutex_);
  if (plugged == (terminal_ != nullptr)) return;
  if (plugged) {
    terminal_ = std::make_unique<PseudoTerminal>(link_);
    return;
  }
  terminal_.reset();
  tcp_.send_away();
  chunks_.clear();
  held_bytes_ = 0;
}

std::string SerialReader::terminal() const {
  const std::lock_guard lock(mutex_);
  return terminal_ ? terminal_->path() : std::string{};
}

}  // namespace arkmesh::emulator
