// Feeds text to the configuration reader and reads it as a lab would. What follows a zero byte is an override. Whatever
// comes, it ends in a ConfigError or in an effective configuration that loads again and says the same.
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "hal/arena_config.hpp"
#include "hal/config.hpp"

using namespace arkmesh::hal;

namespace {

void read_as_lab(const Config& config) {
  const Section root = config.root();
  root.section("lab").text("name", "shark");
  const Section arena = root.section("arena");
  arena.choice("use", "ode", {"ode", "replay", "null"});
  read_arena_config(arena, 0.0165);
  if (arena.has("ode")) arena.section("ode").path("controller", "");
  arena.leave_alone("replay");
  const Section shared = root.section("shared");
  shared.texts("labs", {"roark", "shark"});
  for (const std::string& lab : shared.names_below("projection"))
    shared.section("projection").section(lab).number("scale", 1, {0, 10});
  for (const Section& peer : root.section("gateway").sections("peers")) peer.required_text("lab");
  const Section dhtf = root.section("scenario").section("dhtf");
  dhtf.names_below("requirements");
  dhtf.section("requirements").numbers("shark", {2, 4}, {1, 100});
  dhtf.flag("blank", false);
  dhtf.integer("sites", 8, 0, 16);
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
