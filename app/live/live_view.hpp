// The page of labs that run in this process: passes what is on their private buses to browsers, and what browsers
// command to the labs. Whoever has shown the page's token counts as the labs' own operator. What they say to all labs
// goes to those of other processes, too, as far as these let this one's operator.
#pragma once

#include <list>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/configured_lab.hpp"
#include "hal/bus/bus.hpp"
#include "hal/child_process.hpp"
#include "hal/event_loop.hpp"
#include "hal/time/loop_time.hpp"
#include "lab/operator/operator_message.hpp"
#include "view/server.hpp"

namespace arkmesh::app {

class LiveView final : public view::Desk, public hal::Counting {
 public:
  // The first lab's [view] counts; null when it wants no page, or when no port is free, which is said in the log. Loop
  // and labs outlive the page. Throws ConfigError when the address needs a key that is not there.
  static std::unique_ptr<LiveView> make(hal::EventLoop& loop, const std::vector<ConfiguredLab*>& labs, std::string run);
  ~LiveView() override;

  // With the token of control, unless nobody may control.
  std::string url() const;
  // Gives viewers what has come last, within a third of a second: before the labs go.
  void finish(hal::LoopTime& time);
  // From now on they count among the first lab's, whose run is open.
  void count();
  hal::Counters counters() const override { return server_.counters(); }

  nlohmann::json about() override;
  void command(const nlohmann::json& what, view::Answer& answer) override;
  void request(const nlohmann::json& what, view::Answer& answer) override;
  // A row in the audit of the lab that was meant, else of the first one.
  void refused(const nlohmann::json& what, std::string_view why, const std::string& from) override;
  // Each lab's status as it is now, and its speed in wall time, for viewers alone: labs in one process say theirs each
  // second of a clock that counts steps, which takes long when steps do.
  void refresh() override;

 private:
  // What of a lab is watched.
  class Eye;
  LiveView(hal::EventLoop& loop, const view::ViewConfig& config, view::ServerOptions options,
           const std::vector<ConfiguredLab*>& labs, std::string run);
  void refuse(const nlohmann::json& what, std::string_view reason, std::string_view why, view::Answer& answer);
  std::string perform(const nlohmann::json& what, const lab::OperatorWord& word);
  void to_emulator(const nlohmann::json& what, view::Answer& answer);
  std::size_t lab_of(const nlohmann::json& what) const;
  bool is_elsewhere(const std::string& lab) const;
  void tell_others(std::string_view word);
  void hear_others();

  std::vector<ConfiguredLab*> labs_;
  std::string run_;
  bool control_;
  view::Server server_;
  std::vector<std::unique_ptr<Eye>> eyes_;
  // What labs of other processes are told: `arkmesh WORD --at LAB`, which signs it by the first lab's key.
  struct Told {
    explicit Told(hal::ChildStart start) : process(std::move(start)) {}
    hal::ChildProcess process;
    std::string said;
  };
  std::list<Told> told_;
  std::map<std::string, bool, std::less<>> obeys_;  // labs of other processes, as they say: this one's operator
  std::unique_ptr<hal::Bus::Subscription> statuses_;
};

}  // namespace arkmesh::app
