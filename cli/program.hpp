// What all programs of arkmesh are made of: the commands of their own, and handing over those of others.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cli/command_table.hpp"
#include "hal/record/outcome.hpp"

namespace CLI {
class App;
}

namespace arkmesh::cli {

// A command that a program runs itself.
struct OwnCommand {
  const char* name;
  void (*add)(CLI::App* command);
};

// Runs what the command line asks for, in this process or by becoming the program that has it: process id, signals and
// exit code stay the caller's own. Returns the exit code; every failure is one sentence.
int main(int argc, char** argv, std::span<const OwnCommand> own);

// What `work` returns; when it throws, that of the failure, which is said in one sentence.
int exit_code_of(const std::function<int()>& work);

// Of a command that ran labs, or did something else, with this outcome.
int exit_code(hal::Outcome outcome);

// Two numbers of one word of the command line, such as 1x0.5 or 0.2,-0.1. Empty when `text` is not two numbers with
// `between` between them and nothing else.
std::optional<std::pair<double, double>> two_numbers(const std::string& text, char between);

// Ends the command that runs with this exit code.
void end_with(int code);

// Becomes the program with cameras when the arena of one of these labs' files needs it and this program has none.
// Returns otherwise, also when a file is wrong: reading it properly says how. For commands of a program that runs
// simulated labs only; to be called before anything else is done.
void hand_over_cameras(const std::vector<std::string>& files, const std::vector<std::string>& sets);

}  // namespace arkmesh::cli
