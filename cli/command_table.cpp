#include "cli/command_table.hpp"

#include <algorithm>

namespace arkmesh::cli {
namespace {

constexpr CommandRow rows[] = {
    {"guide", "Inspect a folder and this machine, and suggest the next command", light_program},
    {"run", "Run several labs in one process, as fast as possible", lab_program},
    {"batch", "Run a grid of settings and seeds, with tables and figures; resumable", lab_program},
    {"rerun", "Repeat a run from its folder, and compare the results", lab_program},
    {"lab", "Run one lab on its LCM bus; `arkmesh gateway` joins it with others", lab_program},
    {"view", "Show a running lab, or recorded runs, in a browser", lab_program},
    {"mark", "Stand in for a lab that runs the published M-ARK software (ARGoS, ARK-Qt)", lab_program},
    {"config", "List all configuration keys, or print a sample file", ARKMESH_CAMERAS ? testbed_program : lab_program},
    {"gateway", "Join a lab's LCM bus with those of other labs, over TCP", gateway_program},
    {"keys", "Create a lab's key and certificate, and choose the labs that its gateway trusts", gateway_program},
    {"explain", "Show which rule passes or blocks a channel between two labs", gateway_program},
    {"reload", "Reload the rules of a running gateway without cutting its links", gateway_program},
    {"up", "Start labs with their gateways, and end them together", light_program},
    {"status", "Show the state of a running lab and its links", light_program},
    {"stop", "End a running lab and write its results", gateway_program},
    {"pause", "Pause the robots of a running lab", gateway_program},
    {"resume", "Resume the robots of a running lab", gateway_program},
    {"reset", "Restart the programs of a lab's robots, which then wait for resume", gateway_program},
    {"arm", "Accept commands from operators of the labs in safety.commands_from", gateway_program},
    {"disarm", "Accept commands from the lab's own operator only", gateway_program},
    {"export", "Write a recorded run as CSV, HDF5, MCAP or a film", recording_program},
    {"plot", "Draw recorded runs: a moment, or curves with mean and interval over runs", recording_program},
    {"publish", "Package a run or batch as an RO-Crate, to cite and to replay without arkmesh", recording_program},
    {"fit", "Estimate the properties of a lab's own robots, for its simulation and tracker",
     ARKMESH_CAMERAS ? testbed_program : recording_program},
    {"doctor", "Check this machine or a lab's devices, and suggest remedies", gateway_program},
    {"scenario", "Create a scenario of your own, in Python or C++", lab_program},
    {"controller", "Run, check, build or prove a robot program", lab_program},
    {"emulator", "Run an emulated testbed: simulated Kilobots behind cameras and an overhead controller",
     testbed_program},
    {"ohc", "Control an overhead controller manually", light_program},
    {"testbed", "Record all traffic of a testbed's devices, and replay it", testbed_program},
    {"track", "Detect robots in images, and track them in videos and camera streams", testbed_program},
    {"calibrate", "Calibrate a camera from images of a chessboard and of the arena's corners", testbed_program},
    {"identify", "Identify the robots in a lab's arena", testbed_program},
    {"assign-ids", "Assign an id to each robot in a lab's arena", testbed_program},
    {"calibrate-motors", "Calibrate the motors of each robot for turns and straight motion", testbed_program},
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
