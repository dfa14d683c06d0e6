#include "hal/platforms/kilobot/ohc_packets.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <string_view>

namespace arkmesh::hal::kilobot {

using namespace hal::kilobot;

std::uint16_t parse_number(const std::string& text, int most, const std::string& what) {
  const bool hex = text.starts_with("0x") || text.starts_with("0X");
  const std::string_view digits = std::string_view(text).substr(hex ? 2 : 0);
  int value = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, hex ? 16 : 10);
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size() || value < 0 || value > most)
    throw CLI::ValidationError(what, fmt::format("'{}' is no number from 0 to {}", text, most));
  return static_cast<std::uint16_t>(value);
}

Packet plain_packet(std::uint8_t type) {
  return forward_packet(Message{{}, type, 0});
}

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

Packet message_packet(const std::vector<std::string>& numbers) {
  const std::uint16_t type = parse_number(numbers.at(0), 255, "TYPE");
  if (type > 127)
    throw CLI::ValidationError(
        "TYPE",
        fmt::format(
            "{} belongs to the robots' library; programs have 0 to 127, and commands have names: run, pause, ...",
            type));
  if (numbers.size() > 10)
    throw CLI::ValidationError("BYTES", fmt::format("a message holds 9 bytes, not {}", numbers.size() - 1));
  std::array<std::uint8_t, 9> data{};
  for (std::size_t i = 1; i < numbers.size(); ++i)
    data[i - 1] = static_cast<std::uint8_t>(parse_number(numbers[i], 255, "BYTES"));
  return forward_packet(Message{data, static_cast<std::uint8_t>(type), 0});
}

}  // namespace arkmesh::hal::kilobot
