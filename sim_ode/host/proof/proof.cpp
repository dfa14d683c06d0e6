#include "sim_ode/host/proof/proof.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "hal/counted.hpp"
#include "hal/files/scratch_folder.hpp"
#include "sim_ode/host/programs/compiler_limits.hpp"
#include "sim_ode/host/programs/content_hash.hpp"
#include "sim_ode/host/programs/controller_check.hpp"
#include "sim_ode/host/programs/program_cache.hpp"
#include "sim_ode/host/programs/robot_program.hpp"
#include "sim_ode/host/programs/width_warnings.hpp"
#include "sim_ode/host/proof/program_variables.hpp"

namespace arkmesh::sim_ode {
namespace {

namespace fs = std::filesystem;

// The program of the emulator, compiled when it is first needed.
fs::path emulator(const fs::path& scratch) {
  const fs::path source = silicon_folder() / "emulator.c";
  ContentHash hash;  // of its parts, too
  for (const char* part : {"calls.h", "log.h", "state.h"}) hash.add(read_source(silicon_folder() / part));
  hash.add(read_source(source));
  const fs::path cache = ProgramCache::folder_of_user();
  const fs::path kept = cache.empty() ? fs::path() : cache / ("emulator-" + hash.name());
  std::error_code error;
  if (!kept.empty() && access(kept.c_str(), X_OK) == 0) return kept;
  const fs::path made = scratch / "emulator";
  const CompilerLimits limits;
  const hal::Finished done =
      hal::run_to_end({.command = {"cc", "-O2", source.string(), "-o", made.string(), "-lsimavr", "-lelf", "-lm"},
                       .processor_time = limits.work},
                      limits.time);
  if (done.status != 0)
    throw std::runtime_error(
        lines_with(done.output, {"simavr", "-lelf"}, 1).empty()
            ? "the emulator of the robot's processor does not compile: " + done.output.substr(0, done.output.find('\n'))
            : "simavr, the emulator of the robot's processor, is missing; apt-get install libsimavr-dev libelf-dev");
  if (kept.empty()) return made;
  fs::create_directories(cache, error);
  const fs::path fresh = kept.string() + fmt::format(".{}", getpid());
  fs::copy_file(made, fresh, error);
  if (!error) fs::rename(fresh, kept, error);
  return error ? made : kept;
}

// For all robots together: what an emulator does in some 8 s.
constexpr std::uint64_t most_cycles = 500'000'000;

struct Difference {
  char kind = 0;
  int robot = 0, leaf = -1, others = 0;
  long segment = 0, count = 0;
  unsigned tick = 0, from = 0, seen_tick = 0;
  std::string here, there, cycles, called, seen_here, seen_there, function, place;
};

// A build of the program in the emulator.
class Silicon {
 public:
  Silicon(const ReadProgram& program, const std::string& name, std::vector<std::string> options,
          const std::string& processor, const fs::path& emulator)
      : build_(program, name, std::move(options), processor), processor_(processor), emulator_(emulator) {
    const hal::Finished bytes = run_avr(
        {"avr-objcopy", "-O", "binary", "-R", ".eeprom", build_.elf().string(), (folder() / "program.bin").string()});
    if (bytes.status != 0) throw std::runtime_error("avr-objcopy cannot read the program");
    std::istringstream symbols(run_avr({"avr-nm", build_.elf().string()}).output);
    for (std::string address, type, symbol; symbols >> address >> type >> symbol;) symbols_[symbol] = address;
    // our own table: that of functions which the linker has left out, at address 0, misleads avr-addr2line
    std::istringstream rows(run_avr({"avr-readelf", "-W", "--debug-dump=decodedline", build_.elf().string()}).output);
    for (std::string row, file, line, address; std::getline(rows, row);)
      if (std::istringstream words(row); words >> file >> line >> address && address.starts_with("0x"))
        lines_[static_cast<unsigned>(std::strtoul(address.c_str(), nullptr, 16))] = file + ":" + line;
  }

  const AvrBuild& build() const { return build_; }
  const fs::path& folder() const { return build_.folder(); }

  // `simulated`: the same variables in a simulated robot's memory, which begins at `begin`.
  void match(const ProgramVariables& simulated, std::uint64_t begin) {
    const ProgramVariables own = ProgramVariables::read("avr-readelf", build_.elf(), folder());
    std::ofstream table(folder() / "table");
    for (const auto& [word, symbol] :
         std::initializer_list<std::pair<const char*, const char*>>{{"ticks", "kilo_ticks"},
                                                                    {"uid", "kilo_uid"},
                                                                    {"turn_left", "kilo_turn_left"},
                                                                    {"turn_right", "kilo_turn_right"},
                                                                    {"straight_left", "kilo_straight_left"},
                                                                    {"straight_right", "kilo_straight_right"},
                                                                    {"high", "kilo_irhigh"},
                                                                    {"low", "kilo_irlow"},
                                                                    {"message", "arkmesh_message"},
                                                                    {"distance", "arkmesh_distance"}})
      table << fmt::format("{} {}\n", word, address(symbol) & 0xFFFF);
    for (const auto& [name, here] : own.numbers) {
      const auto there = simulated.numbers.find(name);
      if (there == simulated.numbers.end() || there->second.address < begin || here.address >> 16 != 0x80) continue;
      if (there->second.address - begin > 65000) continue;
      table << fmt::format("{} {} {} {} {}\n", here.address & 0xFFFF, here.bytes, there->second.address - begin,
                           there->second.bytes, here.type);
      names_.emplace_back(name, here.type);
    }
    for (const std::string& name : own.others)
      if (!name.starts_with("kilo_") && !name.starts_with("arkmesh_")) others_.push_back(name);
  }
  const std::pair<std::string, char>& number(int leaf) const { return names_[static_cast<std::size_t>(leaf)]; }
  const std::vector<std::string>& others() const { return others_; }

  // Returns what the emulator says, in lines.
  std::vector<std::vector<std::string>> run(const std::vector<std::string>& logs) const {
    const fs::path said = folder() / "said";
    std::vector<std::string> command = {emulator_.string(),
                                        said.string(),
                                        processor_,
                                        (folder() / "program.bin").string(),
                                        fmt::format("{}", address("_end")),
                                        fmt::format("{}", address("__brkval")),
                                        (folder() / "table").string(),
                                        fmt::format("{}", most_cycles)};
    command.insert(command.end(), logs.begin(), logs.end());
    const hal::Finished done = hal::run_to_end({.command = std::move(command)}, std::chrono::minutes(30));
    if (done.status != 0)
      throw std::runtime_error(
          fmt::format("the emulator of the robot's processor ended with {}: {}", done.status, done.output));
    std::vector<std::vector<std::string>> out;
    std::ifstream in(said);
    for (std::string line, word; std::getline(in, line);) {
      std::istringstream words(line);
      for (out.emplace_back(); std::getline(words, word, '\t');) out.back().push_back(word);
      out.back().resize(std::max<std::size_t>(out.back().size(), 17));
    }
    return out;
  }

  // The function, and "prog.c:17"; empty when it is none of the program's.
  std::pair<std::string, std::string> place_of(unsigned instruction) const {
    std::string function;
    std::istringstream(
        run_avr({"avr-addr2line", "-f", "-s", "-e", build_.elf().string(), fmt::format("{:#x}", instruction)})
            .output) >>
        function;
    auto line = lines_.upper_bound(instruction);
    if (function.empty() || function == "??" || line == lines_.begin()) return {};
    --line;
    if (line->second.starts_with("kilolib.c:") || line->second.starts_with("robot_pure.h:")) return {};
    return {function, line->second};
  }

 private:
  unsigned address(const std::string& symbol) const {
    const auto found = symbols_.find(symbol);
    return found == symbols_.end() ? 0 : static_cast<unsigned>(std::strtoul(found->second.c_str(), nullptr, 16));
  }
  AvrBuild build_;
  std::string processor_;
  fs::path emulator_;
  std::map<std::string, std::string> symbols_;
  std::map<unsigned, std::string> lines_;  // by address
  std::vector<std::pair<std::string, char>> names_;
  std::vector<std::string> others_;
};

// What the compiler's checks find, by robot and segment: "a sum overflows (line 12)".
using Reasons = std::map<std::pair<int, long>, std::string>;

const char* words_of(char check) {
  switch (check) {
    case '+':
    case '-':
    case '*':
      return "the result overflows a 16-bit int";
    case '<':
      return "a shift loses bits of a 16-bit int";
    case '[':
      return "an index is beyond its array";
    case 'f':
      return "a floating-point number is beyond the integer's range";
    default:
      return "a division by zero";
  }
}

// Of a whole number that differs by a multiple of 65536; the compiler's checks do not look at unsigned ones.
std::string wrapping_of(const Difference& what, const Silicon& silicon) {
  if (what.kind != 'v' || silicon.number(what.leaf).second == 'f') return {};
  const auto value = [](const std::string& of) { return static_cast<unsigned>(std::strtoll(of.c_str(), nullptr, 10)); };
  return (value(what.here) - value(what.there)) % 65536 == 0 ? "16-bit unsigned numbers wrap around" : "";
}

// Of numbers that are on a robot what fills its memory at the start, and are not here: a robot's holds what was there
// before.
std::string unset_of(const Difference& what) {
  const auto unset = [](const std::string& number) {
    char* end = nullptr;
    const auto value = static_cast<unsigned>(std::strtoll(number.c_str(), &end, 10));
    constexpr unsigned fill = 0xC5C5C5C5;  // emulator.c's `painted`
    return *end == 0 && (value == (fill & 0xFF) || value == (fill & 0xFFFF) || value == fill ||
                         value == 0xFFFF0000 + (fill & 0xFFFF) || value == 0xFFFFFF00 + (fill & 0xFF));
  };
  bool all = true, some = false;
  std::istringstream here(what.kind == 'o' ? what.seen_here : what.here);
  std::istringstream there(what.kind == 'o' ? what.seen_there : what.there);
  for (std::string one, other; here >> one && there >> other;)
    if (one != other) some = true, all = all && unset(one);
  return some && all ? "the program never sets it: memory holds an earlier value" : "";
}

std::string sentence(const Difference& what, const std::string& reason, const Silicon& silicon) {
  const char* const called = what.called == "L" ? "loop" : what.called == "S" ? "setup" : "a callback";
  std::string out = fmt::format("robot {}, tick {}: ", what.robot, what.tick);
  const std::string at = what.place.empty() ? "" : fmt::format(" in {} ({})", what.function, what.place);
  switch (what.kind) {
    case 'v':
      out += fmt::format("{} is {} on a robot and {} here, set{}{}", silicon.number(what.leaf).first, what.here,
                         what.there, at.empty() ? fmt::format(" in {}", called) : at,
                         what.others > 1 ? fmt::format(", with {}", hal::counted(what.others - 1, "more number")) : "");
      break;
    case 'o':
      out += fmt::format("{} on a robot and {} here{}", what.seen_here, what.seen_there, at);
      break;
    case 'x':
      out += fmt::format("the program crashes on a robot, in a call of {}", called);
      break;
    case 'h':
      out += fmt::format("{} never returns on a robot{}", called, at);
      break;
    case 'm':
      out += "static memory, heap and stack exceed a robot's 2048 bytes: the stack has overwritten variables";
      break;
    default:
      out += fmt::format("{} takes {} cycles on a robot, {:.1f} ticks, and no time here", called, what.cycles,
                         std::stod(what.cycles) / 262144);
  }
  if (!reason.empty()) out += "; " + reason;
  if (what.kind == 'v')
    out += what.seen_here.empty() ? "; not seen in an output"
                                  : fmt::format("; first seen at tick {}: {} on a robot, {} here", what.seen_tick,
                                                what.seen_here, what.seen_there);
  if (what.count > 1) out += fmt::format("; {} more", hal::counted(what.count - 1, "time"));
  return out;
}

// Those of one line and variable are one.
std::vector<Difference> merged(std::vector<Difference> found, const Silicon& silicon) {
  std::vector<Difference> out;
  const auto variable = [&](const Difference& of) {
    return of.kind == 'v' ? silicon.number(of.leaf).first.substr(0, silicon.number(of.leaf).first.find('[')) : "";
  };
  for (Difference& one : found) {
    std::tie(one.function, one.place) = silicon.place_of(one.kind == 'o' && one.from >= 2 ? one.from - 2 : one.from);
    const auto same = std::ranges::find_if(out, [&](const Difference& other) {
      return other.kind == one.kind && other.place == one.place && variable(other) == variable(one) &&
             (!one.place.empty() || other.from == one.from);
    });
    if (same == out.end())
      out.push_back(std::move(one));
    else
      same->count += one.count;
  }
  return out;
}

}  // namespace

Proof prove_program(const ProgramSources& sources, const TurnLog& log) {
  const ReadProgram program(sources);
  const std::shared_ptr<const RobotProgram> simulated = RobotProgram::load(sources);
  const hal::ScratchFolder scratch("prove");
  const fs::path tool = emulator(scratch.path());
  std::vector<std::string> options = {"-gdwarf-2", "-fno-optimize-sibling-calls"};
  options.insert(options.end(), warning_options.begin(), warning_options.end());
  options.insert(options.end(), dump_options.begin(), dump_options.end());
  Silicon silicon(program, sources.name(), options, "atmega328p", tool);
  Proof out;
  out.notes = warnings_in(silicon.build().said());
  const Widths widths = widths_of(silicon.folder(), silicon.build().said());
  const Sizes sizes = silicon.build().sizes();
  if (sizes.flash > flash_limit_bytes || sizes.ram > ram_limit_bytes) {
    out.causes.push_back(fmt::format("it does not fit on a robot: flash {} of {} bytes, static RAM {} of {}",
                                     sizes.flash, flash_limit_bytes, sizes.ram, ram_limit_bytes));
    return out;
  }

  const ProgramVariables variables = ProgramVariables::read("readelf", simulated->object(), scratch.path());
  silicon.match(variables, simulated->memory_address());
  if (log.robots() == 0) throw std::runtime_error("no robot ran, so nothing was compared");
  std::vector<std::string> logs;
  const auto log_of = [&](int robot) { return (scratch.path() / std::to_string(robot)).string(); };
  for (int robot = 0; robot < log.robots(); ++robot) {
    if (log.of_robot(robot).empty()) continue;
    logs.push_back(log_of(robot));
    std::ofstream(logs.back(), std::ios::binary) << log.of_robot(robot);
  }

  std::vector<Difference> found;
  long heap = 0, stack = 0, longest = 0, shortest = 0;
  for (const std::vector<std::string>& line : silicon.run(logs)) {
    const auto number = [&](std::size_t at) { return std::strtol(line[at].c_str(), nullptr, 10); };
    if (line[0] == "cause")
      found.push_back({.kind = line[2][0],
                       .robot = static_cast<int>(number(3)),
                       .leaf = static_cast<int>(number(7)),
                       .others = static_cast<int>(number(8)),
                       .segment = number(4),
                       .tick = static_cast<unsigned>(number(5)),
                       .from = static_cast<unsigned>(number(6)),
                       .seen_tick = static_cast<unsigned>(number(13)),
                       .here = line[9],
                       .there = line[10],
                       .cycles = line[11],
                       .called = line[12],
                       .seen_here = line[14],
                       .seen_there = line[15]});
    if (line[0] == "count") found[static_cast<std::size_t>(number(1))].count = number(2);
    if (line[0] == "robot")
      heap = std::max(heap, number(2)), stack = std::max(stack, number(3)), longest = std::max(longest, number(4));
    if (line[0] == "robot" && number(5) > 0) shortest = shortest == 0 ? number(5) : std::min(shortest, number(5));
  }

  // The same again with the compiler's checks, on a processor with room for them.
  Reasons reasons;
  if (!found.empty()) {
    options.insert(options.end(), {"-DARKMESH_SANITIZED",
                                   "-fsanitize=signed-integer-overflow,shift,bounds,float-cast-overflow,"
                                   "integer-divide-by-zero"});
    std::set<std::string> again;
    for (const Difference& one : found) again.insert(log_of(one.robot));
    try {
      Silicon checked(program, sources.name(), options, "atmega1284p", tool);
      checked.match(variables, simulated->memory_address());
      for (const std::vector<std::string>& line : checked.run({again.begin(), again.end()}))
        if (line[0] == "check")
          reasons.try_emplace({std::stoi(line[1]), std::stol(line[2])},
                              fmt::format("{} at line {}", words_of(line[3][0]), line[4]));
    } catch (const std::runtime_error&) {
      // too large with checks: differences are told without reasons
    }
  }
  const bool memory_told = std::ranges::any_of(found, [](const Difference& one) { return one.kind == 'm'; });
  for (const Difference& one : merged(std::move(found), silicon)) {
    const auto reason = reasons.find({one.robot, one.segment});
    std::string why = reason == reasons.end() ? wrapping_of(one, silicon) : reason->second;
    if (why.empty()) why = unset_of(one);
    const std::string function = !one.function.empty() ? one.function : one.called == "L" ? "loop" : "";
    if (const Otherwise* const other = why.empty() ? widths.near(function, one.place) : nullptr)
      why = fmt::format("{} (line {})", other->what, other->place.substr(other->place.rfind(':') + 1));
    const bool harmless = one.kind == 'v' && one.seen_here.empty() && silicon.number(one.leaf).second == 'f';
    (harmless ? out.notes : out.causes).push_back(sentence(one, why, silicon));
  }
  if (sizes.ram + heap + stack > ram_limit_bytes && !memory_told)
    out.causes.push_back("static memory, heap and stack exceed a robot's 2048 bytes");
  out.figures = fmt::format(
      "memory at most {} of {} bytes (static {}, heap {}, stack {}); longest call {} cycles, {:.2f} ms",
      sizes.ram + heap + stack, ram_limit_bytes, sizes.ram, heap, stack, longest, static_cast<double>(longest) / 8000);
  if (shortest > 0)
    out.figures +=
        fmt::format("; its calls are so long that only the first {} ticks of each robot were compared", shortest);
  if (!silicon.others().empty())
    out.not_compared = fmt::format("not compared because they contain pointers, unions or bit fields: {}",
                                   fmt::join(silicon.others(), ", "));
  return out;
}

}  // namespace arkmesh::sim_ode
