// Whole labs without arenas: each lab's state is a number that depends on all it has merged, so equal final numbers
// mean equal merge sequences. The network between them loses, repeats and reorders as a random stream says.
#pragma once

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/random.hpp"
#include "lab/exchange/payload.hpp"
#include "lab/exchange/period_gate.hpp"

namespace arkmesh::tests {

struct GateModelOptions {
  int labs = 2;
  std::uint32_t slack = 0;
  std::uint32_t periods = 20;
  std::uint32_t window = 0;         // 0: as the gate has it
  std::uint64_t world_seed = 1;     // what the labs do
  std::uint64_t schedule_seed = 1;  // what the network does
  double loss = 0.5;
  std::int64_t moved_site = 0;  // a lab's own choice that changes its behaviour
  bool leftovers = true;        // messages of an earlier run are under way at the start
  lab::Exchange exchange = {};  // lab0 is the owner
  bool seldom = false;          // a lab's number is another one at every third boundary or so, not at each
};

class GateModel {
 public:
  explicit GateModel(GateModelOptions options) : options_(options), chance_(options.schedule_seed, "schedule") {
    std::vector<std::string> names;
    for (int i = 0; i < options_.labs; ++i) names.push_back(fmt::format("lab{}", i));
    for (int i = 0; i < options_.labs; ++i) {
      labs_.push_back(std::make_unique<Lab>(lab::PeriodGate({.lab = names[static_cast<std::size_t>(i)],
                                                             .labs = names,
                                                             .slack = options_.slack,
                                                             .last_period = options_.periods,
                                                             .run_id = 100u + static_cast<unsigned>(i),
                                                             .window = options_.window,
                                                             .exchange = options_.exchange,
                                                             .until_confirmed = holds(i)}),
                                            lab::OwnPayload(options_.exchange, i == 0),
                                            hal::mix64(options_.world_seed + static_cast<unsigned>(i))));
      publish(*labs_.back());
    }
    if (options_.leftovers)
      for (auto& lab : labs_) {
        lab::WorldMessage old = lab->gate.message();
        old.run_id += 1000;
        for (auto& [peer, ack] : old.acks) ack = {7, static_cast<std::int64_t>(options_.periods)};
        old.window.back().period = options_.periods;
        send(old);
      }
  }

  // Runs until all labs have merged the last period, or nothing has progressed for a long time (a deadlock). True when
  // done.
  bool run() {
    const int patience = 3000;
    for (int idle = 0; idle < patience; ++idle) {
      Lab& lab = *labs_[chance_.below(labs_.size())];
      if (chance_.uniform() < 0.4) {
        if (advance(lab)) idle = 0;
      } else if (chance_.uniform() < 0.4) {
        send(lab.gate.message());
      } else {
        deliver_one();
      }
      if (done()) return true;
    }
    return false;
  }

  bool done() const {
    for (const auto& lab : labs_)
      if (lab->merged != static_cast<std::int64_t>(options_.periods)) return false;
    return true;
  }
  std::uint64_t result() const {
    std::uint64_t all = 0;
    for (const auto& lab : labs_) all = hal::mix64(all ^ lab->value);
    return all;
  }
  const lab::PeriodGate& gate(std::size_t i) const { return labs_[i]->gate; }
  lab::PeriodGate& gate(std::size_t i) { return labs_[i]->gate; }
  bool restarted_heard() const { return restarted_; }

  // States with robots and fields, of all that were sent.
  std::uint64_t payloads() const { return payloads_; }

 private:
  struct Lab {
    Lab(lab::PeriodGate g, lab::OwnPayload p, std::uint64_t v)
        : gate(std::move(g)), payload(std::move(p)), value(v), number(v) {}
    lab::PeriodGate gate;
    lab::OwnPayload payload;
    std::uint64_t value, number;
    std::vector<std::int64_t> applied;  // as the owner tells it
    std::int64_t merged = -1;
  };

  void publish(Lab& lab) {
    lab::LabState own;
    own.period = static_cast<std::uint32_t>(lab.gate.published() + 1);
    own.hash = lab.value;
    if (!options_.seldom || lab.value % 3 == 0) lab.number = lab.value;
    own.fields["number"] = {static_cast<std::int64_t>(lab.number >> 1)};
    if (is_owner_that_shows(lab)) own.fields["lab.applied"] = lab.applied;
    if (own.period == 0) own.settings["gate.slack"] = fmt::format("{}", options_.slack);
    lab.payload.settle(own, rules());
    lab.gate.publish(std::move(own));
    send(lab.gate.message());
  }
  bool is_mixed() const { return options_.exchange.mode == lab::Exchange::Mode::mixed; }
  bool holds(int i) const { return is_mixed() && i > 0; }
  bool is_owner_that_shows(const Lab& lab) const {
    return is_mixed() && &lab == labs_.front().get() && !lab.applied.empty();
  }
  std::vector<lab::FieldRule> rules() const {
    return {{.name = "number", .length = 1}, lab::applied_rule(static_cast<std::size_t>(options_.labs))};
  }
  // What the owner's snapshot shows of this lab, and what the owner will show.
  void confirm(Lab& lab, const std::vector<lab::MergedState>& merged) {
    lab.applied.clear();
    for (std::size_t i = 0; i < merged.size(); ++i) {
      lab.applied.push_back(lab::payload_period(*merged[i].state));
      if (labs_[i].get() != &lab || i == 0) continue;
      const auto shown = merged[0].state->fields.find("lab.applied");
      if (shown != merged[0].state->fields.end()) lab.gate.confirm(shown->second.at(i));
    }
  }
  bool advance(Lab& lab) {
    const auto k = static_cast<std::uint32_t>(lab.gate.published());
    if (lab.merged == static_cast<std::int64_t>(k) || !lab.gate.may_merge(k)) return false;
    const std::vector<lab::MergedState> merged = lab.gate.merge(k);
    if (is_mixed()) confirm(lab, merged);
    for (const lab::MergedState& each : merged)
      lab.value = hal::mix64(lab.value ^ static_cast<std::uint64_t>(each.state->fields.at("number").at(0)) ^
                             each.state->period);
    if (k == 5) lab.value += static_cast<std::uint64_t>(options_.moved_site);
    lab.merged = k;
    if (k < options_.periods) publish(lab);
    return true;
  }
  // As it arrives: what the wire cannot hold is lost here.
  lab::WorldMessage over_the_wire(const lab::WorldMessage& message) const {
    if (options_.exchange.plain()) return message;
    const world_t out = lab::to_message(message);
    std::vector<std::byte> bytes(static_cast<std::size_t>(out.getEncodedSize()));
    out.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    lab::WorldMessage arrived;
    REQUIRE(lab::decode_world(bytes, arrived) == "");
    return arrived;
  }
  void send(const lab::WorldMessage& sent) {
    const lab::WorldMessage message = over_the_wire(sent);
    for (const lab::LabState& state : message.window) payloads_ += state.carried ? 1 : 0;
    for (auto& lab : labs_) {
      if (message.lab == lab->gate.message().lab || chance_.uniform() < options_.loss) continue;
      under_way_.push_back({lab.get(), message});
      if (chance_.uniform() < 0.2) under_way_.push_back({lab.get(), message});
    }
  }
  void deliver_one() {
    if (under_way_.empty()) return;
    const std::size_t i = chance_.below(under_way_.size());  // any of them: reordered at will
    const auto [lab, message] = under_way_[i];
    under_way_.erase(under_way_.begin() + static_cast<std::ptrdiff_t>(i));
    restarted_ = restarted_ || lab->gate.hear(message.lab, message) == lab::PeriodGate::Heard::restarted;
    if (under_way_.size() > 40) under_way_.erase(under_way_.begin());
  }

  struct UnderWay {
    Lab* lab;
    lab::WorldMessage message;
  };
  GateModelOptions options_;
  hal::RandomStream chance_;
  std::vector<std::unique_ptr<Lab>> labs_;
  std::vector<UnderWay> under_way_;
  bool restarted_ = false;
  std::uint64_t payloads_ = 0;
};

}  // namespace arkmesh::tests
