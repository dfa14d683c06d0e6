#include "cli/whole_program.hpp"

#include <iterator>
#include <utility>

#include "cli/commands.hpp"
#include "cli/program.hpp"
#if ARKMESH_CAMERAS
#include "testbed/devices.hpp"
#endif

namespace arkmesh::cli {

int main(int argc, char** argv, std::vector<app::CatalogueEntry> extra_scenarios) {
  app::catalogue().insert(app::catalogue().end(), std::make_move_iterator(extra_scenarios.begin()),
                          std::make_move_iterator(extra_scenarios.end()));
  static constexpr OwnCommand own[] = {
    {"run", add_run_command},
    {"batch", add_batch_command},
    {"rerun", add_rerun_command},
    {"lab", add_lab_command},
    {"view", add_view_command},
    {"mark", add_mark_command},
    {"gateway", add_gateway_command},
    {"keys", add_keys_command},
    {"explain", add_explain_command},
    {"reload", add_reload_command},
    {"up", add_up_command},
    {"stop", add_stop_command},
    {"status", add_status_command},
    {"pause", add_pause_command},
    {"resume", add_resume_command},
    {"reset", add_reset_command},
    {"arm", add_arm_command},
    {"disarm", add_disarm_command},
    {"config", add_config_command},
    {"controller", add_controller_command},
    {"ohc", add_ohc_command},
#if ARKMESH_CAMERAS
    {"doctor", [](CLI::App& app) { add_doctor_command(app, testbed::find_devices); }},
    {"emulator", add_emulator_command},
    {"testbed", add_testbed_command},
    {"track", add_track_command},
    {"calibrate", add_calibrate_command},
    {"identify", add_identify_command},
    {"assign-ids", add_assign_ids_command},
    {"calibrate-motors", add_calibrate_motors_command},
#else
    {"doctor", [](CLI::App& app) { add_doctor_command(app, nullptr); }},
#endif
  };
  return main(argc, argv, own);
}

}  // namespace arkmesh::cli
