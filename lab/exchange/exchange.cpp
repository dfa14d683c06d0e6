#include "lab/exchange/exchange.hpp"

#include <fmt/format.h>

#include <vector>

namespace arkmesh::lab {
namespace {

const std::vector<std::string> mode_names = {"time", "event", "mixed"};

std::uint32_t whole_periods(const hal::Section& gate, const char* key, hal::LabTime& of, hal::LabTime period) {
  if (of == hal::LabTime{0}) of = period;
  if (of % period != hal::LabTime{0})
    gate.refuse(key, fmt::format("must be a whole multiple of gate.period_s, which is {}",
                                 static_cast<double>(period.count()) * 1e-6));
  return static_cast<std::uint32_t>(of / period);
}

}  // namespace

void Exchange::fields(const hal::Section& gate) {
  gate.field("exchange", mode,
             {.help = "when a lab sends its robots and fields: \"time\": at fixed times; \"event\": when they change; "
                      "\"mixed\": the owner at fixed times, the others by event",
              .one_of = mode_names});
  gate.field("up_period_s", up,
             {.range = {0, 36000},
              .unit = "s",
              .help = "at fixed times: how often labs send to the owner; a whole multiple of gate.period_s",
              .default_is = "gate.period_s"});
  gate.field("down_period_s", down,
             {.range = {0, 36000},
              .unit = "s",
              .help = "at fixed times: how often the owner sends to the others; a whole multiple of gate.period_s",
              .default_is = "gate.period_s"});
}

void Exchange::check(const hal::Section& gate, hal::LabTime period) {
  up_periods = whole_periods(gate, "up_period_s", up, period);
  down_periods = whole_periods(gate, "down_period_s", down, period);
  if (mode != Mode::time && up_periods != 1)
    gate.refuse(
        "up_period_s",
        fmt::format("has no meaning with gate.exchange = \"{}\", where labs send to the owner by event; remove it",
                    name_of(mode)));
  if (mode == Mode::event && down_periods != 1)
    gate.refuse("down_period_s",
                "has no meaning with gate.exchange = \"event\", where the owner sends to the others by event; remove "
                "it, or use \"mixed\"");
}

std::string name_of(Exchange::Mode mode) {
  return mode_names.at(static_cast<std::size_t>(mode));
}

}  // namespace arkmesh::lab
