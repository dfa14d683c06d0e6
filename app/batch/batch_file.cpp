#include "app/batch/batch_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "hal/config/config_entries.hpp"
#include "hal/config/near_key.hpp"

namespace arkmesh::app {
namespace {

namespace fs = std::filesystem;
using hal::ConfigEntry;

const std::set<std::string, std::less<>> known_names = {"labs", "seeds", "set", "choices", "sweep", "plot"};
const std::set<std::string, std::less<>> plot_names = {"column", "over",  "by",     "kind",
                                                       "width",  "title", "xlabel", "ylabel"};
// What a batch says itself.
// Other columns of the table.
const std::set<std::string, std::less<>> fixed_columns = {"run", "setting", "seed", "state", "why", "final_hash"};
const std::set<std::string, std::less<>> own_keys = {"run.seed", "shared.labs"};

[[noreturn]] void refuse(const ConfigEntry& entry, std::string_view sentence) {
  throw hal::ConfigError(fmt::format("{}: {}: {}", entry.place, fmt::join(entry.path, "."), sentence));
}

std::string dotted(const std::vector<std::string>& path, std::size_t from) {
  return fmt::format("{}", fmt::join(path.begin() + static_cast<std::ptrdiff_t>(from), path.end(), "."));
}

// Collects the entries of one experiment file into a plan.
class PlanReader {
 public:
  PlanReader(const fs::path& file, BatchPlan& plan) : folder_(file.parent_path()), plan_(plan) {}

  void read(const ConfigEntry& entry) {
    const std::string& name = entry.path.front();
    if (name == "labs") return read_labs(entry);
    if (name == "seeds") return read_seeds(entry);
    if (name == "set") return read_set(entry);
    if (name == "choices") return read_choice(entry);
    if (name == "sweep") return read_sweep(entry);
    if (name == "plot") return read_plot(entry);
    const auto near = hal::near_key(name, known_names);
    refuse(entry, fmt::format("an experiment has no such key; {}",
                              near ? fmt::format("did you mean '{}'?", *near)
                                   : fmt::format("there are {}", fmt::join(known_names, ", "))));
  }

  // A further override of all runs, from the command line.
  void add(const std::string& set) {
    if (const auto owner = owners_.find(set.substr(0, set.find('='))); owner != owners_.end())
      throw hal::ConfigError(
          fmt::format("--set {}: the experiment itself varies this key; edit its file instead", set));
    plan_.labs.sets.push_back(set);
  }

 private:
  void read_labs(const ConfigEntry& entry) {
    if (entry.path.size() != 1 || !entry.is_list || entry.elements.empty())
      refuse(entry, "must be a list of the labs' files, such as [\"shark.toml\", \"roark.toml\"]");
    for (const ConfigEntry::Value& lab : entry.elements) {
      if (!lab.is_text) refuse(entry, fmt::format("{} is not a file name; put file names in quotes", lab.text));
      const fs::path path = (folder_of(entry) / lab.text).lexically_normal();
      std::error_code error;
      if (fs::is_directory(path, error))
        refuse(entry, fmt::format("{} is a folder; name the lab's file", path.string()));
      if (!fs::is_regular_file(path, error)) refuse(entry, fmt::format("there is no file {}", path.string()));
      if (std::ranges::find(plan_.labs.files, path.string()) != plan_.labs.files.end())
        refuse(entry, fmt::format("{} is listed twice; each lab of a run needs its own file", path.string()));
      plan_.labs.files.push_back(path.string());
    }
  }

  // Files are looked up beside the file that names them.
  fs::path folder_of(const ConfigEntry& entry) const {
    const fs::path from = entry.place.substr(0, entry.place.rfind(':'));
    return from.empty() ? folder_ : from.parent_path();
  }

  void read_seeds(const ConfigEntry& entry) {
    std::vector<std::string> parts;
    for (const ConfigEntry::Value& part : entry.elements) parts.push_back(part.text);
    if (!entry.is_list) parts.push_back(entry.value.text);
    try {
      if (entry.path.size() != 1) throw std::invalid_argument("must be a range \"1..100\" or a list");
      plan_.seeds = seeds_of(parts);
    } catch (const std::invalid_argument& wrong) {
      refuse(entry, wrong.what());
    }
  }

  std::string override_of(const ConfigEntry& entry, const std::string& key, const std::string& toml) {
    const std::string plain = key.substr(key.find(':') == std::string::npos ? 0 : key.find(':') + 1);
    if (own_keys.contains(plain)) refuse(entry, "cannot be set here; the experiment's seeds and labs determine it");
    const std::string text = key + "=" + toml;
    plan_.places.emplace(text, entry.place);
    return text;
  }

  void read_set(const ConfigEntry& entry) {
    if (entry.path.size() < 2) return refuse_unless_empty(entry, "[set] must be a table of keys");
    plan_.labs.sets.push_back(override_of(entry, dotted(entry.path, 1), entry.value.toml));
  }

  void read_choice(const ConfigEntry& entry) {
    if (entry.path.size() < 3)
      return refuse_unless_empty(entry, "a choice is a table [choices.NAME.OPTION] of the keys that the option sets");
    if (fixed_columns.contains(entry.path[1]))
      refuse(entry, fmt::format("{} is already a column of the table; rename the choice", entry.path[1]));
    Factor& factor = factor_named(entry.path[1]);
    auto level = std::ranges::find(factor.levels, entry.path[2], &Factor::Level::label);
    if (level == factor.levels.end()) level = factor.levels.insert(level, {entry.path[2], {}});
    if (entry.is_table && entry.path.size() == 3) return;  // as it is
    const std::string key = dotted(entry.path, 3);
    if (key.empty()) refuse(entry, "must be a table of the keys that the option sets");
    claim(entry, key, entry.path[1]);
    level->sets.push_back(override_of(entry, key, entry.value.toml));
  }

  void read_sweep(const ConfigEntry& entry) {
    if (entry.path.size() < 2) return refuse_unless_empty(entry, "[sweep] must be a table of keys");
    const std::string key = dotted(entry.path, 1);
    claim(entry, key, key);
    Factor& factor = factor_named(key);
    std::set<std::string> seen;
    for (const ConfigEntry::Value& value : sweep_values(entry)) {
      if (!seen.insert(alike(value)).second) refuse(entry, fmt::format("{} is listed twice", value.text));
      factor.levels.push_back({value.text, {override_of(entry, key, value.toml)}});
    }
  }

  // The same for 2 and 2.0, which set the same.
  static std::string alike(const ConfigEntry::Value& value) {
    double number = 0;
    const char* const end = value.toml.data() + value.toml.size();
    const auto [at, error] = std::from_chars(value.toml.data(), end, number);
    return !value.is_text && error == std::errc() && at == end ? fmt::format("{}", number) : value.toml;
  }

  static std::vector<ConfigEntry::Value> sweep_values(const ConfigEntry& entry) {
    if (entry.is_list && !entry.elements.empty()) return entry.elements;
    if (!entry.value.is_text) refuse(entry, "must be a list of values, or a range \"FIRST..LAST step STEP\"");
    try {
      std::vector<ConfigEntry::Value> values;
      for (const std::string& value : range_values(entry.value.text)) values.push_back({value, value, false});
      return values;
    } catch (const std::invalid_argument& wrong) {
      refuse(entry, wrong.what());
    }
  }

  void read_plot(const ConfigEntry& entry) {
    if (entry.path.size() != 3) return refuse_unless_empty(entry, "a plot is a table [[plot]] with column and over");
    if (!plot_names.contains(entry.path[2]))
      refuse(entry, fmt::format("a plot has no such key; there are {}", fmt::join(plot_names, ", ")));
    if (!entry.value.is_text) refuse(entry, "must be a text in quotes");
    const std::size_t number = std::stoul(entry.path[1]);
    if (plan_.plots.size() <= number) plan_.plots.resize(number + 1);
    BatchPlot& plot = plan_.plots[number];
    const std::string& part = entry.path[2];
    (part == "column" ? plot.column
     : part == "over" ? plot.over
     : part == "by"   ? plot.by
     : part == "kind" ? plot.kind
                      : plot.looks[part]) = entry.value.text;
  }

  // Two axes of the grid must not set one key.
  void claim(const ConfigEntry& entry, const std::string& key, const std::string& factor) {
    const auto [owner, is_new] = owners_.emplace(key, factor);
    if (!is_new && owner->second != factor) refuse(entry, fmt::format("{} is already set by {}", key, owner->second));
  }

  Factor& factor_named(const std::string& name) {
    const auto found = std::ranges::find(plan_.factors, name, &Factor::name);
    return found != plan_.factors.end() ? *found : plan_.factors.emplace_back(Factor{name, {}});
  }

  static void refuse_unless_empty(const ConfigEntry& entry, std::string_view sentence) {
    if (!entry.is_table) refuse(entry, sentence);
  }

  fs::path folder_;
  BatchPlan& plan_;
  std::map<std::string, std::string> owners_;
};

void check_size(const fs::path& file, const BatchPlan& plan) {
  double runs = static_cast<double>(plan.seeds.size());
  for (const Factor& factor : plan.factors) runs *= static_cast<double>(factor.levels.size());
  if (runs > static_cast<double>(max_batch_runs))
    throw hal::ConfigError(fmt::format("{}: the grid has {:.0f} runs, and at most {} are possible; sweep fewer values",
                                       file.string(), runs, max_batch_runs));
}

// Which columns there are is known when runs have ended; the keys that they are drawn over are known now.
void check_plot(const fs::path& file, const BatchPlan& plan, const BatchPlot& plot) {
  if (plot.column.empty() || plot.over.empty())
    throw hal::ConfigError(fmt::format("{}: a [[plot]] needs column and over", file.string()));
  if (!plot.kind.empty() && plot.kind != "box" && plot.kind != "line")
    throw hal::ConfigError(fmt::format("{}: kind of a [[plot]] is \"box\" or \"line\"", file.string()));
  if (const auto width = plot.looks.find("width");
      width != plot.looks.end() && width->second != "column" && width->second != "page")
    throw hal::ConfigError(fmt::format("{}: width of a [[plot]] is \"column\" or \"page\"", file.string()));
  for (const std::string& key : {plot.over, plot.by})
    if (!key.empty() && std::ranges::find(plan.factors, key, &Factor::name) == plan.factors.end())
      throw hal::ConfigError(
          fmt::format("{}: a [[plot]] is drawn over {}, which is neither swept nor a choice", file.string(), key));
}

bool is_of_lab(const hal::ConfigEntries& file) {
  return std::ranges::any_of(file.entries, [](const ConfigEntry& entry) { return entry.path.front() == "lab"; });
}

}  // namespace

BatchFile read_batch_file(const std::vector<fs::path>& files, const std::string& seeds,
                          const std::vector<std::string>& sets) {
  const fs::path& file = files.front();
  hal::ConfigEntries entries = hal::read_entries(file);
  BatchFile out;
  // tables are always written; a message log only when somebody asks for it
  out.plan.labs.sets = {"recorder.log=false"};
  PlanReader reader(file, out.plan);
  if (files.size() > 1 || is_of_lab(entries)) {
    for (const fs::path& lab : files) {
      if (!is_of_lab(hal::read_entries(lab)))
        throw hal::ConfigError(fmt::format(
            "{}: has no [lab], so it is not a lab's file; give one experiment file, or the labs' files", lab.string()));
      out.plan.labs.files.push_back(lab.string());
    }
    if (seeds.empty()) throw hal::ConfigError("lab files contain no seeds; add --seeds 1..20");
  } else {
    out.experiment = file;
    out.files = std::move(entries.files);
    for (const ConfigEntry& entry : entries.entries) reader.read(entry);
  }
  if (!seeds.empty()) try {
      std::vector<std::string> parts;
      std::istringstream in(seeds);
      for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
      out.plan.seeds = seeds_of(parts);
    } catch (const std::invalid_argument& wrong) {
      throw hal::ConfigError(fmt::format("--seeds {:.60}: {}", seeds, wrong.what()));
    }
  if (out.plan.labs.files.empty())
    throw hal::ConfigError(
        fmt::format("{}: names no labs; write labs = [\"shark.toml\", \"roark.toml\"]", file.string()));
  if (out.plan.seeds.empty())
    throw hal::ConfigError(fmt::format("{}: names no seeds; write seeds = \"1..20\"", file.string()));
  for (const BatchPlot& plot : out.plan.plots) check_plot(file, out.plan, plot);
  for (const std::string& set : sets) reader.add(set);
  check_size(file, out.plan);
  return out;
}

}  // namespace arkmesh::app
