// Several labs in one process and one thread: each with its own buses, run id and gateway, joined by loopback links.
// Time-outs, repetition and lingering count steps of one millisecond, not wall time, so a run's course depends on its
// configuration alone.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/configured_lab.hpp"
#include "app/live/live_view.hpp"
#include "gateway/gateway.hpp"
#include "gateway/links/loopback.hpp"
#include "hal/bus/bus.hpp"
#include "hal/progress.hpp"
#include "hal/stop_request.hpp"
#include "hal/time/loop_time.hpp"

namespace arkmesh::app {

class JointRun {
 public:
  // What is done with a folder for the run that holds something: it is refused, or moved aside, or the caller has
  // looked after it, as a batch does for its many folders.
  enum class Folder : std::uint8_t { must_be_empty, moved_aside, of_batch };
  // Each lab records into `directory`/<lab>. Throws ConfigError when the configurations do not make one shared world,
  // or the directory is refused. `own`: by name, labs with parts of their own (ConfiguredLab). `page`: with a page for
  // browsers, unless the first lab's [view] wants none.
  JointRun(std::vector<hal::Config> labs, const std::filesystem::path& directory, Folder use = Folder::must_be_empty,
           const std::map<std::string, OwnParts*, std::less<>>& own = {}, bool page = false);
  ~JointRun();

  // One step of every lab and of the network between them, or a part of it: a lab whose arena computes its own time
  // and is not there yet goes on with the next call. Waits a moment when all that is left to do is to wait for arenas
  // that keep real time. False once all labs have ended.
  // Labs that wait for each other with no link down, and would for ever, are ended with that reason.
  bool step();

  std::size_t size() const { return labs_.size(); }
  ConfiguredLab& lab(std::size_t i) { return labs_[i]->lab; }
  const ConfiguredLab& lab(std::size_t i) const { return labs_[i]->lab; }
  // Throws std::out_of_range.
  ConfiguredLab& lab(const std::string& name);
  gateway::LoopbackNetwork& network() { return network_; }
  // Takes a lab's gateway away, as if its process were killed; start_gateway brings another one with a new boot id.
  void kill_gateway(const std::string& lab);
  void start_gateway(const std::string& lab);
  std::uint64_t steps() const { return steps_; }
  bool finished() const;
  // As Runner's, of all labs.
  bool robots_stand() const;
  std::string not_standing() const;  // in words
  // Null when there is none.
  const LiveView* page() const { return page_.get(); }
  // The labs' names as one: "roark+shark".
  std::string names() const;
  // Steps to the end, then writes each lab's result.json and, joined, hash.csv and result.json. Returns the joint
  // result. `progress` may be null.
  nlohmann::json run(hal::StopRequest& stop, hal::Progress* progress);

 private:
  struct Member {
    Member(hal::Config config, const std::filesystem::path& directory, hal::EventLoop& loop, OwnParts* own)
        : lab(std::move(config), directory, loop, own) {}
    ConfiguredLab lab;
    std::optional<ConfiguredLab::Membership> membership;
    std::unique_ptr<gateway::Gateway> gateway;
    bool went_on = false;          // in its last step
    bool awaits_scenario = false;  // which computes elsewhere, while other labs have their turn
  };
  Member& member(const std::string& name);
  void step(Member& m, std::chrono::microseconds now);
  bool settle_scenarios(std::chrono::microseconds now);
  static void exchange(Member& m, std::chrono::microseconds now);
  bool goes_last(const Member& m) const;
  void wait_for_arenas();
  bool viewers_wait();
  bool links_up() const;
  nlohmann::json save(double wall_s) const;

  std::filesystem::path directory_;
  hal::EventLoop loop_;  // serves the page
  hal::LoopTime time_{loop_};
  gateway::LoopbackNetwork network_;
  std::vector<std::unique_ptr<Member>> labs_;
  std::unique_ptr<LiveView> page_;
  hal::TimePoint served_{};  // when viewers were, last
  std::uint64_t steps_ = 0, idle_steps_ = 0, boots_ = 0;
  std::chrono::microseconds waited_{0};    // for arenas that keep real time
  hal::TimePoint wake_{};                  // when the first of these goes on, of the current step
  std::size_t turn_ = 0;                   // the lab with which the current step goes on
  bool advanced_ = false, going_ = false;  // any lab so far in the current step
};

}  // namespace arkmesh::app
