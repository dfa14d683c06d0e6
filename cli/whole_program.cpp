#include "cli/whole_program.hpp"

#include <iterator>
#include <span>
#include <utility>

#include "cli/commands.hpp"
#if ARKMESH_CAMERAS
#include <opencv2/core/utility.hpp>

#include "testbed/devices.hpp"
#endif

namespace arkmesh::cli {

int whole_main(int argc, char** argv, std::vector<app::CatalogueEntry> extra_scenarios) {
  for (const app::CatalogueEntry& own : extra_scenarios)
    std::erase_if(app::catalogue(), [&](const app::CatalogueEntry& known) { return known.name == own.name; });
  app::catalogue().insert(app::catalogue().end(), std::make_move_iterator(extra_scenarios.begin()),
                          std::make_move_iterator(extra_scenarios.end()));
#if ARKMESH_CAMERAS
  cv::setNumThreads(1);  // its threads wait actively: between small steps they cost more than they do
#endif
  std::vector<OwnCommand> own {
#if ARKMESH_CAMERAS
    // the first of a name counts
    {"doctor", [](CLI::App* command) { add_doctor_command(command, testbed::find_devices); }},
        {"config", add_config_command}, {"emulator", add_emulator_command}, {"testbed", add_testbed_command},
        {"fit", [](CLI::App* command) { add_fit_command(command, record_walks); }}, {"track", add_track_command},
        {"calibrate", add_calibrate_command}, {"identify", add_identify_command},
        {"assign-ids", add_assign_ids_command}, {"calibrate-motors", add_calibrate_motors_command},
#endif
  };
  for (const std::span<const OwnCommand> more :
       {std::span<const OwnCommand>(light_commands), {gateway_commands}, {lab_commands}})
    own.insert(own.end(), more.begin(), more.end());
  return main(argc, argv, own);
}

}  // namespace arkmesh::cli
