// Labs with more robots than can be addressed, or told of, are refused with the number that fits.
#include "app/robot_limits.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <string>

#include "app/joint_run.hpp"
#include "lab/exchange/world_message.hpp"
#include "tests/support/labs/dhtf_labs.hpp"

using namespace arkmesh;

namespace {

// What two labs with so many robots each are refused with.
std::string refused(int robots, const std::string& more = "run.seed=1") {
  const tests::TemporaryFolder folder;
  std::vector<hal::Config> configs;
  for (const char* lab : {"shark", "roark"})
    configs.push_back(hal::Config::from_file(
        tests::experiments() / "dhtf" / (std::string(lab) + ".toml"),
        {"arena.use=null", "arena.width_m=20", "arena.height_m=20", fmt::format("arena.robots={}", robots), more}));
  try {
    app::JointRun run(std::move(configs), folder.path());
    for (int i = 0; i < 5; ++i) run.step();
    return run.lab(0).runner().reason();
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
}

struct AddressesNobody {
  explicit AddressesNobody(bool addresses = false) { app::catalogue().front().addresses_robots = addresses; }
  ~AddressesNobody() { app::catalogue().front().addresses_robots = true; }
};

}  // namespace

TEST_CASE("labs have as many robots as a scenario can speak to") {
  CHECK(refused(1023) == "");
  const std::string said = refused(1100);
  CHECK(said.find("arena.robots = 1100: ids above 1022 cannot be addressed individually; 1023 of the 1100 robots can. "
                  "Scenario dhtf addresses robots individually; use at most 1023 robots") != std::string::npos);
  const AddressesNobody nobody;
  CHECK(refused(1100) == "");
}

TEST_CASE("robots' messages have room for what a scenario says") {
  const auto with = [](const std::string& layout) { return refused(5, "arena.kilobot.layout=" + layout); };
  CHECK(with("\"ark\"") == "");
  CHECK(with("{id_bits=10,kind_bits=2}") == "");
  CHECK(with("\"8+16\"")
            .find("arena.kilobot.layout = \"8+16\": has room for kinds up to 0 and values up to 65535, but scenario "
                  "dhtf sends kinds up to 2 and values up to 1023") != std::string::npos);
}

TEST_CASE("labs have as many robots as fit a message") {
  const AddressesNobody nobody;
  const std::string said = refused(40'000);
  const auto at = said.find("use at most ");
  REQUIRE(at != std::string::npos);
  CHECK(said.find("at most 983040 fit (gateway.max_message_bytes)") != std::string::npos);
  const int fit = std::stoi(said.substr(at + 12));
  CHECK(refused(fit) == "");
  CHECK(refused(fit + 1).find("arena.robots") != std::string::npos);
  CHECK(refused(40'000, "gateway.max_message_bytes=2000000") == "");
  CHECK(refused(70'000).find("ids up to 65535 only; use at most 65536 robots") != std::string::npos);
}
