// A scenario in Python: a file of the user's that runs in a process of its own (arkmesh_child.py) and is asked frame by
// frame, boundary by boundary. An arena that can wait waits for each answer. One that keeps real time goes on: an
// answer that is late is taken with a later frame, and frames that come meanwhile are counted and not shown to it.
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "hal/arenas/arena.hpp"
#include "hal/config/config.hpp"
#include "lab/run_config.hpp"
#include "lab/scenario.hpp"
#include "scenarios/python/child.hpp"
#include "scenarios/python/kit_pieces.hpp"

namespace arkmesh::scenarios::python {

// The folder of the package `arkmesh`, which also holds the child's program; and that of the example of a scenario.
std::filesystem::path package_folder();
std::filesystem::path example_folder();
// Whether run.scenario names a file of Python.
inline bool is_python(const std::string& scenario) {
  return scenario.ends_with(".py");
}
// How long its answer is waited for: answer_s of [scenario].
std::chrono::microseconds answer_time(const hal::Section& scenarios);

// The settings that a file of Python asks for, as a lab of ten robots would be asked, for the table of keys. Throws
// ConfigError with what is wrong with the file.
std::vector<hal::KeyRow> settings_of(const std::filesystem::path& file);

class PythonScenario final : public lab::Scenario {
 public:
  // Starts the child and calls its begin(), which reads its settings in [scenario.NAME] of `root`, and those that labs
  // may have different in [sensors.NAME]; NAME is the file's name without .py. `lab_file`: beside which it is looked
  // up, the copy in a run's folder first. `words_per_s`: to robots, that the arena has airtime for; none: nobody says.
  // What is wrong with the user's file is thrown by begin(), so that the run ends as failed. Throws ConfigError for a
  // setting.
  PythonScenario(const hal::Section& root, const std::filesystem::path& lab_file, const lab::RunConfig& run,
                 const hal::ArenaInfo& arena, std::optional<double> words_per_s, std::filesystem::path directory);
  ~PythonScenario() override;

  void begin(lab::Lab& lab) override;
  void on_poses(lab::Lab& lab, const hal::PoseFrame& frame) override;
  // Told with the next frame.
  void on_heard(lab::Lab& lab, std::span<const hal::FromRobot> messages) override;
  void on_period(lab::Lab& lab) override;
  bool settled(lab::Lab& lab, std::chrono::milliseconds wait) override;
  bool finished(const lab::Lab&) const override { return finished_; }

  // What all labs must have alike beside the settings: a fingerprint of the sources.
  std::map<std::string, std::string, std::less<>> shared_settings() const;
  // For result.json: versions of Python and numpy, and the fingerprint.
  nlohmann::json facts() const;
  // What is wrong with the user's file; empty: nothing so far.
  const std::string& failure() const { return failure_; }
  // Keeps the sources in `directory`/scenario, where a run of that folder finds them.
  void keep_sources() const;

 private:
  void start(const hal::Section& root, const lab::RunConfig& run, const hal::ArenaInfo& arena,
             std::optional<double> words_per_s);
  // The next message, which is an answer; none when it is late and the arena does not wait. Throws when the child has
  // failed, or is silent for too long.
  std::optional<std::string> next_answer(std::chrono::milliseconds wait);
  void take(lab::Lab& lab, const std::string& answer);
  void add_piece(lab::Lab& lab, const nlohmann::ordered_json& asked);
  void take_words(lab::Lab& lab, std::string_view words);
  void ask(lab::Lab& lab, char kind, const std::string& content);
  void collect(lab::Lab& lab, std::chrono::milliseconds wait);
  [[noreturn]] void fail_silent();
  void write_output();

  std::filesystem::path file_, directory_;
  bool can_wait_;
  std::chrono::microseconds patience_;
  std::unique_ptr<Child> child_;
  std::string failure_;  // of the start, for begin()
  std::string begun_;    // the child's answer to begin()
  nlohmann::json about_ = nlohmann::json::object();
  std::uint32_t every_ = 1;
  std::vector<std::string> initial_only_;  // fields that state 0 alone holds
  std::ofstream log_;
  std::string output_;  // before there is a folder for it
  KitPieces kit_;
  std::map<hal::RobotId, hal::Led> leds_;  // as seen last; words of robots that were never seen wait
  std::vector<hal::FromRobot> heard_;      // and not told yet
  bool finished_ = false;
  int open_answers_ = 0;  // that the child still owes
};

}  // namespace arkmesh::scenarios::python
