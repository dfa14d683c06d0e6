#include "lab/message_check.hpp"

#include <cstdint>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/operator_command_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "arkmesh/world_t.hpp"

namespace arkmesh::lab {
namespace {

// Texts in our messages are names, reasons and settings; none is longer.
constexpr std::int32_t max_text = 4096;

class Walker {
 public:
  explicit Walker(std::span<const std::byte> bytes) : bytes_(bytes) {}

  void skip(std::size_t n) {
    if (n > left()) return fail("truncated");
    at_ += n;
  }
  std::uint64_t big_endian(std::size_t n) {
    if (n > left()) return fail("truncated"), 0;
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < n; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes_[at_ + i]);
    at_ += n;
    return value;
  }
  // A count of elements that take at least `min_bytes` each.
  std::int32_t count(std::size_t min_bytes) {
    const auto n = static_cast<std::int32_t>(big_endian(4));
    if (n < 0 || static_cast<std::size_t>(n) > left() / min_bytes) return fail("count"), 0;
    return n;
  }
  // LCM text: length with its final NUL, then the bytes.
  void text() {
    const auto n = static_cast<std::int32_t>(big_endian(4));
    if (!good()) return;
    if (n < 1 || n > max_text || static_cast<std::size_t>(n) > left()) return fail("text");
    for (std::int32_t i = 0; i < n; ++i)
      if ((bytes_[at_ + static_cast<std::size_t>(i)] == std::byte{0}) != (i == n - 1)) return fail("text");
    at_ += static_cast<std::size_t>(n);
  }
  template <class Each>
  void list(std::size_t min_bytes, Each each) {
    for (std::int32_t n = count(min_bytes); n > 0 && good(); --n) each();
  }
  void fingerprint(std::int64_t expected) {
    if (static_cast<std::int64_t>(big_endian(8)) != expected) fail("fingerprint");
  }
  bool good() const { return why_.empty(); }
  std::string_view verdict() {
    if (good() && left() != 0) fail("trailing");
    return why_;
  }

 private:
  std::size_t left() const { return bytes_.size() - at_; }
  void fail(std::string_view why) {
    if (why_.empty()) why_ = why;
    at_ = bytes_.size();
  }
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  std::string_view why_;
};

constexpr std::size_t min_text = 5, robot_bytes = 17;

void walk_counters(Walker& w) {
  w.list(min_text + 8, [&] { w.text(), w.skip(8); });
}

void walk_state(Walker& w) {
  w.skip(4 + 8);                                                                              // period, hash
  w.skip(robot_bytes * static_cast<std::size_t>(w.count(robot_bytes)));                       // robots
  w.list(min_text + 4, [&] { w.text(), w.skip(8 * static_cast<std::size_t>(w.count(8))); });  // fields
  w.list(2 * min_text, [&] { w.text(), w.text(); });                                          // settings
}

}  // namespace

std::string_view check_world(std::span<const std::byte> bytes) {
  Walker w(bytes);
  w.fingerprint(world_t::getHash());
  w.text();
  w.skip(8 + 1 + 1);                                     // run id, can_wait, done
  w.list(min_text + 12, [&] { w.text(), w.skip(12); });  // acks
  w.list(24, [&] { walk_state(w); });                    // window
  return w.verdict();
}

std::string_view check_status(std::span<const std::byte> bytes) {
  Walker w(bytes);
  w.fingerprint(lab_status_t::getHash());
  w.text();
  w.skip(8);
  w.text();
  w.skip(8 + 4 + 4 + 8 + 1);
  walk_counters(w);
  return w.verdict();
}

std::string_view check_peers(std::span<const std::byte> bytes) {
  Walker w(bytes);
  w.fingerprint(peers_t::getHash());
  w.text();
  w.skip(8);
  w.list(3 * min_text + 49, [&] {
    w.text();
    w.skip(1);
    w.text();
    w.skip(8);
    w.text();
    w.skip(3 * 8 + 8);
    w.list(min_text + 24, [&] { w.text(), w.skip(24); });
    walk_counters(w);
  });
  walk_counters(w);
  return w.verdict();
}

std::string_view check_operator_command(std::span<const std::byte> bytes) {
  Walker w(bytes);
  w.fingerprint(operator_command_t::getHash());
  w.text();
  w.skip(8 + 8 + 8);      // run id, number, clock
  w.skip(8 + 1 + 1 + 9);  // command
  w.skip(64);             // proof
  return w.verdict();
}

}  // namespace arkmesh::lab
