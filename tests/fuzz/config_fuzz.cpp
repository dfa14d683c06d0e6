// Feeds text to the configuration reader and reads it as a lab would. What follows a zero byte is an override. Whatever
// comes, it ends in a ConfigError or in an effective configuration that loads again and says the same.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "hal/arenas/arena_config.hpp"
#include "hal/config/config.hpp"

using namespace arkmesh::hal;

namespace {

struct Peer {
  std::string lab;
  void fields(const Section& peer) { peer.field("lab", lab, {.required = true}); }
};

struct Lab {
  std::string name = "shark", use = "ode";
  std::filesystem::path controller;
  std::vector<std::string> labs{"roark", "shark"};
  std::map<std::string, double, std::less<>> scale;
  std::map<std::string, std::vector<std::int64_t>, std::less<>> requirements{{"shark", {2, 4}}};
  std::vector<Peer> peers;
  bool blank = false;

  void fields(const Section& root) {
    root.section("lab").field("name", name);
    root.section("arena").field("use", use, {.one_of = {"ode", "replay", "null"}});
    root.section("arena").field("blank", blank);
    root.section("arena.ode").field("controller", controller);
    root.section("shared").field("labs", labs);
    root.section("shared").field("scale", scale, {.range = {0, 10}});
    root.section("gateway").field("peers", peers);
    root.section("scenario.dhtf").field("requirements", requirements, {.range = {1, 100}});
  }
};

void read_as_lab(const Config& config) {
  config.root().read<Lab>();
  read_arena_config(config.root().section("arena"), 0.0165);
  config.root().section("arena").leave_alone("replay");
  config.refuse_unknown();
}

std::string without_comment(const std::string& text) {
  return text.substr(text.find('\n'));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::size_t zero = input.find('\0');
  std::vector<std::string> overrides;
  if (zero != std::string_view::npos) overrides.emplace_back(input.substr(zero + 1));
  std::string effective;
  try {
    const Config config = Config::from_text(input.substr(0, zero), "fuzz.toml", overrides);
    read_as_lab(config);
    effective = config.effective();
  } catch (const ConfigError&) {
    return 0;
  }
  try {
    const Config again = Config::from_text(effective, "again.toml");
    read_as_lab(again);
    if (without_comment(again.effective()) == without_comment(effective)) return 0;
    std::cerr << "differs after loading again:\n" << effective << "\nand:\n" << again.effective();
  } catch (const ConfigError& error) {
    std::cerr << "does not load again: " << error.what() << "\n" << effective;
  }
  std::abort();
}
