#include "scenarios/python/python_scenario.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <stdlib.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "hal/files/own_files.hpp"
#include "hal/files/replace_file.hpp"
#include "scenarios/python/encoding.hpp"
#include "scenarios/python/said.hpp"

namespace arkmesh::scenarios::python {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
constexpr std::size_t most_heard = 1 << 20;  // messages of robots that wait for a scenario that is slow
constexpr auto real_time_wait = 10ms;        // within the 20 ms that a call may take on hardware

// What numpy, BLAS and glibc would choose by the CPU, and Python by chance, is fixed, so that results depend on the
// configuration alone. Names: numpy's "CPU dispatcher", OpenBLAS's and glibc's manuals.
const std::vector<std::string> fixed_environment = {
    "PYTHONHASHSEED=0",
    "PYTHONSAFEPATH=",  // else what lies beside arkmesh_child.py is not found
    "PYTHONUNBUFFERED=1",
    "PYTHONWARNINGS=ignore:During parsing environment variable:RuntimeWarning",  // numpy's, of features that are absent
    "OMP_NUM_THREADS=1",
    "OPENBLAS_NUM_THREADS=1",
    "MKL_NUM_THREADS=1",
    "OPENBLAS_CORETYPE=Nehalem",
    "MKL_CBWR=COMPATIBLE",
    "NPY_DISABLE_CPU_FEATURES=AVX2 FMA3 AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL",
    "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F"};

// A sentence that names the user's line.
struct Refused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

fs::path find_file(const fs::path& lab_file, const std::string& scenario) {
  const fs::path folder = fs::absolute(lab_file).parent_path(),
                 kept = folder / "scenario" / fs::path(scenario).filename();
  std::error_code ignored;
  return fs::exists(kept, ignored) ? kept : (folder / scenario).lexically_normal();
}

}  // namespace

fs::path package_folder() {
  return hal::own_file("python", "scenarios/python");
}

fs::path example_folder() {
  return hal::own_file("experiments/light_up", "experiments/light_up");
}

std::chrono::microseconds answer_time(const hal::Section& scenarios) {
  return scenarios.get("answer_s", std::chrono::microseconds(10'000'000),
                       {.range = {0.1, 3600},
                        .unit = "s",
                        .help = "time limit for each answer of a Python scenario, without waits for a processor"});
}

std::vector<hal::KeyRow> settings_of(const fs::path& file) {
  constexpr hal::RobotId robots = 10;
  lab::RunConfig run;
  run.lab = run.owner = "lab";
  run.labs = {run.lab};
  run.scenario = file.filename().string();
  run.projections[run.lab] = {};
  hal::ArenaInfo arena;
  for (hal::RobotId id = 0; id < robots; ++id) arena.robots.push_back(id);
  std::string failure;
  std::vector<hal::KeyRow> rows = hal::list_keys("", [&](const hal::Section& root) {
    failure = PythonScenario(root, fs::absolute(file), run, arena, {}, {}).failure();
  });
  if (!failure.empty()) throw hal::ConfigError(failure);
  // a key that is asked for by itself is listed twice
  std::set<std::pair<std::string, std::string>> seen;
  std::erase_if(rows, [&](const hal::KeyRow& row) {
    return row.table == "scenario" || !seen.emplace(row.table, row.key).second;
  });
  return rows;
}

PythonScenario::PythonScenario(const hal::Section& root, const fs::path& lab_file, const lab::RunConfig& run,
                               const hal::ArenaInfo& arena, std::optional<double> words_per_s, fs::path directory)
    : file_(find_file(lab_file, run.scenario)),
      directory_(std::move(directory)),
      can_wait_(arena.can_wait),
      patience_(answer_time(root.section("scenario"))) {
  try {
    start(root, run, arena, words_per_s);
  } catch (const hal::ConfigError&) {
    throw;
  } catch (const std::exception& error) {
    failure_ = error.what();
  }
}

PythonScenario::~PythonScenario() {
  write_output();
  if (const std::uint64_t bytes = child_ ? child_->dropped_output() : 0; bytes > 0)
    spdlog::warn("scenario.log lacks the last {} bytes that {} printed", bytes, file_.filename().string());
}

void PythonScenario::start(const hal::Section& root, const lab::RunConfig& run, const hal::ArenaInfo& arena,
                           std::optional<double> words_per_s) {
  const std::string table = file_.stem().string();
  std::error_code ignored;
  if (const fs::path child = package_folder() / "arkmesh_child.py"; !fs::exists(child, ignored))
    throw hal::ConfigError(
        fmt::format("{} is a Python scenario, which needs the package python3-arkmesh", file_.filename().string()));
  const char* const named = ::getenv("ARKMESH_PYTHON");
  child_ = std::make_unique<Child>(
      std::vector<std::string>{named ? named : "python3", "-B", (package_folder() / "arkmesh_child.py").string()},
      fixed_environment);
  nlohmann::json obstacles = nlohmann::json::array(), objects = nlohmann::json::array();
  for (const hal::Obstacle& each : arena.obstacles) obstacles.push_back(solid(each.shape, each.pose, ""));
  std::vector<std::string> colours;
  for (const hal::ColourLook& look : hal::colour_looks) colours.emplace_back(look.name);
  for (const hal::MovableObject& each : arena.objects) objects.push_back(solid(each.shape, each.start, each.name));
  nlohmann::json facts = {{"file", file_.string()},
                          {"name", run.lab},
                          {"labs", run.labs},
                          {"owner", run.owner},
                          {"seed", run.seed},
                          {"period_s", static_cast<double>(run.period.count()) * 1e-6},
                          {"frame_s", static_cast<double>(arena.frame_period.count()) * 1e-6},
                          {"width_m", arena.width_m},
                          {"height_m", arena.height_m},
                          {"scale", run.projections.at(run.lab).scale},
                          {"kinds", arena.kinds},
                          {"values", arena.values},
                          {"make", arena.make},
                          {"says", arena.says},
                          {"wheels_m_per_s", arena.can_be_driven() ? arena.drive.speed_m_s : 0},
                          {"whole_to_one", arena.whole == hal::WholeMessages::to_each},
                          {"obstacles", obstacles},
                          {"objects", objects},
                          {"colours", colours},
                          {"robots", arena.robots}};
  if (words_per_s) facts["words_per_s"] = *words_per_s;
  child_->send('S', facts.dump());
  open_answers_ = 1;
  child_->begin_to_wait();
  for (;;) {
    std::optional<Message> message;
    try {
      // a signal that the lab acts on later ends the wait
      for (std::chrono::nanoseconds left = patience_ - child_->waited(); !message && left.count() > 0;
           left = patience_ - child_->waited())
        message = child_->receive(std::chrono::ceil<std::chrono::milliseconds>(left));
    } catch (const std::exception& error) {
      // Python itself, which could not begin
      output_ += child_->take_output();
      std::istringstream said(output_);
      for (std::string line; std::getline(said, line);) spdlog::error("{}: {}", file_.filename().string(), line);
      throw std::runtime_error(fmt::format("{} {}", file_.filename().string(), error.what()));
    }
    if (!message) fail_silent();
    if (message->kind == 'E') throw std::runtime_error(message->content);
    if (message->kind == 'A') {
      begun_ = std::move(message->content);
      break;
    }
    const nlohmann::json asked = nlohmann::json::parse(message->content);
    const hal::Section settings = root.section(asked.at("own").get<bool>() ? "sensors" : "scenario").section(table);
    child_->send('V', setting_in_force(settings, asked).dump());
  }
  open_answers_ = 0;
  about_ = nlohmann::json::parse(rest_of(begun_)).at("about");
  every_ = about_.at("every");
}

void PythonScenario::begin(lab::Lab& lab) {
  log_.open(directory_ / "scenario.log");
  write_output();
  if (!failure_.empty()) throw std::runtime_error(failure_);
  if (lab.is_owner())  // once for all labs
    for (const auto& sentence : about_.value("unseeded", nlohmann::json::array()))
      spdlog::warn("{}", sentence.get<std::string>());
  take(lab, begun_);
}

void PythonScenario::on_poses(lab::Lab& lab, const hal::PoseFrame& frame) {
  for (const hal::Observation& seen : frame.robots) leds_[seen.robot] = seen.led;
  if (every_ == 0 || frame.number % every_ != 0) return;
  collect(lab, real_time_wait);
  if (open_answers_ > 0) {
    lab.counts().add("scenario.frames_skipped");
    return;
  }
  ask(lab, 'F', encode_frame(lab, frame, std::exchange(heard_, {})) + kit_.sense(lab, frame));
}

void PythonScenario::on_heard(lab::Lab& lab, std::span<const hal::FromRobot> messages) {
  if (every_ == 0) return;
  const std::size_t fit = std::min(messages.size(), most_heard - heard_.size());
  heard_.insert(heard_.end(), messages.begin(), messages.begin() + static_cast<std::ptrdiff_t>(fit));
  if (fit < messages.size()) lab.counts().add("scenario.heard_skipped", messages.size() - fit);
}

void PythonScenario::on_period(lab::Lab& lab) {
  collect(lab, real_time_wait);
  kit_.on_period(lab);
  ask(lab, 'P', encode_period(lab, initial_only_) + kit_.world());
}

// Where the arena keeps real time, takes the answer if it comes soon.
void PythonScenario::ask(lab::Lab& lab, char kind, const std::string& content) {
  if (open_answers_++ == 0) child_->begin_to_wait();
  child_->send(kind, content);
  if (!can_wait_) collect(lab, real_time_wait);
}

bool PythonScenario::settled(lab::Lab& lab, std::chrono::milliseconds wait) {
  if (can_wait_) collect(lab, wait);
  return !can_wait_ || open_answers_ == 0;
}

// Takes the answers that are there, or come in time.
void PythonScenario::collect(lab::Lab& lab, std::chrono::milliseconds wait) {
  while (open_answers_ > 0) {
    const auto answer = next_answer(wait);
    if (!answer) return;
    --open_answers_;
    if (can_wait_) child_->has_answered();
    child_->begin_to_wait();
    take(lab, *answer);
  }
}

std::optional<std::string> PythonScenario::next_answer(std::chrono::milliseconds wait) {
  std::optional<Message> message;
  try {
    message = child_->receive(wait);
  } catch (const std::exception& error) {
    write_output();
    throw std::runtime_error(fmt::format("{} {}", file_.filename().string(), error.what()));
  }
  write_output();
  if (!message && child_->has_waited(patience_)) fail_silent();
  if (!message) return std::nullopt;
  if (message->kind == 'E') throw std::runtime_error(message->content);
  return std::move(message->content);
}

// Where it hangs stands in what it prints then, innermost first.
void PythonScenario::fail_silent() {
  child_->ask_where();
  child_->begin_to_wait();
  std::string printed;
  while (child_->waited() < 500ms && printed.find(" in ") == std::string::npos) {
    bool is_there = true;  // a notebook that gives up closes its line before the word from it has come
    try {
      child_->receive(50ms);
    } catch (const std::exception&) {
      is_there = false;
    }
    printed += child_->take_output();
    if (!is_there) break;
  }
  output_ += printed;
  write_output();
  const auto word_behind = [&](const std::string& before) {
    const std::size_t at = printed.find(before);
    return at == std::string::npos
               ? std::string()
               : printed.substr(at + before.size(),
                                printed.find_first_of(" ,\n", at + before.size()) - at - before.size());
  };
  std::string where = word_behind("hangs at ");  // of a notebook's process
  if (where.empty()) {
    where = file_.filename().string();
    if (const std::string line = word_behind(fmt::format("File \"{}\", line ", file_.string())); !line.empty())
      where += ":" + line;
  }
  throw std::runtime_error(
      fmt::format("{}: no answer for {} s (scenario.answer_s)", where, static_cast<double>(patience_.count()) * 1e-6));
}

void PythonScenario::take(lab::Lab& lab, const std::string& answer) {
  try {
    take_words(lab, words_of(answer));
    const std::string_view rest = rest_of(answer);
    if (rest.empty()) return;
    const Said said = Said::parse(rest);
    for (const auto& rule : said.value("declare", Said::array())) {
      if (rule.at("initial_only")) initial_only_.push_back(rule.at("name"));
      lab.declare({.name = rule.at("name"),
                   .length = rule.at("length"),
                   .low = rule.at("low"),
                   .high = rule.at("high"),
                   .owner_only = rule.at("owner_only"),
                   .initial_only = rule.at("initial_only"),
                   .up_to = rule.at("up_to")});
    }
    for (const auto& given : said.value("parameters", Said::array()))
      lab.parameters({given.at("type"), given.at("data")});
    for (const auto& given : said.value("whole", Said::array()))
      for (const hal::ToRobot& message : whole_messages(given)) lab.say(message);
    for (const auto& asked : said.value("kit", Said::array())) add_piece(lab, asked);
    if (said.contains("kit_acts")) {
      for (const auto& done : said.at("kit_acts")) kit_.act(lab, done);
      kit_.end_frame(lab);
    }
    const Said published = said.value("publish", Said::object());
    for (const auto& [name, values] : published.items()) lab.publish(name, values.get<std::vector<std::int64_t>>());
    for (const auto& row : said.value("rows", Said::array()))
      lab.row(row.at(0).get<std::string>(), row.at(1).get<std::string>(), row.at(2).get<std::string>());
    for (const auto& count : said.value("counts", Said::array()))
      lab.counts().add(count.at(0).get<std::string>(), count.at(1).get<std::uint64_t>());
    for (const auto& shape : said.value("draw", Said::array())) draw(lab, shape);
    for (const auto& about : said.value("shown", Said::array()))
      lab.show({about.at("of"), about.at("words"), about.at("unit"), about.at("curve")});
    finished_ = finished_ || said.value("finished", false);
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(fmt::format("{} returned an invalid answer: {}", file_.filename().string(), error.what()));
  } catch (const Refused& error) {
    throw std::runtime_error(error.what());
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}", file_.filename().string(), error.what()));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{} {}", file_.filename().string(), error.what()));
  }
}

void PythonScenario::add_piece(lab::Lab& lab, const Said& asked) {
  try {
    kit_.add(lab, asked);
  } catch (const std::invalid_argument& error) {
    throw Refused(fmt::format("{}: {}", asked.at("where").get<std::string>(), error.what()));
  }
}

void PythonScenario::take_words(lab::Lab& lab, std::string_view words) {
  for (std::size_t at = 0; at < words.size(); at += word_bytes) {
    const Word word = decode_word(words.substr(at));
    const auto led = leds_.find(word.message.robot);
    if (word.how == Word::once)
      lab.say(word.message);
    else if (word.how == Word::until_led_changes)
      lab.tell(word.message, led == leds_.end() ? hal::Led::off : led->second);
    else
      lab.tell(word.message, word.how == Word::shown && (led == leds_.end() || led->second != hal::Led::unknown));
  }
}

// What it prints, with the traceback of what it raised.
void PythonScenario::write_output() {
  if (child_) output_ += child_->take_output();
  if (!log_.is_open() || output_.empty()) return;
  const std::string lines = std::exchange(output_, {});
  if (log_ && !(log_ << lines << std::flush))
    spdlog::warn("cannot write more to {}, perhaps because the disk is full; the run continues without it",
                 (directory_ / "scenario.log").string());
}

std::map<std::string, std::string, std::less<>> PythonScenario::shared_settings() const {
  const std::string table = fmt::format("scenario.{}.", file_.stem().string());
  std::map<std::string, std::string, std::less<>> all{{table + "sources", about_.value("fingerprint", "")}};
  const nlohmann::json alike = about_.value("alike", nlohmann::json::object());
  for (const auto& [piece, settings] : alike.items()) all.emplace(table + piece, settings.get<std::string>());
  return all;
}

nlohmann::json PythonScenario::facts() const {
  return {{"python", about_.value("python", "")},
          {"numpy", about_.value("numpy", "")},
          {"sources", about_.value("fingerprint", "")},
          {"unseeded", about_.value("unseeded", nlohmann::json::array())}};
}

void PythonScenario::keep_sources() const {
  const auto keep = [this](const std::string& name, std::string_view bytes) {
    const fs::path copy = directory_ / "scenario" / name;
    fs::create_directories(copy.parent_path());
    hal::must_replace_file(copy, bytes);
  };
  const nlohmann::json none = nlohmann::json::object(), sources = about_.value("sources", none),
                       files = about_.value("files", none);
  for (const auto& [name, text] : sources.items()) keep(name, text.get<std::string>());
  for (const auto& [name, digits] : files.items()) {
    const std::vector<std::uint8_t> bytes = bytes_in(digits.get_ref<const std::string&>());
    keep(name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
}

}  // namespace arkmesh::scenarios::python
