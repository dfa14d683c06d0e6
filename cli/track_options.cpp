#include "cli/track_options.hpp"

#include <CLI/CLI.hpp>

namespace arkmesh::cli {

void add_track_options(CLI::App& command, testbed::StreamOptions& options) {
  command
      .add_option("SOURCE", options.source,
                  "A picture, a folder of pictures, a video, a camera's number or device, or a URL")
      ->required();
  command.add_flag(
      "--json", options.json,
      "Print a JSON list (of a folder: a list of {picture, robots}; of a video or camera: a line for each picture)");
  command.add_option("--png", options.png,
                     "Write the picture with the robots drawn on it (of a folder: into this folder; of a video or "
                     "camera: the last picture)");
  auto* calibration = command.add_option(
      "--calibration", options.calibration,
      "Measure in the arena with this file of arkmesh calibrate; otherwise metres are derived from the robots' size");
  command.add_option("--camera", options.camera, "The camera's name in that file, when it holds several")
      ->needs(calibration);
  command.add_option("--csv", options.csv, "Write a row for each robot and picture");
  command.add_option("--video", options.video, "Write a video with the robots drawn on it (.mp4 or .avi)");
  command.add_option("--serve", options.serve_port, "Show it live in browsers: http://127.0.0.1:PORT/arena")
      ->check(CLI::Range(0, 65535));
  command.add_option("--publish", options.publish, "Publish poses on this LCM bus, with the tracks' numbers as ids");
  command.add_option("--seconds", options.seconds, "End after so many seconds")->check(CLI::Range(0.0, 1e7));
  command
      .add_option("--led-offset", options.led_offset_deg,
                  "Driving direction minus direction of the LED, degrees counter-clockwise")
      ->check(CLI::Range(-360.0, 360.0))
      ->capture_default_str();
  command.add_option("--diameter", options.diameter_px, "Diameter of a robot in pixels, if it is known")
      ->check(CLI::Range(6.0, 2000.0));
}

}  // namespace arkmesh::cli
