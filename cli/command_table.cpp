#include "cli/command_table.hpp"

#include <algorithm>

namespace arkmesh::cli {
namespace {

constexpr CommandRow rows[] = {
    {"guide", "Say what to do next, from what lies in a folder and runs on this machine", light_program},
    {"run", "Run several labs in one process, as fast as they go", lab_program},
    {"batch", "Run a grid of settings and seeds, with tables and figures; goes on where it was stopped", lab_program},
    {"rerun", "Repeat a run from its folder alone, and say whether it gives the same", lab_program},
    {"lab", "Run one lab on its LCM bus; `arkmesh gateway` joins it with others", lab_program},
    {"view", "Show a lab that runs, or recorded runs, in a browser", lab_program},
    {"mark", "Stand in for a lab that runs the published M-ARK software (ARGoS, ARK-Qt)", lab_program},
    {"config", "List every key of a lab's file, or print a sample", ARKMESH_CAMERAS ? testbed_program : lab_program},
    {"gateway", "Join a lab's LCM bus with the other labs, over TCP", gateway_program},
    {"keys", "Make a lab's key and certificate, and say which labs its gateway lets in", gateway_program},
    {"explain", "Say which rule lets a channel pass between two labs, or why none does", gateway_program},
    {"reload", "Make the gateway of a lab read its rules again, without cutting its links", gateway_program},
    {"up", "Run the labs and gateways of some files as one, and end them together", light_program},
    {"status", "Show how a lab that runs and its links to others are", light_program},
    {"stop", "End a lab that runs, with its results", gateway_program},
    {"pause", "Pause the robots of a lab that runs", gateway_program},
    {"resume", "Let the robots of a lab go on", gateway_program},
    {"reset", "Make the robots of a lab begin their program again, and wait for resume", gateway_program},
    {"arm", "Let a lab that runs obey the operators of the labs that it names in safety.commands_from",
     gateway_program},
    {"disarm", "Let a lab obey its own operator only", gateway_program},
    {"export", "Write a recorded run as CSV, HDF5, MCAP or a film", recording_program},
    {"plot", "Draw recorded runs: a moment, or curves with mean and interval over runs", recording_program},
    {"publish", "Make an RO-Crate of a run or a batch: to cite, and to replay without arkmesh", recording_program},
    {"doctor", "Says what is wrong with this machine, and the command that mends it", light_program},
    {"scenario", "Begin a scenario of your own in Python", lab_program},
    {"controller", "Runs or checks a robot's program by itself", lab_program},
    {"emulator", "An emulated testbed: simulated Kilobots behind cameras and an overhead controller", testbed_program},
    {"ohc", "Drives an overhead controller by hand", light_program},
    {"testbed", "Records everything that passes a testbed's devices, and replays it", testbed_program},
    {"track", "Finds the robots on pictures; follows them in videos and before cameras", testbed_program},
    {"calibrate", "Makes a camera's calibration from pictures of a chessboard and of the arena's corners",
     testbed_program},
    {"identify", "Find out which robot in a lab's arena is which", testbed_program},
    {"assign-ids", "Give each robot in a lab's arena an id of its own", testbed_program},
    {"calibrate-motors", "Find and store the duties at which each robot turns and goes straight as it should",
     testbed_program},
};

}  // namespace

std::span<const CommandRow> command_table() {
  return rows;
}

const CommandRow* find_command(std::string_view name) {
  const auto row = std::ranges::find(rows, name, [](const CommandRow& r) { return std::string_view(r.name); });
  return row == std::end(rows) ? nullptr : row;
}

}  // namespace arkmesh::cli
