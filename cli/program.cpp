#include "cli/program.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <set>
#include <span>
#include <string_view>

#include "hal/config/config.hpp"
#include "hal/config/near_key.hpp"
#include "hal/config/without_secrets.hpp"
#include "hal/exit_code.hpp"
#include "hal/files/own_files.hpp"

namespace arkmesh::cli {
namespace {

// The command line of this process, and what it runs itself.
char** arguments = nullptr;
std::span<const OwnCommand> own_commands;

bool is_own(std::string_view name) {
  return std::ranges::any_of(own_commands, [&](const OwnCommand& own) { return own.name == name; });
}

// Whether a lab with this arena.use is run by arkmesh-testbed only.
bool needs_cameras(std::string_view arena) {
  return arena == "kilobot" || arena == "emulated" || arena == "aseba";
}

// Where Debian packages put programs, and which of ours has this one (scripts/package).
constexpr const char* package_folder = "/usr/bin";
std::string_view package_of(std::string_view program) {
  return program == gateway_program || program == testbed_program ? program : "arkmesh";
}

// Becomes another program of our folder; PATH, which may hold another version, is not asked. `purpose`: what it is
// needed for.
[[noreturn]] void become(std::string_view program, const std::string& purpose) {
  if (!ARKMESH_CAMERAS && program == testbed_program)
    throw hal::ConfigError(fmt::format(
        "{} needs cameras, and this arkmesh was built without OpenCV; install libopencv-dev and build it again",
        purpose));
  const std::filesystem::path self = hal::this_program(), folder = hal::program_folder();
  if (self.filename() == program)  // it would start itself for ever
    throw std::runtime_error(
        fmt::format("{} is not in {}; install all programs of arkmesh again", purpose, self.string()));
  ::execv((folder / program).c_str(), arguments);
  if (errno == ENOENT && folder == package_folder)
    throw std::runtime_error(fmt::format("{} needs the program {}, which is not installed; it is in the package {}",
                                         purpose, program, package_of(program)));
  if (errno == ENOENT)
    throw std::runtime_error(
        fmt::format("{} needs the program {}, which is not in {}; scripts/build builds it, and an installation keeps "
                    "all of arkmesh's programs in one folder",
                    purpose, program, folder.string()));
  throw std::runtime_error(fmt::format("{} cannot be started: {}", (folder / program).string(), std::strerror(errno)));
}

// The words of CLI11's errors in our voice.
std::string sentence(const CLI::App& command, const CLI::ParseError& error, std::span<char*> words) {
  std::set<std::string, std::less<>> known;
  for (const CLI::App* each = &command; each; each = each->get_parent())
    for (const CLI::Option* option : each->get_options())
      for (const std::string& name : option->get_lnames()) known.insert("--" + name);
  for (const std::string_view word : words) {
    const std::string name(word.substr(0, word.find('=')));
    if (word == "--") break;
    if (!name.starts_with("--") || known.contains(name) || name == "--version") continue;
    const auto near = hal::near_key(name, known);
    return fmt::format("unknown option {}{}", name, near ? fmt::format("; did you mean {}?", *near) : "");
  }
  std::string text = error.what();
  if (const std::size_t at = text.find("File does not exist: "); at != std::string::npos)
    text = fmt::format("there is no file {}", text.substr(at + 21));
  return text;
}

// Refuses what CLI11 takes for numbers: NaN, infinity, what does not fit into 64 bits, and 010, which it takes for 8.
void check_numbers(CLI::App& command) {
  const auto check = [](CLI::Option* option, auto number, std::string_view what) {
    option->check([number, what](const std::string& text) mutable {
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
      const bool fits = error == std::errc() && *end == '\0' && std::isfinite(static_cast<double>(number));
      const bool plain = std::is_floating_point_v<decltype(number)> || text == fmt::format("{}", number);
      return fits && plain ? "" : fmt::format("{} is no {}", text, what);
    });
  };
  for (CLI::Option* option : command.get_options())
    if (const std::string type = option->get_type_name(); type.starts_with("FLOAT"))
      check(option, 0.0, "finite number");
    else if (type.starts_with("INT") || type.starts_with("UINT"))
      check(option, std::int64_t{0}, "whole number up to 2^63-1");
  for (CLI::App* below : command.get_subcommands({})) check_numbers(*below);
}

int parse(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::RuntimeError& e) {
    return e.get_exit_code();
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // help or version
    const CLI::App* command = &app;
    std::string name = app.get_name();
    for (; !command->get_subcommands().empty(); command = command->get_subcommands().front())
      name += " " + command->get_subcommands().front()->get_name();
    // A command that there is not looks to CLI11 as if none had been given.
    const std::vector<std::string> rest = command->remaining();
    const bool is_command =
        command->get_require_subcommand_min() > 0 && !rest.empty() && !rest.front().starts_with("-");
    if (is_command) {
      std::set<std::string, std::less<>> known;
      for (const CLI::App* each : command->get_subcommands({})) known.insert(each->get_name());
      const auto near = hal::near_key(rest.front(), known);
      fmt::print(stderr, "arkmesh: {} has no command {}; {}{} --help lists them\n", name, rest.front(),
                 near ? fmt::format("did you mean {}? ", *near) : "", name);
    } else
      fmt::print(stderr, "arkmesh: {} (see {} --help)\n",
                 hal::without_secrets(sentence(*command, e, std::span(argv, argc).subspan(1))), name);
    return 2;
  }
}

int run(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const CommandRow* const row = find_command(argv[i]);
    if (!row) continue;
    // A build or installation without the testbed's program has the other keys.
    const bool lacks_testbed = row->name == std::string_view("config") && row->program == testbed_program &&
                               !std::filesystem::exists(hal::program_folder() / testbed_program);
    if (lacks_testbed && is_own(row->name))
      fmt::print(stderr,
                 "arkmesh: without the program {} the keys of [arena.kilobot] and [arena.emulated] are left out\n",
                 testbed_program);
    const std::string_view program = lacks_testbed ? lab_program : row->program;
    if (!is_own(row->name)) become(program, fmt::format("arkmesh {}", row->name));
    break;
  }
  CLI::App app("Joins robot-swarm labs, real and simulated, into one shared world.");
  app.name("arkmesh");
  app.set_version_flag("--version", ARKMESH_VERSION);
  app.require_subcommand(1);
  std::string codes;
  for (const hal::ExitCodeRow& row : hal::exit_codes)
    codes += fmt::format("{}{} {}", codes.empty() ? "Exit codes: " : ", ", row.code, row.meaning);
  app.footer(codes + '.');
  for (const CommandRow& row : command_table()) {
    CLI::App* const command = app.add_subcommand(row.name, row.purpose);
    const auto own = std::ranges::find(own_commands, std::string_view(row.name), &OwnCommand::name);
    if (own != own_commands.end()) own->add(command);
    check_numbers(*command);
  }
  return parse(app, argc, argv);
}

// What went wrong, without what a terminal would obey. Without a current folder nothing else matters.
int tell(std::string what, int code) {
  std::error_code gone;
  static_cast<void>(std::filesystem::current_path(gone));
  if (gone) what = "the current folder was deleted; go to another one, and try again";
  std::ranges::replace_if(
      what, [](unsigned char c) { return c < ' ' || c == 127; }, '?');
  fmt::print(stderr, "arkmesh: {}\n", hal::without_secrets(what));
  return code;
}

}  // namespace

int main(int argc, char** argv, std::span<const OwnCommand> own) {
  for (const int each : {SIGPIPE, SIGXFSZ}) std::signal(each, SIG_IGN);  // who writes is told
  // Another program gets the words as they are; the list of processes shows them without passwords.
  static std::vector<std::string> words(argv, argv + argc);
  static std::vector<char*> pointers;
  for (int i = 0; i < argc; ++i) {
    pointers.push_back(words[static_cast<std::size_t>(i)].data());
    if (const std::string shown = hal::without_secrets(argv[i]); shown != argv[i])
      std::strncpy(argv[i], shown.c_str(), std::strlen(argv[i]));
  }
  pointers.push_back(nullptr);
  arguments = pointers.data();
  own_commands = own;
  return exit_code_of([argc] {
    const int code = run(argc, arguments);
    const bool is_written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
    // who reads a pipe no further has had enough
    pollfd reader{STDOUT_FILENO, POLLOUT, 0};
    if (is_written || (::poll(&reader, 1, 0) == 1 && (reader.revents & POLLERR) != 0)) return code;
    throw std::runtime_error("the output cannot be written; is the disk full?");
  });
}

int exit_code_of(const std::function<int()>& work) try { return work(); } catch (const hal::ConfigError& e) {
  return tell(e.what(), hal::Exit::refused);
} catch (const hal::ExitError& e) {
  return tell(e.what(), e.code());
} catch (const std::exception& e) {
  return tell(e.what(), hal::Exit::failed);
}

int exit_code(hal::Outcome outcome) {
  using hal::Exit, hal::Outcome;
  return outcome == Outcome::finished ? Exit::done : outcome == Outcome::stopped ? Exit::stopped : Exit::failed;
}

std::optional<std::pair<double, double>> two_numbers(const std::string& text, char between) {
  double first = 0, second = 0;
  char separator = 0, rest = 0;
  const int read = std::sscanf(text.c_str(), "%lf%c%lf%c", &first, &separator, &second, &rest);
  return read == 3 && separator == between && std::isfinite(first) && std::isfinite(second)
             ? std::optional(std::pair(first, second))
             : std::nullopt;
}

void end_with(int code) {
  if (code != 0) throw CLI::RuntimeError(code);
}

void hand_over_cameras(const std::vector<std::string>& files, const std::vector<std::string>& sets) {
  if (is_own("track")) return;  // it knows cameras itself; `config` alone does not mean that
  // "shark:arena.use=emulated" is for one of the labs
  std::vector<std::string> common;
  for (const std::string& set : sets) {
    const std::size_t equals = set.find('=');
    if (set.find(':') > equals)
      common.push_back(set);
    else if (set.substr(0, equals).ends_with(":arena.use") && needs_cameras(set.substr(equals + 1)))
      become(testbed_program, "--set " + set);
  }
  for (const std::string& file : files) {
    std::string use;
    try {
      use = hal::Config::from_file(file, common).root().section("arena").get("use", std::string());
    } catch (const hal::ConfigError&) {
      continue;
    }
    if (needs_cameras(use)) become(testbed_program, fmt::format("{}: arena.use = \"{}\"", file, use));
  }
}

}  // namespace arkmesh::cli
