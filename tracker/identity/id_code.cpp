#include "tracker/identity/id_code.hpp"

#include <algorithm>

namespace arkmesh::tracker {
namespace {

constexpr std::uint32_t check_modulus = 23;

// 0..22 to three digits in base 3 that are not all equal: 0, 13 and 26 are left out.
constexpr std::uint32_t check_word(hal::RobotId robot) {
  const std::uint32_t rest = robot % check_modulus;
  return rest + (rest < 12 ? 1 : 2);
}

constexpr std::uint32_t power_of_3(int n) {
  std::uint32_t out = 1;
  for (; n > 0; --n) out *= 3;
  return out;
}

void put(Question& message, std::size_t at, hal::RobotId robot) {
  message.data[at] = static_cast<std::uint8_t>(robot >> 8);
  message.data[at + 1] = static_cast<std::uint8_t>(robot);
}

constexpr auto orders = [] {
  std::array<std::array<std::uint8_t, max_id_digits + check_digits>, max_id_digits + 1> out{};
  for (std::size_t n = 0; n <= max_id_digits; ++n) {
    for (std::size_t i = 0; i < n; ++i) out[n][i] = static_cast<std::uint8_t>(i);
    for (std::size_t i = 0; i < check_digits; ++i) out[n][n + i] = static_cast<std::uint8_t>(max_id_digits + i);
  }
  return out;
}();

}  // namespace

int id_digits(hal::RobotId largest) {
  int n = 1;
  while (n < max_id_digits && power_of_3(n) <= largest) ++n;
  return n;
}

std::span<const std::uint8_t> digit_order(int digits) {
  const auto n = static_cast<std::size_t>(std::clamp(digits, 1, max_id_digits));
  return std::span(orders[n]).first(n + check_digits);
}

hal::Led answer_of(const Track& track) {
  constexpr float clear = 0.25F;
  if (track.primary_confidence > 0) return track.primary_confidence >= clear ? track.primary : hal::Led::off;
  return track.led_seen && digit_of(track.led) ? track.led : hal::Led::off;
}

hal::Led spelled(hal::RobotId robot, int number) {
  const std::uint32_t word = number < max_id_digits ? robot : check_word(robot);
  const std::uint32_t digit = word / power_of_3(number < max_id_digits ? number : number - max_id_digits) % 3;
  return digit == 0 ? hal::Led::red : digit == 1 ? hal::Led::green : hal::Led::blue;
}

std::optional<hal::RobotId> id_of(std::span<const std::uint8_t> digits) {
  if (digits.size() <= check_digits) return std::nullopt;
  const std::size_t n = digits.size() - check_digits;
  std::uint32_t robot = 0, word = 0;
  for (std::size_t i = n; i-- > 0;) robot = robot * 3 + digits[i];
  for (std::size_t i = digits.size(); i-- > n;) word = word * 3 + digits[i];
  if (robot > largest_spelled_id || word != check_word(robot)) return std::nullopt;
  return robot;
}

bool Audience::includes(hal::RobotId robot) const {
  switch (kind) {
    case Kind::everybody:
      return true;
    case Kind::range:
      return robots[0] <= robot && robot <= robots[1];
    case Kind::list:
      return robot != nobody && std::find(robots.begin(), robots.end(), robot) != robots.end();
  }
  return false;
}

Audience audience_for(std::span<const hal::RobotId> wanted, std::span<const hal::RobotId> spared, std::size_t turn) {
  Audience out{.kind = Audience::Kind::list};
  out.robots.fill(nobody);
  if (wanted.size() > out.robots.size()) {
    const auto next = std::lower_bound(spared.begin(), spared.end(), wanted.front());
    if (next == spared.end() || *next > wanted.back())
      return {.kind = Audience::Kind::range, .robots = {wanted.front(), wanted.back()}};
  }
  for (std::size_t i = 0; i < std::min(wanted.size(), out.robots.size()); ++i)
    out.robots[i] = wanted[(turn + i) % wanted.size()];
  return out;
}

Question digit_question(const Audience& audience, int number) {
  Question message{.type = question_type};
  message.data[0] =
      static_cast<std::uint8_t>(static_cast<unsigned>(audience.kind) << 6 | static_cast<unsigned>(number));
  const std::size_t ids = audience.kind == Audience::Kind::list ? 4 : audience.kind == Audience::Kind::range ? 2 : 0;
  for (std::size_t i = 0; i < ids; ++i) put(message, 1 + 2 * i, audience.robots[i]);
  return message;
}

Question end_of_questions() {
  return {.type = question_type};
}

Question ark_question(std::uint8_t type, hal::RobotId robot) {
  Question message{.type = type};
  put(message, 0, robot);
  return message;
}

}  // namespace arkmesh::tracker
