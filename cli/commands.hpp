// The commands of `arkmesh`: each function gives one its options and what it does. A callback ends the program with
// another code than 0 by end_with(). And which commands each program runs itself.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "cli/program.hpp"

namespace CLI {
class Option;
}

namespace arkmesh::hal {
class Section;
struct Finding;
}  // namespace arkmesh::hal

namespace arkmesh::cli {

void add_guide_command(CLI::App* command);
void add_run_command(CLI::App* command);
void add_batch_command(CLI::App* command);
void add_rerun_command(CLI::App* command);
void add_lab_command(CLI::App* command);
void add_view_command(CLI::App* command);
void add_mark_command(CLI::App* command);
void add_config_command(CLI::App* command);
void add_controller_command(CLI::App* command);
void add_scenario_command(CLI::App* command);
void add_gateway_command(CLI::App* command);
void add_keys_command(CLI::App* command);
void add_explain_command(CLI::App* command);
void add_reload_command(CLI::App* command);
void add_up_command(CLI::App* command);
void add_status_command(CLI::App* command);
void add_ohc_command(CLI::App* command);
void add_export_command(CLI::App* command);
// What `fit robots` asks of an arena: a table of its robots' tracks.
struct WalkOptions {
  std::string file, ids, table;
  std::vector<std::string> sets;
  double seconds = 300;
};
using RecordWalks = void (*)(const WalkOptions&);
// `record_walks`: null in a program without cameras.
void add_fit_command(CLI::App* command, RecordWalks record_walks);
void record_walks(const WalkOptions& options);
void add_plot_command(CLI::App* command);
void add_publish_command(CLI::App* command);
// --width, --xlabel, --ylabel and --title of a figure, into `looks` by these names.
std::vector<CLI::Option*> add_looks(CLI::App* command, std::map<std::string, std::string>& looks);
void add_emulator_command(CLI::App* command);
void add_testbed_command(CLI::App* command);
void add_track_command(CLI::App* command);
void add_calibrate_command(CLI::App* command);
void add_identify_command(CLI::App* command);
void add_assign_ids_command(CLI::App* command);
void add_calibrate_motors_command(CLI::App* command);
// `stop`, `pause`, `resume`, `reset`, `arm` or `disarm`, by its name.
void add_operator_command(CLI::App* command);
// `examine_testbed`: what is to be said of the hardware that [arena] names; null in a program without cameras.
void add_doctor_command(CLI::App* command, std::vector<hal::Finding> (*examine_testbed)(const hal::Section& arena));

inline constexpr OwnCommand light_commands[] = {
    {"guide", add_guide_command}, {"up", add_up_command}, {"status", add_status_command}, {"ohc", add_ohc_command}};
inline constexpr OwnCommand gateway_commands[] = {
    {"doctor", [](CLI::App* command) { add_doctor_command(command, nullptr); }},
    {"gateway", add_gateway_command},
    {"keys", add_keys_command},
    {"stop", add_operator_command},
    {"pause", add_operator_command},
    {"resume", add_operator_command},
    {"reset", add_operator_command},
    {"arm", add_operator_command},
    {"disarm", add_operator_command},
    {"explain", add_explain_command},
    {"reload", add_reload_command}};
// `config` is another program's where that is there (cli/program.cpp): its keys are those of all arenas.
inline constexpr OwnCommand lab_commands[] = {
    {"config", add_config_command}, {"run", add_run_command},           {"batch", add_batch_command},
    {"rerun", add_rerun_command},   {"lab", add_lab_command},           {"view", add_view_command},
    {"mark", add_mark_command},     {"scenario", add_scenario_command}, {"controller", add_controller_command}};
inline constexpr OwnCommand recording_commands[] = {
    {"export", add_export_command},
    {"plot", add_plot_command},
    {"publish", add_publish_command},
    {"fit", [](CLI::App* command) { add_fit_command(command, nullptr); }}};

}  // namespace arkmesh::cli
