// What Aseba nodes (Thymio II, e-puck, their simulators and switches) say and hear on a line: messages as bytes, and
// the description in which a node names its variables. Pure functions; knows no line, no clock and no robot's make.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::hal::aseba {

// Types of messages. The lowest are events, by their place in the network's list of events.
enum Type : std::uint16_t {
  description = 0x9000,     // from a node
  variable_named = 0x9001,  // one for each variable, in the order of their addresses
  variables = 0x9005,       // start, values
  out_of_bounds = 0x9006,   // these three: the node's program failed
  division_by_zero = 0x9007,
  event_killed = 0x9008,
  node_present = 0x900C,  // protocol
  reset = 0xA002,         // to a node: all begin with its number
  run = 0xA003,
  pause = 0xA004,
  get_variables = 0xA00B,    // start, count
  set_variables = 0xA00C,    // start, values
  get_description = 0xA010,  // protocol
  list_nodes = 0xA011,       // to all: protocol
};
inline constexpr int protocol_version = 5;

// The first events of the network's list, which the robots' program and the lab agree on.
enum Event : std::uint16_t {
  event_run = 0,   // to all: a RunWord; repeated, so that a robot without it knows that it is alone
  event_word = 1,  // the node's number, kind, value
  event_says = 2,  // from a robot: kind, value
  event_here = 3,  // from a robot, at each event_run and each change: the LED's colour, whether it stopped being alone
};
enum RunWord : std::uint8_t { stand_still, run_program, only_answer };

struct Message {
  std::uint16_t source = 0;  // a node's number; 0: a computer
  std::uint16_t type = 0;
  std::vector<std::uint8_t> payload;  // mostly words of 16 bits, little-endian
  bool is_event() const { return type < 0x8000; }
  bool operator==(const Message&) const = default;
};

inline constexpr std::size_t header_bytes = 6, largest_payload = 1024;

// Values are cut to 16 bits; at most largest_payload / 2 of them.
Message make_message(std::uint16_t type, std::span<const int> words);
inline Message make_message(std::uint16_t type, std::initializer_list<int> words) {
  return make_message(type, std::span(words.begin(), words.size()));
}
// The payload has at most largest_payload bytes.
std::vector<std::uint8_t> encode(const Message& message);
// The payload as signed words; a last odd byte is left out.
std::vector<int> words_of(const Message& message);

// Finds messages in a stream that may lose, change or add bytes. A message has no checksum: what has the length and the
// type of one counts as one.
class MessageReader {
 public:
  // The messages that are complete with these bytes.
  std::vector<Message> read(std::span<const std::uint8_t> bytes);
  // The beginning of a message waits for the rest.
  bool waits() const { return !held_.empty(); }
  // The line was cut: what is held belongs to nothing.
  void cut();
  // The rest does not come: what looked like a beginning is none. The messages that were taken for its inside.
  std::vector<Message> give_up();
  // Bytes that belonged to no message.
  std::uint64_t damaged_bytes() const { return damaged_bytes_; }

 private:
  std::vector<std::uint8_t> held_;  // shorter than the largest message between two calls
  std::uint64_t damaged_bytes_ = 0;
};

struct Variable {
  std::uint16_t start = 0, size = 0;
  bool operator==(const Variable&) const = default;
};

// What a node says of itself, message by message.
class Description {
 public:
  // Takes a message of type `description`, which begins anew, or `variable_named`. False: it is damaged, or contradicts
  // what came before, and the node must be asked again.
  bool take(const Message& message);
  bool complete() const { return promised_ && variables_.size() == *promised_; }
  // Printable ASCII.
  const std::string& name() const { return name_; }
  const std::map<std::string, Variable, std::less<>>& all() const { return variables_; }
  // Nothing: there is none of that name.
  std::optional<Variable> find(std::string_view name) const;

 private:
  bool begin(std::span<const std::uint8_t> payload);
  bool add(std::span<const std::uint8_t> payload);

  std::string name_;
  std::optional<std::size_t> promised_;
  std::size_t words_ = 0, used_words_ = 0;  // of memory for variables
  std::map<std::string, Variable, std::less<>> variables_;
};

}  // namespace arkmesh::hal::aseba
