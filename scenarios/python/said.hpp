// What a scenario in Python says in JSON, as what the lab takes. All throw std::exception for what makes no sense.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "lab/lab.hpp"

namespace arkmesh::scenarios::python {

// What an answer says. A type of its own, so that it is read by functions that were optimized for here: of what
// templates make, the linker keeps one copy, wherever it was compiled.
using Said = nlohmann::ordered_json;

// The value in force of a setting that the scenario has declared.
nlohmann::json setting_in_force(const hal::Section& settings, const nlohmann::json& asked);

// Bytes as hexadecimal digits.
std::vector<std::uint8_t> bytes_in(std::string_view digits);

// An obstacle or object of the arena, for the scenario.
nlohmann::json solid(const hal::Shape& shape, const hal::Pose& at, const std::string& name);

void draw(lab::Lab& lab, const Said& drawn);

std::vector<hal::ToRobot> whole_messages(const Said& given);

}  // namespace arkmesh::scenarios::python
