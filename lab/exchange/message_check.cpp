#include "lab/exchange/message_check.hpp"

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/operator_command_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "arkmesh/world_t.hpp"
#include "hal/message_walker.hpp"

namespace arkmesh::lab {
namespace {

using Walker = hal::MessageWalker;

constexpr std::size_t min_text = Walker::min_text, robot_bytes = 17;

void walk_counters(Walker& w) {
  w.list(min_text + 8, [&] { w.text(), w.skip(8); });
}

void walk_state(Walker& w) {
  w.skip(4 + 8);                                        // period, hash
  w.array(robot_bytes);                                 // robots
  w.list(min_text + 4, [&] { w.text(), w.array(8); });  // fields
  w.list(2 * min_text, [&] { w.text(), w.text(); });    // settings
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
  w.skip(8 + 1 + 1);
  w.text();
  w.skip(1);
  w.text();
  w.list(4 + 1, [&] { w.skip(4 + 1); });
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
