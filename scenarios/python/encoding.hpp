// What is said between a lab and its scenario's process, as bytes: arrays for all robots, little-endian as every
// machine that arkmesh runs on. arkmesh_child.py is the other end; both are of one build.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "hal/overlay/colour.hpp"
#include "lab/lab.hpp"

namespace arkmesh::scenarios::python {

// By its name in docs. Throws std::runtime_error with the end of a sentence.
hal::Colour colour_named(const std::string& name);

static_assert(std::endian::native == std::endian::little);
// A number's bytes.
template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// [time in us, number], this lab's robots, in its arena and in the shared frame, its objects, and what robots have
// said.
std::string encode_frame(const lab::Lab& lab, const hal::PoseFrame& frame, std::span<const hal::FromRobot> heard);
// [time in us, period], then for each lab in the order of names its robots, as this arena sees them, and its fields.
// Of those that are `initial_only`, what state 0 held.
std::string encode_period(const lab::Lab& lab, std::span<const std::string> initial_only);

inline constexpr std::size_t word_bytes = 12;
struct Word {
  enum How : std::uint8_t { once, until_led_changes, shown, not_shown };
  hal::ToRobot message;
  How how = once;
};
// An answer is [bytes of words, words, JSON or nothing]. Both throw std::runtime_error with the end of a sentence for
// one that is too short.
std::string_view words_of(std::string_view answer);
std::string_view rest_of(std::string_view answer);
// Of the first word_bytes.
Word decode_word(std::string_view bytes);

}  // namespace arkmesh::scenarios::python
