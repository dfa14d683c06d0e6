// Commands of operators as messages: on which channel, and what their proof is about.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "arkmesh/fleet_command_t.hpp"
#include "arkmesh/operator_command_t.hpp"

namespace arkmesh::lab {

// On the lab's public bus; what the lab says to operators.
inline const std::string operator_channel = "operator_command", answer_channel = "operator_answer";

// What operators may say.
struct OperatorWord {
  std::string_view name;
  std::uint8_t command;
  std::string_view done;  // what is said of the lab afterwards
  bool makes_stand;       // robots are to be seen to stand
  bool at_others;         // may be given to another lab, and to all of the world
};
inline constexpr OperatorWord operator_words[] = {
    {"stop", operator_command_t::stop, "ended at period", true, true},
    {"pause", fleet_command_t::pause, "paused its robots at period", true, true},
    {"resume", fleet_command_t::run, "resumed its robots at period", false, true},
    {"reset", fleet_command_t::reset, "reset its robots, which wait for resume, at period", true, false},
    {"arm", operator_command_t::arm, "accepts commands from other labs' operators from period", false, false},
    {"disarm", operator_command_t::disarm, "accepts commands from its own operator only, from period", false, false}};

// Its name; of what is no word of theirs its number.
std::string word_of(int command);

// Asks labs for a challenge and their status.
operator_command_t question();

// The bytes that its proof is made of.
std::vector<std::uint8_t> proved_bytes(operator_command_t message);

// Why STOP of all labs at `lab` passes by a lab that does not obey its operator.
std::string not_obeyed(std::string_view by, std::string_view lab);
// Of another lab that is there, but answers no question.
std::string not_reached(std::string_view lab);

}  // namespace arkmesh::lab
