// The subcommands of `arkmesh`: each function adds one to the program. A callback ends the program with another code
// than 0 by throwing CLI::RuntimeError(code).
#pragma once

namespace CLI {
class App;
}

namespace arkmesh::cli {

void add_run_command(CLI::App& app);
void add_lab_command(CLI::App& app);
void add_gateway_command(CLI::App& app);
void add_doctor_command(CLI::App& app);
void add_controller_command(CLI::App& app);
void add_room_command(CLI::App& app);
void add_ohc_command(CLI::App& app);
void add_track_command(CLI::App& app);
void add_calibrate_command(CLI::App& app);
void add_identify_command(CLI::App& app);
void add_assign_ids_command(CLI::App& app);
void add_calibrate_motors_command(CLI::App& app);

}  // namespace arkmesh::cli
