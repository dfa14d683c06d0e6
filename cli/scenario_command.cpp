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
#include <utility>
#include <vector>

#include "cli/commands.hpp"
#include "cli/program.hpp"
#include "hal/config.hpp"
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

void write_new(fs::path folder) {
  if (!folder.has_filename()) folder = folder.parent_path();
  const std::string name = folder.filename().string();
  const bool is_name = !name.empty() && name[0] >= 'a' && name[0] <= 'z' && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
  if (!is_name || name == "arkmesh")
    throw hal::ConfigError(fmt::format(
        "{}: a scenario's name is a-z, 0-9 and _, begins with a letter, and is not arkmesh; choose another one",
        folder.string()));
  std::error_code error;
  if (fs::exists(folder, error))
    throw hal::ConfigError(fmt::format("{} is there already; choose another name, or another folder", folder.string()));
  const std::vector<std::pair<std::string, std::string>> words = {
      {"experiments/light_up", folder.string()}, {"light_up", name}, {"LightUp", class_name(name)}, {"Light-up", name}};
  fs::create_directories(folder);
  for (const char* const file : {"README.md", "a.toml", "b.toml", "light_up.c", "light_up.py", "light_up_test.py"}) {
    std::ifstream in(scenarios::python::example_folder() / file);
    std::string text(std::istreambuf_iterator<char>(in), {}), to = file;
    for (const auto& [word, by] : words) replace_all(text, word, by);
    replace_all(to, "light_up", name);
    std::ofstream out(folder / to);
    if (text.empty() || !(out << text << std::flush))
      throw std::runtime_error(
          fmt::format("{} cannot be written; make room there, or choose another folder", (folder / to).string()));
  }
  fmt::print(
      "wrote {0}: {1}.py is the scenario, {1}.c the robots' program; README.md tells the rest\n"
      "  run it with arkmesh run {0}/a.toml {0}/b.toml --seconds 20\n",
      folder.string(), name);
}

}  // namespace

void add_scenario_command(CLI::App* command) {
  command->require_subcommand(1);
  CLI::App* make = command->add_subcommand("new", "Write a folder with a scenario that runs at once, to be changed");
  const auto folder = std::make_shared<std::string>();
  make->add_option("folder", *folder, "The folder; its last part is the scenario's name")->required();
  make->add_flag("--python")->description("In Python, as they all are so far");
  make->callback([folder] { write_new(*folder); });
  command->add_subcommand("path", "Print the folder of Python's package arkmesh")->callback([] {
    fmt::print("{}\n", scenarios::python::package_folder().string());
  });
  command->footer("Examples:\n  arkmesh scenario new my_swarm\n  export PYTHONPATH=\"$(arkmesh scenario path)\"");
}

}  // namespace arkmesh::cli
