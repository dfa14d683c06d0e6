// Commands of operators as messages: on which channel, and what their proof is about.
#pragma once

#include <csignal>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/operator_command_t.hpp"
#include "hal/child_process.hpp"
#include "hal/files/own_files.hpp"

namespace arkmesh::lab {

// On the lab's public bus; what the lab says to operators.
inline const std::string operator_channel = "operator_command", answer_channel = "operator_answer";

// Asks labs for a challenge and their status.
operator_command_t question();

// The bytes that its proof is made of.
std::vector<std::uint8_t> proved_bytes(operator_command_t message);

// Whether the lab whose status this is obeys the operator of `lab`; and why STOP of all labs passes it by, when it does
// not.
bool obeys(const lab_status_t& status, std::string_view lab);
std::string not_obeyed(std::string_view by, std::string_view lab);
// Of another lab that is there, but answers no question.
std::string not_reached(std::string_view lab);

// A process of this program that tells another lab and says what came of it: `arkmesh WORD --at LAB FILE`, with the own
// lab's file and KEY=VALUE that count before what is in it.
inline hal::ChildStart to_tell(const std::string& lab, std::string_view word, const std::string& own_file,
                               const std::vector<std::string>& sets) {
  hal::ChildStart start{.command = {hal::this_program().string(), std::string(word), "--at", lab, own_file},
                        .last_signal = SIGTERM};
  for (const std::string& set : sets) start.command.insert(start.command.end(), {"--set", set});
  return start;
}

}  // namespace arkmesh::lab
