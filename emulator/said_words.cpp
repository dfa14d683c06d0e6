#include "emulator/said_words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>
#include <vector>

#include "hal/counted.hpp"

namespace arkmesh::emulator {
namespace {

using hal::kilobot::Message;
using testbed::SerialEvent;

constexpr std::int64_t step_us = 1'000'000;  // at most so much at once: the device keeps what was not asked for
constexpr std::int64_t started_before_us = 3'000'000;  // longer than its start-up

std::string composite(const Message& message, const hal::kilobot::WordLayout& layout) {
  std::vector<std::string> parts;
  for (std::size_t group = 0; group < hal::kilobot::groups; ++group) {
    const hal::kilobot::Word word = word_in(message, group, layout);
    if (word.robot == nobody(layout)) continue;
    const std::string kind = layout.kind_bits > 0 ? fmt::format("kind {} ", word.kind) : "";
    parts.push_back(fmt::format("to {}: {}value {}", word.robot, kind, word.value));
  }
  return parts.empty() ? "to nobody" : fmt::format("{}", fmt::join(parts, ", "));
}

std::string calibration_words(const Message& message) {
  const auto& data = message.data;
  switch (data[0]) {
    case 0:
      return "save duties and id";
    case 1:
      return fmt::format("set id {}", data[1] | data[2] << 8);
    case 2:
      return fmt::format("turn left with duty {}", data[3]);
    case 3:
      return fmt::format("turn right with duty {}", data[4]);
    case 4:
      return fmt::format("go straight with duties {} and {}", data[5], data[6]);
    default:
      return "calibration";
  }
}

}  // namespace

void replay_serial_line(testbed::SerialLines& lines, bool loses_power, const Listener& listener) {
  OhcSerialPort port(1);
  const std::int64_t shift_us = loses_power ? 0 : started_before_us;
  std::vector<sim_ode::Transmission> sent;
  std::int64_t now_us = 0;
  const auto advance = [&](std::int64_t until_us) {
    while (now_us < until_us) {
      now_us = std::min(until_us, now_us + step_us);
      sent.clear();
      port.sent_until(now_us, sent);
      for (sim_ode::Transmission& message : sent) {
        message.start_us -= shift_us;
        message.end_us -= shift_us;
        listener(message);
      }
    }
  };
  while (const auto event = lines.next()) {
    advance(event->time_us + shift_us);
    switch (event->kind) {
      case SerialEvent::Kind::wrote:
        for (std::span<const std::uint8_t> bytes = event->bytes; !bytes.empty();) {
          const std::size_t fits = std::min(bytes.size(), port.free());
          port.write(bytes.first(fits), now_us);
          bytes = bytes.subspan(fits);
          if (!bytes.empty()) advance(now_us + step_us);
        }
        break;
      case SerialEvent::Kind::open:
        if (loses_power) port.plug_in(now_us);
        break;
      case SerialEvent::Kind::closed:
        if (loses_power) port.unplug(now_us);
        break;
      case SerialEvent::Kind::opening:
      case SerialEvent::Kind::heard:
      case SerialEvent::Kind::end:
        break;
    }
  }
}

std::string in_words(const Message& message, const hal::kilobot::WordLayout& layout) {
  using namespace hal::kilobot;
  static constexpr const char* library[] = {
      "boot loader", "flash page", "size of a program",    "reset",    "sleep", "pause", "charge",
      "voltage",     "run",        "show a bit of the id", "calibrate"};
  if (message.type == type_calibrate) return calibration_words(message);
  if (message.type == type_boot_page)
    return fmt::format("flash page {}, from word {}", message.data[0], message.data[1]);
  if (message.type == type_boot_size) return fmt::format("a program of {}", hal::counted(message.data[0], "page"));
  if (message.type == type_read_uid) return fmt::format("show bit {} of the id", message.data[0]);
  if (message.type >= type_boot && message.type <= type_calibrate) return library[message.type - type_boot];
  if (message.type == layout.type) return composite(message, layout);
  if (message.type >= 118 && message.type <= 120)  // tracker/identity/id_code.hpp
    return fmt::format("identification query {}: {:02x}", message.type, fmt::join(message.data, " "));
  return fmt::format("type {}: {:02x}", message.type, fmt::join(message.data, " "));
}

}  // namespace arkmesh::emulator
