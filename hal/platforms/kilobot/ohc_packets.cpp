#include "hal/platforms/kilobot/ohc_packets.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <string_view>

namespace arkmesh::hal::kilobot {

namespace {

// The robots' calibration message: what it is to set; its id; its duties, turning left and right, and both going
// straight.
enum class Calibrate : std::uint8_t { save = 0, id = 1, left = 2, right = 3, straight = 4 };

Packet calibrate_packet(Calibrate what, std::uint16_t id, std::array<std::uint8_t, 4> duties) {
  const std::array<std::uint8_t, 9> data{static_cast<std::uint8_t>(what),
                                         static_cast<std::uint8_t>(id),
                                         static_cast<std::uint8_t>(id >> 8),
                                         duties[0],
                                         duties[1],
                                         duties[2],
                                         duties[3]};
  return forward_packet(Message{data, type_calibrate, 0});
}

std::uint8_t parse_duty(const std::string& text, const std::string& name) {
  return static_cast<std::uint8_t>(parse_number(text, 255, name));
}

}  // namespace

std::uint16_t parse_number(const std::string& text, int most, const std::string& name) {
  const bool hex = text.starts_with("0x") || text.starts_with("0X");
  const std::string_view digits = std::string_view(text).substr(hex ? 2 : 0);
  int value = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, hex ? 16 : 10);
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size() || value < 0 || value > most)
    throw WrongWord(name, fmt::format("'{}' is not a number from 0 to {}", text, most));
  return static_cast<std::uint16_t>(value);
}

Packet plain_packet(std::uint8_t type) {
  return forward_packet(Message{{}, type, 0});
}

std::vector<Packet> set_id_packets(std::uint16_t id) {
  return {calibrate_packet(Calibrate::id, id, {}), save_packet()};
}

Packet turn_left_packet(const std::string& duty) {
  return calibrate_packet(Calibrate::left, 0, {parse_duty(duty, "DUTY"), 0, 0, 0});
}

Packet turn_right_packet(const std::string& duty) {
  return calibrate_packet(Calibrate::right, 0, {0, parse_duty(duty, "DUTY"), 0, 0});
}

Packet straight_packet(const std::string& left, const std::string& right) {
  return calibrate_packet(Calibrate::straight, 0, {0, 0, parse_duty(left, "LEFT"), parse_duty(right, "RIGHT")});
}

Packet save_packet() {
  return calibrate_packet(Calibrate::save, 0, {});
}

Packet message_packet(const std::vector<std::string>& numbers) {
  const std::uint16_t type = parse_number(numbers.at(0), 255, "TYPE");
  if (type > 127)
    throw WrongWord(
        "TYPE",
        fmt::format(
            "{} is reserved for the robots' library; programs use 0 to 127, and commands have names: run, pause, ...",
            type));
  if (numbers.size() > 10) throw WrongWord("BYTES", fmt::format("a message holds 9 bytes, not {}", numbers.size() - 1));
  std::array<std::uint8_t, 9> data{};
  for (std::size_t i = 1; i < numbers.size(); ++i)
    data[i - 1] = static_cast<std::uint8_t>(parse_number(numbers[i], 255, "BYTES"));
  return forward_packet(Message{data, static_cast<std::uint8_t>(type), 0});
}

}  // namespace arkmesh::hal::kilobot
