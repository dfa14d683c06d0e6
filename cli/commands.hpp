// The subcommands of `arkmesh`: each function adds one to the program. A callback ends the program with another code
// than 0 by throwing CLI::RuntimeError(code).
#pragma once

#include <vector>

namespace CLI {
class App;
}

namespace arkmesh::hal {
class Section;
struct Finding;
}  // namespace arkmesh::hal

namespace arkmesh::cli {

void add_run_command(CLI::App& app);
void add_batch_command(CLI::App& app);
void add_rerun_command(CLI::App& app);
void add_lab_command(CLI::App& app);
void add_view_command(CLI::App& app);
void add_mark_command(CLI::App& app);
void add_gateway_command(CLI::App& app);
void add_keys_command(CLI::App& app);
void add_explain_command(CLI::App& app);
void add_reload_command(CLI::App& app);
void add_up_command(CLI::App& app);
void add_status_command(CLI::App& app);
void add_stop_command(CLI::App& app);
void add_pause_command(CLI::App& app);
void add_resume_command(CLI::App& app);
void add_reset_command(CLI::App& app);
void add_arm_command(CLI::App& app);
void add_disarm_command(CLI::App& app);
void add_config_command(CLI::App& app);
// `examine_testbed`: what is to be said of the hardware that [arena] names; null in a program without cameras.
void add_doctor_command(CLI::App& app, std::vector<hal::Finding> (*examine_testbed)(const hal::Section& arena));
void add_export_command(CLI::App& app);
void add_plot_command(CLI::App& app);
void add_controller_command(CLI::App& app);
void add_emulator_command(CLI::App& app);
void add_ohc_command(CLI::App& app);
void add_testbed_command(CLI::App& app);
void add_track_command(CLI::App& app);
void add_calibrate_command(CLI::App& app);
void add_identify_command(CLI::App& app);
void add_assign_ids_command(CLI::App& app);
void add_calibrate_motors_command(CLI::App& app);

}  // namespace arkmesh::cli
