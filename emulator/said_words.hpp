// What an overhead controller said to the robots, from the bytes that a lab wrote to it: a record's serial line before
// the emulated controller, at the recorded times.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "emulator/ohc_serial_port.hpp"
#include "hal/platforms/kilobot/layout.hpp"
#include "testbed/raw_folder.hpp"

namespace arkmesh::emulator {

// Hears each infrared message in order, with its times since the record began.
using Listener = std::function<void(const sim_ode::Transmission&)>;

// `loses_power`: the controller is off while its port is closed, as an emulated one is; a real one has a supply of its
// own, and had started long before the record. Throws RecordError.
void replay_serial_line(testbed::SerialLines& lines, bool loses_power, const Listener& listener);

// "run", "to 5: kind 1 value 300, to 1000: kind 14 value 1023": what a message says, as far as its type tells. `layout`
// is that of words to single robots.
std::string in_words(const hal::kilobot::Message& message, const hal::kilobot::WordLayout& layout);

}  // namespace arkmesh::emulator
