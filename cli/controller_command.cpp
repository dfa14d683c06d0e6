// `arkmesh controller`: a robot's program by itself. `check` and `build` build it for the robot; `run` runs it on a
// simulated swarm, without labs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "app/live/swarm_view.hpp"
#include "cli/commands.hpp"
#include "cli/operator_stop.hpp"
#include "cli/page_opener.hpp"
#include "cli/progress_line.hpp"
#include "cli/swarm_command.hpp"
#include "hal/bus/loss.hpp"
#include "hal/config/config.hpp"
#include "hal/counted.hpp"
#include "hal/files/scratch_folder.hpp"
#include "sim_ode/controller_swarm.hpp"
#include "sim_ode/host/programs/controller_build.hpp"
#include "sim_ode/host/programs/controller_check.hpp"
#include "sim_ode/host/programs/shipped_programs.hpp"
#include "sim_ode/host/reports/poses_file.hpp"
#include "sim_ode/host/reports/robot_text.hpp"
#include "sim_ode/host/reports/swarm_drawing.hpp"
#include "sim_ode/host/reports/swarm_report.hpp"
#include "sim_ode/ode_arena.hpp"

namespace arkmesh::cli {
namespace {

int check_controller(const sim_ode::ProgramSources& program) {
  const sim_ode::CheckedProgram checked = sim_ode::check_program(program);
  for (const std::string& warning : checked.warnings) fmt::print("{}\n", warning);
  fmt::print(
      "{}: flash {} of {} bytes (including the library's {}), static RAM {} of {} (including the library's {}; {} "
      "remain for the stack)\n",
      program.name(), checked.sizes.flash, sim_ode::flash_limit_bytes, sim_ode::flash_library_bytes, checked.sizes.ram,
      sim_ode::ram_limit_bytes, sim_ode::ram_library_bytes, std::max(0, sim_ode::ram_limit_bytes - checked.sizes.ram));
  if (const auto& [place, function, bytes] = checked.largest;
      sim_ode::ram_limit_bytes < checked.sizes.ram + bytes && bytes > 0)
    fmt::print("{}: {} alone needs {} bytes of stack\n", place, function, bytes);
  if (checked.fits()) return 0;
  fmt::print(stderr, "arkmesh: {} does not fit on a robot\n", program.name());
  return 1;
}

int build_controller(const sim_ode::ProgramSources& program, const std::filesystem::path& kilolib,
                     const std::filesystem::path& hex) {
  sim_ode::BuiltProgram built;
  try {
    built = sim_ode::build_program(program, kilolib, hex);
  } catch (const sim_ode::BuildError& error) {
    fmt::print(stderr, "{}arkmesh: {}\n", error.said, error.what());
    return 1;
  }
  fmt::print(stderr, "{}", built.said);
  const auto& [flash, ram] = built.sizes;
  fmt::print("{}: flash {} of {} bytes, static RAM {} of {} ({} remain for the stack)\n", program.name(), flash,
             sim_ode::flash_limit_bytes, ram, sim_ode::ram_limit_bytes, std::max(0, sim_ode::ram_limit_bytes - ram));
  if (built.pages == 0) {
    fmt::print(stderr, "arkmesh: {} does not fit on a robot; {} is not written\n", program.name(), hex.string());
    return 1;
  }
  fmt::print("{}: {}; load it with `arkmesh ohc PORT upload {}`\n", hex.string(), hal::counted(built.pages, "page"),
             hex.string());
  return 0;
}

void add_build_command(CLI::App& controller) {
  struct Options {
    ProgramOptions program;
    std::string kilolib, hex;
  };
  const auto options = std::make_shared<Options>();
  auto* build = controller.add_subcommand("build", "Build a Kilobot C program into the file to load onto robots");
  options->program.add_to(*build);
  build->add_option("-o,--output", options->hex, "The Intel HEX file; default: PROGRAM's name, in this folder");
  build
      ->add_option("--kilolib", options->kilolib,
                   "The robot's library: a folder with kilolib.h and kilolib.c, or kilolib.a")
      ->required();
  build->footer(
      "Example:\n  git clone https://github.com/acornejo/kilolib\n"
      "  arkmesh controller build my_robot.c -o my_robot.hex --kilolib kilolib\n"
      "  arkmesh ohc /dev/ttyUSB0 upload my_robot.hex\n"
      "Needs avr-gcc. Exit code 1 if the program does not build or does not fit, 2 if there is no kilolib.");
  build->callback([options] {
    const sim_ode::ProgramSources program = options->program.sources();
    const std::string hex =
        options->hex.empty() ? std::filesystem::path(program.name()).stem().string() + ".hex" : options->hex;
    end_with(build_controller(program, options->kilolib, hex));
  });
}

struct ControllerRunOptions : SwarmCommand {
  int text_lines = 10;
  std::string png, video, csv;
  bool open = false;
  double pace = 0;  // 0: not asked for
  bool has_seconds = false;
};

// Refuses a file that cannot be written before a run that would be for nothing.
void check_writable(const char* option, const std::string& file) {
  if (file.empty()) return;
  std::error_code ignored;
  const bool existed = std::filesystem::exists(file, ignored);
  const bool writable = static_cast<bool>(std::ofstream(file, std::ios::app));
  if (!existed) std::filesystem::remove(file, ignored);
  if (!writable) throw CLI::ValidationError(option, fmt::format("{} cannot be written", file));
}

void open(std::optional<sim_ode::PosesFile>& poses, const std::string& csv,
          const std::vector<hal::MovableObject>& objects) {
  std::vector<std::string> names;
  for (const hal::MovableObject& object : objects) names.push_back(object.name);
  try {
    poses.emplace(csv, std::move(names));
  } catch (const std::runtime_error& error) {
    throw CLI::ValidationError("--csv", error.what());
  }
}

// The swarm on a page, until somebody stops it. Returns the exit code.
int show_controller(const ControllerRunOptions& options) {
  OperatorStop stop;
  app::SwarmViewOptions view{.swarm = options.swarm, .pace = options.pace > 0 ? options.pace : 1, .seconds = {}};
  if (options.has_seconds) view.seconds = options.seconds;
  hal::EventLoop loop;
  app::SwarmView page(loop, std::move(view));
  const hal::ScratchFolder folder("page");
  show_page(page.url(), folder.path(), options.open);
  page.run(stop);
  if (page.failure().empty()) return 0;
  fmt::print(stderr, "arkmesh: {}: {}\n", options.swarm.program.name(), page.failure());
  return 1;
}

// Returns the exit code.
int run_controller(const ControllerRunOptions& options) {
  const std::string name = options.swarm.program.name();
  const auto begun = std::chrono::steady_clock::now();
  const auto wall_s = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count(); };
  check_writable("--png", options.png);
  check_writable("--video", options.video);
  sim_ode::SwarmDrawing drawing{options.png,
                                options.video,
                                fmt::format("{}, seed {}", name, options.swarm.seed),
                                options.swarm.width_m,
                                options.swarm.height_m,
                                options.swarm.light,
                                {},
                                {}};
  sim_ode::draw_swarm(drawing, {});
  check_writable("--csv", options.csv);
  // Without a need for each frame a picture's trails are drawn from one a second.
  const std::uint32_t every = options.csv.empty() && options.video.empty() ? 10 : 1;

  std::optional<sim_ode::ControllerSwarm> swarm;
  try {
    swarm.emplace(options.swarm);
  } catch (const sim_ode::ProgramError& error) {
    fmt::print(stderr, "arkmesh: {}: {}\n", name, error.what());
    return 1;
  }
  drawing.obstacles = swarm->arena().info().obstacles;
  drawing.objects = swarm->arena().info().objects;
  std::optional<sim_ode::PosesFile> poses;
  if (!options.csv.empty() || !options.png.empty() || !options.video.empty())
    open(poses, options.csv, swarm->arena().info().objects);
  const double built_s = wall_s();
  sim_ode::SwarmReport report;
  sim_ode::RobotText text(options.text_lines);
  ProgressLine progress(name, "second");
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
  swarm->arena().end();

  const double simulated_s = static_cast<double>(report.last().stamp.count()) * 1e-6, run_s = wall_s() - built_s;
  fmt::print("{}{}: {}, {:.1f} s simulated in {:.2f} s ({:.0f}x), built in {:.2f} s\n{}{}", text.unfinished(), name,
             hal::counted(options.swarm.robots, "robot"), simulated_s, run_s, run_s > 0 ? simulated_s / run_s : 0.0,
             built_s, failure.empty() || simulated_s > 0 ? report.text(swarm->arena().counters()) : "",
             text.left_out(swarm->lost_text()));
  for (const std::string& note : hal::loss_words(swarm->arena().counters())) fmt::print("{}: {}\n", name, note);
  std::fflush(stdout);
  if (poses) sim_ode::draw_swarm(drawing, poses->finished());
  if (failure.empty()) return 0;
  fmt::print(stderr, "arkmesh: {}\n", failure);
  return 1;
}

void add_run(CLI::App& controller) {
  auto* run = controller.add_subcommand("run", "Compile a Kilobot C program and run it on a simulated swarm");
  const auto options = std::make_shared<ControllerRunOptions>();
  CLI::Option* const seconds = options->add_to(*run);
  CLI::Option* const png = run->add_option("--png", options->png, "Draw the end of the run (.png, .jpg, .pdf, .svg)");
  CLI::Option* const video = run->add_option("--video", options->video, "Draw the whole run (.mp4, .mkv, .mov)");
  CLI::Option* const csv = run->add_option("--csv", options->csv, "Write each robot's pose, ten times a second");
  run->add_option("--text", options->text_lines, "How many lines of each robot's output to show")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  run->add_flag(
         "--open", options->open,
         "Watch the swarm live in a browser, until Ctrl-C: pause, restart, change the speed, see what a robot prints")
      ->excludes(png, video, csv);
  run->add_option("--pace", options->pace,
                  "Serve the page at a printed address, at this multiple of real time (--open: 1)")
      ->check(CLI::Range(0.0625, 1024.0))
      ->excludes(png, video, csv);
  run->footer(
      "Examples:\n  arkmesh controller run my_robot.c --robots 25 --seconds 60 --light 0.3,0 --png end.png\n"
      "  arkmesh controller run my_robot.c --open\n"
      "  arkmesh controller run complexity.c list.c -I ../common -D SIMULATION\n"
      "Exit code 1 if the program does not compile, crashes or never returns.");
  run->callback([options, seconds] {
    options->complete();
    options->has_seconds = seconds->count() > 0;
    end_with(options->open || options->pace > 0 ? show_controller(*options) : run_controller(*options));
  });
}

// For packages, and so not listed.
void add_ship_command(CLI::App& controller) {
  auto* ship = controller.add_subcommand("ship", "Compile labs' programs, to run them on machines without a compiler");
  ship->group("");
  const auto files = std::make_shared<std::vector<std::string>>();
  const auto out = std::make_shared<std::string>();
  ship->add_option("FILE", *files, "Labs' configuration files")->required()->check(CLI::ExistingFile);
  ship->add_option("--out", *out, "Output folder: lib/arkmesh/programs beside an installed bin")->required();
  ship->callback([files, out] {
    for (const std::string& file : *files) {
      const hal::Config lab = hal::Config::from_file(file);
      sim_ode::ship_program(sim_ode::ReadProgram(sim_ode::program_of(lab.root().section("arena"))), *out);
    }
  });
}

}  // namespace

void add_controller_command(CLI::App* controller) {
  controller->require_subcommand(1);
  controller->footer("Example:\n  arkmesh controller run my_robot.c --robots 25 --seconds 60 --png end.png");

  add_run(*controller);
  add_prove_command(*controller);
  add_build_command(*controller);
  add_ship_command(*controller);

  auto* check = controller->add_subcommand("check", "Build a Kilobot C program for the robot and check that it fits");
  const auto program = std::make_shared<ProgramOptions>();
  program->add_to(*check);
  check->footer(
      "Example:\n  arkmesh controller check my_robot.c\nNeeds avr-gcc. Exit code 1 if the program does not build or "
      "does not fit.");
  check->callback([program] { end_with(check_controller(program->sources())); });
}

}  // namespace arkmesh::cli
