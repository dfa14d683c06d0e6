// Messages of any type as JSON.
#pragma once

#include <span>
#include <string>

#include "hal/layout/message.hpp"

namespace arkmesh::recording {

// Appends a message that check() has passed: an object with its fields; lists as arrays, bytes as whole numbers,
// numbers that JSON does not have (NaN, infinity) as null.
void append_json(std::string& to, const hal::layout::Type& type, std::span<const std::byte> message);
// A text in quotes; bytes that are not UTF-8 become U+FFFD.
void append_json_text(std::string& to, std::string_view text);

}  // namespace arkmesh::recording
