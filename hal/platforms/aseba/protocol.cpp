#include "hal/platforms/aseba/protocol.hpp"

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <utility>

namespace arkmesh::hal::aseba {
namespace {

constexpr std::uint16_t most_event_types = 0x1000;  // more than any program handles
constexpr std::size_t most_variables = 1024, description_words = 7;

std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t place) {
  return boost::endian::load_little_u16(&bytes[place]);
}

// Whether a message may begin like this; all types that carry words only have an even length.
bool is_header(std::span<const std::uint8_t> bytes) {
  const std::size_t length = word_at(bytes, 0);
  const std::uint16_t type = word_at(bytes, 4);
  const bool text = type >= description && type < description + 0x10;
  const bool known = type < most_event_types || text || (type >= 0xA000 && type < 0xA020);
  return length <= largest_payload && known && (text || length % 2 == 0);
}

// A byte of length and as many characters, off the front; what cannot be printed becomes a question mark.
std::optional<std::string> take_text(std::span<const std::uint8_t>& bytes) {
  if (bytes.empty() || bytes[0] >= bytes.size()) return {};
  std::string out(bytes.begin() + 1, bytes.begin() + 1 + bytes[0]);
  std::ranges::replace_if(
      out, [](char c) { return c <= ' ' || c > '~'; }, '?');
  bytes = bytes.subspan(1 + out.size());
  return out;
}

}  // namespace

Message make_message(std::uint16_t type, std::span<const int> words) {
  Message out{.source = 0, .type = type, .payload = std::vector<std::uint8_t>(2 * words.size())};
  for (std::size_t i = 0; i < words.size(); ++i)
    boost::endian::store_little_u16(&out.payload[2 * i], static_cast<std::uint16_t>(words[i]));
  return out;
}

std::vector<std::uint8_t> encode(const Message& message) {
  std::vector<std::uint8_t> out(header_bytes + message.payload.size());
  boost::endian::store_little_u16(&out[0], static_cast<std::uint16_t>(message.payload.size()));
  boost::endian::store_little_u16(&out[2], message.source);
  boost::endian::store_little_u16(&out[4], message.type);
  std::ranges::copy(message.payload, out.begin() + header_bytes);
  return out;
}

std::vector<int> words_of(const Message& message) {
  std::vector<int> out;
  for (std::size_t i = 0; i + 1 < message.payload.size(); i += 2)
    out.push_back(static_cast<std::int16_t>(word_at(message.payload, i)));
  return out;
}

std::vector<Message> MessageReader::read(std::span<const std::uint8_t> bytes) {
  held_.insert(held_.end(), bytes.begin(), bytes.end());
  std::span<const std::uint8_t> rest(held_);
  std::vector<Message> messages;
  while (rest.size() >= header_bytes) {
    if (!is_header(rest)) {  // one may begin at the next byte
      ++damaged_bytes_;
      rest = rest.subspan(1);
      continue;
    }
    const std::size_t length = header_bytes + word_at(rest, 0);
    if (rest.size() < length) break;
    messages.push_back({word_at(rest, 2), word_at(rest, 4), {rest.begin() + header_bytes, rest.begin() + length}});
    rest = rest.subspan(length);
  }
  held_.erase(held_.begin(), held_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  return messages;
}

void MessageReader::cut() {
  damaged_bytes_ += held_.size();
  held_.clear();
}

std::vector<Message> MessageReader::give_up() {
  std::vector<Message> out;
  while (out.empty() && waits()) {
    ++damaged_bytes_;
    held_.erase(held_.begin());
    out = read({});
  }
  return out;
}

bool Description::take(const Message& message) {
  const bool good = message.type == description ? begin(message.payload) : add(message.payload);
  if (!good) *this = {};
  return good;
}

bool Description::begin(std::span<const std::uint8_t> payload) {
  *this = {};
  const auto name = take_text(payload);
  if (!name || payload.size() != 2 * description_words) return false;
  name_ = *name;
  words_ = word_at(payload, 6);
  promised_ = word_at(payload, 8);
  return *promised_ <= most_variables;
}

bool Description::add(std::span<const std::uint8_t> payload) {
  if (!promised_ || complete() || payload.size() < 2) return false;
  const std::uint16_t size = word_at(payload, 0);
  payload = payload.subspan(2);
  const auto name = take_text(payload);
  if (!name || !payload.empty() || size == 0 || used_words_ + size > words_) return false;
  const bool fresh = variables_.emplace(*name, Variable{static_cast<std::uint16_t>(used_words_), size}).second;
  used_words_ += size;
  return fresh;
}

std::optional<Variable> Description::find(std::string_view name) const {
  const auto found = variables_.find(name);
  return found == variables_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace arkmesh::hal::aseba
