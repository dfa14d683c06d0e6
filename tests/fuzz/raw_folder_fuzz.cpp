// A testbed's record from anywhere: serial.txt or looks.txt, as it is or behind the right head, and the head of a
// picture. Whatever comes, it is read, with times that never decrease and names of files that stay in their folder, or
// ends in one sentence with the file's name and line. What was read of a serial line goes to the emulated controller,
// and its messages are words of any layout.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <sstream>
#include <string>
#include <string_view>

#include "emulator/said_words.hpp"
#include "testbed/raw_folder.hpp"

namespace {

using namespace arkmesh;

void require(bool condition) {
  if (!condition) std::abort();
}

void require_sentence(const testbed::RecordError& error) {
  const std::string_view said = error.what();
  require(said.starts_with("fuzz.txt") && said.find('\n') == std::string_view::npos);
}

// Whatever the bytes, each group is a word of the layout, which packs into the same bytes.
void require_same_again(const hal::kilobot::Message& message, const hal::kilobot::WordLayout& layout) {
  hal::kilobot::Message again = message;
  for (std::size_t group = 0; group < hal::kilobot::groups; ++group) {
    const hal::kilobot::Word word = word_in(message, group, layout);
    require(word.robot <= nobody(layout) && word.kind < 1 << layout.kind_bits &&
            word.value < 1u << layout.value_bits());
    put_word(again, group, layout, word);
  }
  require(again.data == message.data);
}

void read_serial(const std::string& text, bool loses_power) {
  const std::size_t any = text.size();
  const hal::kilobot::WordLayout layout{static_cast<std::uint8_t>(7 + any % 4), static_cast<std::uint8_t>(any / 4 % 5),
                                        static_cast<std::uint8_t>(any % 118)};
  std::int64_t last_us = 0;
  bool short_enough = true;  // a week of one message repeated takes the controller seconds
  try {
    std::istringstream in(text);
    for (testbed::SerialLines lines(in, "fuzz.txt"); const auto event = lines.next();) {
      require(event->time_us >= last_us);
      last_us = event->time_us;
      short_enough = last_us < 600'000'000;
    }
    if (!short_enough) return;
    std::istringstream again(text);
    testbed::SerialLines lines(again, "fuzz.txt");
    std::int64_t before_us = INT64_MIN;
    emulator::replay_serial_line(lines, loses_power, [&](const sim_ode::Transmission& sent) {
      require(sent.start_us >= before_us);
      before_us = sent.start_us;
      require(!emulator::in_words(sent.message, layout).empty());
      require_same_again(sent.message, layout);
    });
  } catch (const testbed::RecordError& error) {
    require_sentence(error);
  }
}

void read_looks(const std::string& text) {
  hal::LabTime last{0};
  try {
    std::istringstream in(text);
    for (testbed::LookLines lines(in, "fuzz.txt"); const auto line = lines.next();) {
      const auto* const look = std::get_if<testbed::LookLine>(&*line);
      if (!look) continue;
      require(look->now >= last && !look->camera.empty() && look->camera.size() <= 4);
      last = look->now;
      for (const testbed::LookedAt& seen : look->camera)
        require(std::ranges::all_of(
                    seen.file, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || c == '.'; }) &&
                std::ranges::count(seen.file, '.') <= 1);
    }
  } catch (const testbed::RecordError& error) {
    require_sentence(error);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 5) {
    case 0:
      read_serial(text, false);
      break;
    case 1:
      read_serial(std::string(testbed::serial_head) + "\n" + text, true);
      break;
    case 2:
      read_looks(text);
      break;
    case 3:
      read_looks(std::string(testbed::looks_head) + "\n" + text);
      break;
    default:
      if (const auto found = testbed::picture_size(std::span(data, size).subspan(1)))
        require(found->first >= 0 && found->second >= 0);
  }
  return 0;
}
