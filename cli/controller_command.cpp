// `arkmesh controller run` and `arkmesh controller check`: a robot's program by itself, without labs.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "cli/commands.hpp"
#include "cli/progress.hpp"
#include "hal/led_name.hpp"
#include "sim_ode/host/controller_check.hpp"
#include "sim_ode/host/controller_swarm.hpp"
#include "sim_ode/host/robot_text.hpp"
#include "sim_ode/host/subprocess.hpp"
#include "sim_ode/host/swarm_report.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

struct RunOptions {
  sim_ode::SwarmOptions swarm;
  double seconds = 60;
  int text_lines = 10;
  std::string arena = "1x1", light, png, video, csv;
};

// "1x0.5" or "0.2,-0.1": two numbers and nothing else.
std::optional<std::pair<double, double>> two_numbers(const std::string& text, char between) {
  double first = 0, second = 0;
  char separator = 0, rest = 0;
  if (std::sscanf(text.c_str(), "%lf%c%lf%c", &first, &separator, &second, &rest) != 3 || separator != between)
    return {};
  return std::pair(first, second);
}

// A row per robot and frame. Owns a file; a temporary one is removed at the end.
class PosesFile {
 public:
  // Empty `name`: a temporary file.
  explicit PosesFile(const std::string& name) : path_(name), temporary_(name.empty()) {
    if (temporary_) path_ = fs::temp_directory_path() / fmt::format("arkmesh-poses-{}.csv", getpid());
    out_.open(path_, std::ios::binary);
    out_ << "time_s,robot,x_m,y_m,heading_rad,led\n";
    if (!out_) throw CLI::ValidationError("--csv", fmt::format("{} cannot be written", path_.string()));
  }
  ~PosesFile() {
    std::error_code ignored;
    if (temporary_) fs::remove(path_, ignored);
  }
  PosesFile(const PosesFile&) = delete;
  PosesFile& operator=(const PosesFile&) = delete;

  void write(const hal::PoseFrame& frame) {
    const double time_s = static_cast<double>(frame.stamp.count()) * 1e-6;
    for (const hal::Sighting& robot : frame.robots)
      out_ << fmt::format("{:.1f},{},{:.6f},{:.6f},{:.4f},{}\n", time_s, robot.robot, robot.pose.x_m, robot.pose.y_m,
                          robot.pose.heading_rad, hal::name_of(robot.led));
  }
  // All of it is in the file, or the disk is full.
  const fs::path& finished() {
    out_.close();
    if (!out_)
      throw std::runtime_error(fmt::format("{} could not be written to the end; is the disk full?", path_.string()));
    return path_;
  }

 private:
  fs::path path_;
  bool temporary_;
  std::ofstream out_;
};

// Beside an installed program, or among the sources.
fs::path drawing_script() {
  std::error_code ignored;
  const fs::path installed =
      fs::read_symlink("/proc/self/exe", ignored).parent_path().parent_path() / "share" / "arkmesh" / "draw_swarm";
  return fs::exists(installed, ignored) ? installed : fs::path(ARKMESH_SOURCE_DIR) / "scripts" / "draw_swarm";
}

// Refuses a file that cannot be written before a run that would be for nothing.
void check_writable(const char* option, const std::string& file) {
  if (file.empty()) return;
  std::error_code ignored;
  const bool existed = fs::exists(file, ignored);
  const bool writable = static_cast<bool>(std::ofstream(file, std::ios::app));
  if (!existed) fs::remove(file, ignored);
  if (!writable) throw CLI::ValidationError(option, fmt::format("{} cannot be written", file));
}

// Pictures are made by a script, which says itself what it lacks. Without `poses` it only says that.
void draw(const RunOptions& options, const std::optional<fs::path>& poses) {
  if (options.png.empty() && options.video.empty()) return;
  const fs::path script = drawing_script();
  std::vector<std::string> command = {script.string(), "--arena",
                                      fmt::format("{}x{}", options.swarm.width_m, options.swarm.height_m)};
  command.push_back(poses ? poses->string() : "--try");
  if (options.swarm.light)
    command.push_back(fmt::format("--light={},{}", options.swarm.light->x_m, options.swarm.light->y_m));
  if (!options.png.empty()) command.insert(command.end(), {"--png", options.png});
  if (!options.video.empty()) command.insert(command.end(), {"--video", options.video});
  const sim_ode::Finished done = sim_ode::run_to_end(command);
  if (done.status == 0) return;
  std::string last = done.output;
  while (last.ends_with('\n')) last.pop_back();
  if (const auto line = last.rfind('\n'); line != std::string::npos) last.erase(0, line + 1);
  throw std::runtime_error(
      last.empty() ? fmt::format("{} cannot be started; it needs /usr/bin/python3", script.string()) : last);
}

// Returns the exit code.
int run_controller(RunOptions options) {
  const auto sides = two_numbers(options.arena, 'x');
  if (!sides) throw CLI::ValidationError("--arena", "write width x height in metres, such as 1x1 or 0.5x2");
  options.swarm.width_m = sides->first;
  options.swarm.height_m = sides->second;
  if (!options.light.empty()) {
    const auto place = two_numbers(options.light, ',');
    if (!place) throw CLI::ValidationError("--light", "write x,y in metres from the arena's centre, such as 0.3,-0.2");
    options.swarm.light = hal::Pose{.x_m = place->first, .y_m = place->second};
  }

  const std::string name = options.swarm.program.filename().string();
  const auto begun = std::chrono::steady_clock::now();
  const auto wall_s = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count(); };
  check_writable("--png", options.png);
  check_writable("--video", options.video);
  draw(options, {});
  std::optional<PosesFile> poses;
  if (!options.csv.empty() || !options.png.empty() || !options.video.empty()) poses.emplace(options.csv);
  // Without a need for each frame a picture's trails are drawn from one a second.
  const std::uint32_t every = options.csv.empty() && options.video.empty() ? 10 : 1;

  std::optional<sim_ode::ControllerSwarm> swarm;
  try {
    swarm.emplace(options.swarm);
  } catch (const sim_ode::ProgramError& error) {
    fmt::print(stderr, "arkmesh: {}: {}\n", name, error.what());
    return 1;
  }
  const double built_s = wall_s();
  sim_ode::SwarmReport report;
  sim_ode::RobotText text(options.text_lines);
  Progress progress(name, "second");
  const auto show_text = [&] {
    const std::string lines = text.lines(swarm->take_text());
    if (lines.empty()) return;
    progress.done();
    fmt::print("{}", lines);
    std::fflush(stdout);
  };
  const auto seconds = static_cast<std::uint32_t>(options.seconds);
  std::string failure;
  try {
    swarm->run_until(hal::LabTime(static_cast<std::int64_t>(options.seconds * 1e6)), [&](const hal::PoseFrame& frame) {
      report.look(frame);
      show_text();
      if (poses && frame.number % every == 0) poses->write(frame);
      if (frame.number > 0 && frame.number % 10 == 0) progress.show(frame.number / 10, seconds, 1.0);
    });
  } catch (const std::runtime_error& error) {
    failure = error.what();
  }
  show_text();
  progress.done();

  const double simulated_s = static_cast<double>(report.last().stamp.count()) * 1e-6, run_s = wall_s() - built_s;
  fmt::print("{}{}: {} robots, {:.1f} s simulated in {:.2f} s ({:.0f}x), built in {:.2f} s\n{}{}", text.unfinished(),
             name, options.swarm.robots, simulated_s, run_s, run_s > 0 ? simulated_s / run_s : 0.0, built_s,
             report.text(swarm->arena().counters()), text.left_out(swarm->lost_text()));
  std::fflush(stdout);
  if (poses) draw(options, poses->finished());
  if (failure.empty()) return 0;
  fmt::print(stderr, "arkmesh: {}\n", failure);
  return 1;
}

int check_controller(const fs::path& program) {
  const sim_ode::CheckedProgram checked = sim_ode::check_program(program);
  for (const std::string& warning : checked.warnings) fmt::print("{}\n", warning);
  fmt::print(
      "{}: flash {} of {} bytes (the library's {} included), static RAM {} of {} (the library's {} included; {} remain "
      "for the stack)\n",
      program.filename().string(), checked.flash_bytes, sim_ode::flash_limit_bytes, sim_ode::flash_library_bytes,
      checked.ram_bytes, sim_ode::ram_limit_bytes, sim_ode::ram_library_bytes,
      std::max(0, sim_ode::ram_limit_bytes - checked.ram_bytes));
  if (checked.fits()) return 0;
  fmt::print(stderr, "arkmesh: {} does not fit on a robot\n", program.filename().string());
  return 1;
}

}  // namespace

void add_controller_command(CLI::App& app) {
  auto* controller = app.add_subcommand("controller", "Runs or checks a robot's program by itself");
  controller->require_subcommand(1);
  controller->footer("Example:\n  arkmesh controller run my_robot.c --robots 25 --seconds 60 --png end.png");

  auto* run = controller->add_subcommand("run", "Compiles a Kilobot C program and runs it on a simulated swarm");
  const auto options = std::make_shared<RunOptions>();
  run->add_option("PROGRAM", options->swarm.program, "A C file for kilolib")->required()->check(CLI::ExistingFile);
  run->add_option("--robots", options->swarm.robots, "How many robots")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  run->add_option("--seconds", options->seconds, "Simulated time")->check(CLI::Range(0.1, 1e6))->capture_default_str();
  run->add_option("--arena", options->arena, "Width x height in metres")->capture_default_str();
  run->add_option("--light", options->light, "A lamp at x,y, metres from the arena's centre");
  run->add_option("--spacing", options->swarm.spacing_m,
                  "Start on a square grid with this spacing in metres, not at random")
      ->check(CLI::Range(0.033, 10.0));
  run->add_option("--seed", options->swarm.seed, "Everything that is random follows from it")->capture_default_str();
  run->add_option("--png", options->png, "Draw the end of the run");
  run->add_option("--video", options->video, "Draw all of it (mp4)");
  run->add_option("--csv", options->csv, "Write where each robot was, ten times a second");
  run->add_option("--text", options->text_lines, "How many lines of what each robot prints to show")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  run->footer(
      "Example:\n  arkmesh controller run my_robot.c --robots 25 --seconds 60 --light 0.3,0 --png end.png\n"
      "Ends with 1 when the program does not compile, crashes or never returns.");
  run->callback([options] {
    if (const int code = run_controller(*options)) throw CLI::RuntimeError(code);
  });

  auto* check =
      controller->add_subcommand("check", "Builds a Kilobot C program for the robot and says whether it fits");
  const auto program = std::make_shared<std::string>();
  check->add_option("PROGRAM", *program, "A C file for kilolib")->required()->check(CLI::ExistingFile);
  check->footer(
      "Example:\n  arkmesh controller check my_robot.c\nNeeds avr-gcc. Ends with 1 when the program does not build or "
      "does not fit.");
  check->callback([program] {
    if (const int code = check_controller(*program)) throw CLI::RuntimeError(code);
  });
}

}  // namespace arkmesh::cli
