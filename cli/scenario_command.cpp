// `arkmesh scenario`: begins a scenario of the user's as a copy of the example, and says where Python finds arkmesh.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/scenarios.hpp"
#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "hal/config/config.hpp"
#include "hal/files/own_files.hpp"
#include "scenarios/python/python_scenario.hpp"

namespace arkmesh::cli {
namespace {

namespace fs = std::filesystem;

// my_swarm as a class: MySwarm.
std::string class_name(const std::string& name) {
  std::string out;
  bool begins = true;
  for (const char c : name) {
    if (c != '_') out += begins && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    begins = c == '_';
  }
  return out;
}

void replace_all(std::string& text, const std::string& word, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += by.size())
    text.replace(at, word.size(), by);
}

// The scenario's name is that of a namespace, a source and a target. Scenarios of arkmesh have theirs, too.
constexpr std::string_view taken_in_cpp[] = {
    // the language's
    "alignas", "alignof", "and", "and_eq", "asm", "auto", "bitand", "bitor", "bool", "break", "case", "catch", "char",
    "class", "co_await", "co_return", "co_yield", "compl", "concept", "const", "const_cast", "consteval", "constexpr",
    "constinit", "continue", "decltype", "default", "delete", "do", "double", "dynamic_cast", "else", "enum",
    "explicit", "export", "extern", "false", "float", "for", "friend", "goto", "if", "inline", "int", "long", "mutable",
    "namespace", "new", "noexcept", "not", "not_eq", "nullptr", "operator", "or", "or_eq", "private", "protected",
    "public", "register", "reinterpret_cast", "requires", "return", "short", "signed", "sizeof", "static",
    "static_assert", "static_cast", "struct", "switch", "template", "this", "thread_local", "throw", "true", "try",
    "typedef", "typeid", "typename", "union", "unsigned", "using", "virtual", "void", "volatile", "wchar_t", "while",
    "xor", "xor_eq",
    // of namespaces, classes and files that the example uses
    "hal", "lab", "main", "settings", "std",
    // CMake's targets
    "all", "clean", "edit_cache", "help", "install", "package", "rebuild_cache", "test", "package_source"};

// A file of the new folder, as it is called in the example.
struct ExampleFile {
  const char* name;
  fs::path source;
};

std::vector<ExampleFile> example_files(bool cpp) {
  const fs::path example = scenarios::python::example_folder();
  std::vector<ExampleFile> files;
  for (const char* const name : {"a.toml", "b.toml", "light_up.c"}) files.push_back({name, example / name});
  if (cpp) {
    for (const char* const name : {"CMakeLists.txt", "README.md", "light_up_test.cpp", "main.cpp"})
      files.push_back({name, example / "cpp" / name});
    for (const char* const name : {"light_up.cpp", "light_up.hpp"})
      files.push_back(
          {name, hal::own_file(fs::path("experiments/light_up/cpp") / name, fs::path("scenarios/light_up") / name)});
  } else {
    for (const char* const name : {"README.md", "light_up.py", "light_up_test.py"})
      files.push_back({name, example / name});
  }
  return files;
}

// What is typed next.
std::string next_commands(const fs::path& folder, const std::string& name, bool cpp) {
  const std::string labs = fmt::format("run {0}/a.toml {0}/b.toml --seconds 20", folder.string());
  if (!cpp) return fmt::format("  run it with arkmesh {}\n", labs);
  const fs::path prefix = hal::program_folder().parent_path();
  std::error_code error;
  const bool installed = fs::exists(prefix / "lib/cmake/arkmesh", error);
  return fmt::format(
      "{0}  build it with cmake -S {1} -B {1}/build{2} && cmake --build {1}/build\n"
      "  run it with {1}/build/{3} {4}\n",
      installed ? ""
                : "  this arkmesh is not installed; scripts/build --install FOLDER installs one to build against\n",
      folder.string(), installed ? fmt::format(" -DCMAKE_PREFIX_PATH='{}'", prefix.string()) : "", name, labs);
}

void write_new(fs::path folder, bool cpp) {
  if (!folder.has_filename()) folder = folder.parent_path();
  const std::string name = folder.filename().string();
  const bool is_name = !name.empty() && name[0] >= 'a' && name[0] <= 'z' && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
  if (!is_name || name == "arkmesh")
    throw hal::ConfigError(fmt::format(
        "{}: a scenario's name is a-z, 0-9 and _, begins with a letter, and is not arkmesh; choose another one",
        folder.string()));
  if (cpp && (std::ranges::find(taken_in_cpp, name) != std::end(taken_in_cpp) ||
              std::ranges::find(app::catalogue(), name, &app::CatalogueEntry::name) != app::catalogue().end()))
    throw hal::ConfigError(
        fmt::format("{}: {} is reserved by C++, CMake or arkmesh; choose another name", folder.string(), name));
  std::error_code error;
  if (fs::exists(folder, error))
    throw hal::ConfigError(fmt::format("{} exists; choose another name or folder", folder.string()));
  std::vector<std::pair<std::string, std::string>> words = {
      {"experiments/light_up", folder.string()}, {"light_up", name}, {"LightUp", class_name(name)}, {"Light-up", name}};
  if (cpp)
    words.insert(words.begin(), {{"scenarios/light_up/", ""}, {"\"light_up.py\"", '"' + name + '"'}, {".py", ".cpp"}});
  fs::create_directories(folder);
  for (const ExampleFile& file : example_files(cpp)) {
    std::ifstream in(file.source);
    std::string text(std::istreambuf_iterator<char>(in), {}), to = file.name;
    for (const auto& [word, by] : words) replace_all(text, word, by);
    replace_all(to, "light_up", name);
    std::ofstream out(folder / to);
    if (text.empty() || !(out << text << std::flush))
      throw std::runtime_error(
          fmt::format("{} cannot be written; make room there, or choose another folder", (folder / to).string()));
  }
  fmt::print("wrote {0}: {1}.{2} is the scenario, {1}.c the robots' program; README.md explains the rest\n{3}",
             folder.string(), name, cpp ? "cpp" : "py", next_commands(folder, name, cpp));
}

}  // namespace

void add_scenario_command(CLI::App* command) {
  command->require_subcommand(1);
  CLI::App* make = command->add_subcommand("new", "Create a folder with a working scenario to modify");
  const auto folder = std::make_shared<std::string>();
  make->add_option("folder", *folder, "The new folder; its last part becomes the scenario's name")->required();
  CLI::Option* const cpp = make->add_flag("--cpp")->description("In C++, as a separate program with all commands");
  make->add_flag("--python")->description("In Python (default)")->excludes(cpp);
  make->callback([folder, cpp] { write_new(*folder, cpp->count() > 0); });
  command->add_subcommand("path", "Print the folder of the Python package arkmesh")->callback([] {
    fmt::print("{}\n", scenarios::python::package_folder().string());
  });
  command->footer(
      "Examples:\n  arkmesh scenario new my_swarm\n  arkmesh scenario new my_swarm --cpp\n  export "
      "PYTHONPATH=\"$(arkmesh scenario path)\"");
}

}  // namespace arkmesh::cli
