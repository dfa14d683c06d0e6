// Which commands a lab takes from its operators, and what becomes of all others.
#include "lab/operator/operator_desk.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "hal/config/config.hpp"
#include "hal/record/event_log.hpp"
#include "tests/lab/operator_bench.hpp"
#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::tests {
namespace {

using namespace std::chrono_literals;
using Now = lab::OperatorDesk::Now;
constexpr std::uint8_t run = fleet_command_t::run, pause_robots = fleet_command_t::pause,
                       reset_robots = fleet_command_t::reset;

// Run 5 of lab "a".
struct DeskBench {
  DeskBench() { key.make(), key.read(); }
  static lab::RunConfig config_of(const lab::OperatorKey& key) {
    lab::RunConfig config;
    config.lab = "a";
    config.safety.commands_from = {"b", "c"};
    config.operator_key = key.file();
    return config;
  }
  TemporaryDirectory folder;
  lab::OperatorKey key{folder.path() / "keys/operator.key"};
  hal::Recorder recorder{folder.path() / "run", 0, {}};
  hal::OwnedClock clock;
  lab::OperatorDesk desk{config_of(key), 5, recorder, clock};
  Now now{0};

  void hear(const operator_command_t& message) { hear(encoded(message)); }
  void hear(std::span<const std::byte> bytes) { desk.hear(lab::operator_channel, bytes, now += 1ms); }
  std::uint64_t refused(const std::string& why) const { return desk.counters()["operator.refused." + why]; }
  std::vector<int> taken() {
    std::vector<int> out;
    for (const auto& taken : desk.take()) out.push_back(taken.command.command);
    return out;
  }
};

std::string key_refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST_CASE("a command counts once, for this run of this lab, and by the user's key alone") {
  DeskBench bench;
  const operator_command_t good = command_for_a(bench.key, pause_robots, 7);
  bench.hear(good);
  CHECK(bench.taken() == std::vector<int>{pause_robots});
  bench.hear(good);
  bench.hear(command_for_a(bench.key, run, 7));
  CHECK(bench.refused("replayed") == 2);
  bench.hear(command_for_a(bench.key, run, 8, 4));
  CHECK(bench.refused("other_run") == 1);
  operator_command_t other = command_for_a(bench.key, run, 8);
  other.lab = "b";
  bench.hear(other);
  CHECK(bench.desk.counters()["operator.for_other_lab"] == 1);
  lab::OperatorKey stranger(bench.folder.path() / "stranger/operator.key");
  stranger.make(), stranger.read();
  bench.hear(command_for_a(stranger, run, 8));
  CHECK(bench.refused("bad_proof") == 1);
  bench.hear(command_for_a(bench.key, 200, 8));
  CHECK(bench.refused("unknown") == 1);
  bench.hear(std::as_bytes(std::span("junk")));
  CHECK(bench.refused("undecodable") == 1);
  CHECK(bench.taken().empty());
  CHECK_FALSE(bench.desk.end_asked());
  bench.hear(command_for_a(bench.key, operator_command_t::stop, 6));
  CHECK(bench.desk.end_asked());
  CHECK(bench.desk.counters()["operator.commands"] == 2);
  bench.desk.close();
  bench.hear(command_for_a(bench.key, run, 9));
  CHECK(bench.refused("ended") == 1);
}

TEST_CASE("each command with a number has an answer, which a flood of forged ones does not hide") {
  DeskBench bench;
  lab::OperatorKey stranger(bench.folder.path() / "stranger/operator.key");
  stranger.make(), stranger.read();
  bench.hear(command_for_a(bench.key, pause_robots, 7));
  bench.hear(command_for_a(bench.key, 200, 8));
  const auto answers = [&] {
    std::string out;
    for (const operator_answer_t& each : bench.desk.take_answers(bench.now)) {
      CHECK(each.lab == "a");
      CHECK(each.run_id == 5);
      CHECK(each.clock_us == bench.now.count());
      out += std::to_string(each.number) + each.refusal + ' ';
    }
    return out;
  };
  CHECK(answers() == "7 8unknown ");
  CHECK(answers().empty());
  bench.hear(command_for_a(bench.key, pause_robots, 9));
  for (int i = 0; i < 100; ++i) bench.hear(command_for_a(stranger, run, 1000 + i));
  for (int i = 0; i < 100; ++i) bench.hear(lab::question());
  CHECK(answers() ==
        "9 1092bad_proof 1093bad_proof 1094bad_proof 1095bad_proof 1096bad_proof 1097bad_proof 1098bad_proof "
        "1099bad_proof 0 ");
  for (int i = 0; i < 100; ++i) bench.hear(command_for_a(bench.key, pause_robots, 100 + i));
  CHECK(answers() == "192 193 194 195 196 197 198 199 ");
}

TEST_CASE("what the own operator says in the lab's process needs no proof, and is judged and kept like the rest") {
  DeskBench bench;
  bench.desk.ask(has_signed);
  CHECK(bench.desk.perform(pause_robots, bench.now += 1ms).empty());
  CHECK(bench.taken() == std::vector<int>{pause_robots});
  CHECK(bench.desk.perform(operator_command_t::arm, bench.now += 1ms).empty());
  CHECK(bench.desk.armed());
  CHECK(bench.desk.perform(pause_robots, bench.now += 1ms).empty());
  CHECK_FALSE(bench.desk.armed());  // as whenever the own operator pauses
  CHECK(bench.desk.perform(200, bench.now += 1ms).find("this version does not know the command") != std::string::npos);
  CHECK(bench.refused("unknown") == 1);
  bench.hear(command_for_a(bench.key, run, 1));  // numbers of those with a proof go on
  CHECK(bench.taken() == std::vector<int>{pause_robots, run});
  CHECK(bench.desk.perform(operator_command_t::stop, bench.now += 1ms).empty());
  CHECK(bench.desk.end_asked());
  bench.desk.close();
  CHECK(bench.desk.perform(run, bench.now += 1ms) == "the run has ended");
  bench.recorder.flush();
  hal::EventLogReader log(bench.folder.path() / "run/log.lcm");
  int events = 0;
  while (log.next()) ++events;
  CHECK(events == 5);
}

TEST_CASE("who asks for a status gets one, without a proof, and nothing else comes of it") {
  DeskBench bench;
  CHECK_FALSE(bench.desk.is_asked());
  for (int i = 0; i < 3; ++i) bench.hear(lab::question());
  CHECK(bench.desk.is_asked());
  CHECK(bench.desk.take_answers(bench.now).size() == 1);
  CHECK_FALSE(bench.desk.is_asked());
  bench.hear(command_for_a(bench.key, pause_robots, 1));
  CHECK(bench.desk.is_asked());
  CHECK(bench.taken() == std::vector<int>{pause_robots});
  const hal::Counters counters = bench.desk.counters();
  for (const auto& [name, n] : counters.all()) CHECK(name.find("refused") == std::string::npos);
}

TEST_CASE("every bit of a command is proved") {
  DeskBench bench;
  const std::vector<std::byte> good = encoded(command_for_a(bench.key, pause_robots, 1));
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::vector<std::byte> changed = good;
    changed[bit / 8] ^= std::byte{1} << bit % 8;
    bench.hear(changed);
  }
  CHECK(bench.taken().empty());
  bench.hear(good);
  CHECK(bench.taken().size() == 1);
}

TEST_CASE("what is refused is not recorded") {
  DeskBench bench;
  const operator_command_t good = command_for_a(bench.key, pause_robots, 1);
  bench.hear(good);
  for (int i = 0; i < 1000; ++i) bench.hear(good);
  bench.recorder.flush();
  hal::EventLogReader log(bench.folder.path() / "run/log.lcm");
  int events = 0;
  while (log.next()) ++events;
  CHECK(events == 1);
}

TEST_CASE("another lab's operator makes robots stand with permission, and run while the lab is armed, not too often") {
  DeskBench bench;
  bench.desk.ask(has_signed);
  constexpr std::uint8_t arm = operator_command_t::arm, disarm = operator_command_t::disarm;
  std::int64_t number = 0;
  const auto own = [&](std::uint8_t command) { bench.hear(command_for_a(bench.key, command, ++number)); };
  const auto peer = [&](const std::string& who, const operator_command_t& message) {
    bench.desk.hear(who + "/operator_command", encoded(message), bench.now += 1ms);
  };
  const auto armed = [&] { return bench.desk.counters()["operator.armed"] == 1 && bench.desk.armed(); };

  peer("b", command_of("b", run, 1));  // never armed after a start
  CHECK(bench.refused("not_armed") == 1);
  for (std::int64_t n = 1; n <= 20; ++n) peer("c", command_of("c", pause_robots, n));  // in 20 ms, unarmed
  CHECK(bench.taken() == std::vector<int>(20, pause_robots));
  peer("b", command_of("b", arm, 1));
  CHECK(bench.refused("not_for_peers") == 1);
  CHECK_FALSE(armed());
  own(arm);
  CHECK(armed());
  peer("d", command_of("d", pause_robots, 1));
  CHECK(bench.refused("no_permission") == 1);
  peer("b", command_for_a(bench.key, pause_robots, 1));
  peer("b", command_of("c", pause_robots, 1));
  CHECK(bench.refused("bad_proof") == 2);
  CHECK(bench.taken().empty());

  peer("b", command_of("b", pause_robots, 1));
  CHECK(bench.taken() == std::vector<int>{pause_robots});
  CHECK(armed());
  peer("b", command_of("b", run, 2));
  peer("b", command_of("b", run, 3));
  CHECK(bench.refused("too_often") == 1);
  peer("b", command_of("b", pause_robots, 3));
  CHECK(bench.taken() == std::vector<int>{run, pause_robots});
  bench.now += 1s;
  peer("b", command_of("b", pause_robots, 1));
  CHECK(bench.refused("replayed") == 1);
  peer("b", command_of("b", reset_robots, 4));
  peer("b", command_of("b", disarm, 4));
  CHECK(bench.refused("not_for_peers") == 3);
  peer("b", command_of("b", run, 4));
  peer("c", command_of("c", run, 21));
  CHECK(bench.taken() == std::vector<int>{run, run});
  CHECK(bench.desk.counters()["operator.commands.b"] == 4);
  operator_command_t for_b = command_of("b", pause_robots, 5);
  for_b.lab = "b";  // what that lab's operator tells that lab comes here, too
  peer("b", for_b);
  CHECK(bench.desk.counters()["operator.for_other_lab"] == 1);

  // The own operator's pause of the whole world leaves it armed; pause, reset, stop and disarm here end it.
  own(arm);
  operator_command_t world = command_for_a(bench.key, pause_robots, ++number);
  world.command.type = operator_command_t::of_world;
  std::ranges::copy(bench.key.prove(lab::proved_bytes(world)).value(), world.proof);
  bench.hear(world);
  CHECK(armed());
  bench.now += 1s;
  for (const std::uint8_t last : {pause_robots, reset_robots, disarm}) {
    own(arm);
    CHECK(armed());
    own(last);
    CHECK_FALSE(armed());
    peer("b", command_of("b", run, 5));
  }
  CHECK(bench.refused("not_armed") == 4);
  peer("b", command_of("b", operator_command_t::stop, 6));
  CHECK(bench.desk.end_asked());
  CHECK_FALSE(armed());
}

TEST_CASE("a flood of forged signatures costs a lab few looks") {
  DeskBench bench;
  int asked = 0;
  bench.desk.ask([&](const std::string& peer, auto bytes, auto signature) {
    ++asked;
    return has_signed(peer, bytes, signature);
  });
  bench.hear(command_for_a(bench.key, operator_command_t::arm, 1));
  for (int i = 0; i < 900; ++i)
    bench.desk.hear("b/operator_command", encoded(command_of("x", pause_robots, 1)), bench.now += 1ms);
  CHECK(asked <= 50);
  CHECK(bench.refused("bad_proof") + bench.refused("too_often") == 900);
  CHECK(bench.taken().empty());
}

TEST_CASE("a command that was long on its way is too old") {
  // As over a link that was down: who asked for it is gone, or hands are among the robots by now.
  DeskBench bench;
  bench.now = 100s;
  bench.hear(command_for_a(bench.key, run, 1));
  CHECK(bench.refused("too_old") == 1);
  bench.now = 20s;
  bench.hear(command_for_a(bench.key, run, 1));
  CHECK(bench.taken().size() == 1);
}

TEST_CASE("a lab with nobody to arm it for says so") {
  const TemporaryDirectory folder;
  hal::Recorder recorder(folder.path(), 0, {.log = false});
  hal::OwnedClock clock;
  lab::OperatorKey key(folder.path() / "operator.key");
  key.make(), key.read();
  lab::RunConfig config = DeskBench::config_of(key);
  config.safety.commands_from.clear();
  lab::OperatorDesk desk(config, 5, recorder, clock);
  desk.hear("operator_command", encoded(command_for_a(key, operator_command_t::arm, 1)), 1s);
  CHECK(desk.counters()["operator.refused.no_peers"] == 1);
  CHECK(desk.counters()["operator.armed"] == 0);
}

TEST_CASE("the audit has a line for each command, and only the first thousand of those refused") {
  DeskBench bench;
  bench.clock.set(1500ms);
  bench.hear(command_for_a(bench.key, operator_command_t::stop, 1));
  const auto lines = [&] {
    std::ifstream in(bench.folder.path() / "run/audit.csv");
    std::vector<std::string> all;
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  };
  // At once: what comes after it may be a power cut.
  REQUIRE(lines().size() == 2);
  CHECK(lines()[0] == "utc,lab_time_s,lab,command,outcome");
  CHECK(lines()[1].substr(20) == ",1.500,,stop,admitted");
  bench.hear(std::as_bytes(std::span("junk")));
  bench.desk.hear("b,\"\x1b/operator_command", encoded(command_of("b", pause_robots, 1)), bench.now);
  bench.hear(command_for_a(bench.key, reset_robots, 2));
  for (int i = 0; i < 5000; ++i) bench.hear(command_for_a(bench.key, run, 1));
  bench.recorder.flush();
  const auto all = lines();
  REQUIRE(all.size() == 1004);
  CHECK(all[2].substr(20) == ",1.500,,,undecodable");
  CHECK(all[3].substr(20) == ",1.500,b???,pause,no_permission");
  CHECK(all[4].substr(20) == ",1.500,,reset,admitted");
  CHECK(all[1002].substr(20) == ",1.500,,resume,replayed");
  CHECK(all[1003].substr(20) == ",1.500,,,further refusals are only counted");
}

TEST_CASE("the key of operators is made once, and refused when others can read it") {
  const TemporaryDirectory folder;
  lab::OperatorKey key(folder.path() / "keys/operator.key"), same(key.file());
  CHECK(key_refusal([&] { key.read(); }).find("there is no operator key") == 0);
  const mode_t before = ::umask(0);
  key.make();
  ::umask(before);
  key.read();
  same.make();
  same.read();
  const std::vector<std::uint8_t> bytes{1, 2, 3};
  CHECK(key.prove(bytes).value() == same.prove(bytes).value());
  struct stat facts {};
  REQUIRE(::stat(key.file().c_str(), &facts) == 0);
  CHECK((facts.st_mode & 07777) == 0600);
  for (const mode_t mode : {0640, 0604, 0620, 0644}) {
    REQUIRE(::chmod(key.file().c_str(), mode) == 0);
    CHECK(key_refusal([&] { same.read(); }).find("can be read or changed by other users") != std::string::npos);
  }
}

TEST_CASE("a lab reads the key of operators when it needs it") {
  // It is made after the lab's start, by the first command; it may be made anew; others can read it.
  DeskBench bench;
  std::filesystem::remove(bench.key.file());
  bench.hear(command_for_a(bench.key, run, 1));
  CHECK(bench.refused("no_key") == 1);
  bench.now += 1s;
  bench.key.make(), bench.key.read();
  bench.hear(command_for_a(bench.key, run, 1));
  CHECK(bench.taken().size() == 1);
  std::filesystem::remove(bench.key.file());
  bench.key.make(), bench.key.read();
  REQUIRE(::chmod(bench.key.file().c_str(), 0644) == 0);
  bench.now += 1s;
  bench.hear(command_for_a(bench.key, run, 2));
  CHECK(bench.refused("no_key") == 2);
  CHECK(bench.taken().empty());
}

}  // namespace
}  // namespace arkmesh::tests
