// Runs an emulator in real time and offers it to the outside as hardware would be: cameras as motion JPEG over HTTP,
// the overhead controller as a pseudo-terminal and over TCP, a control port for faults.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <string>

#include "emulator/emulator.hpp"
#include "emulator/emulator_record.hpp"
#include "emulator/serial_reader.hpp"
#include "hal/mjpeg_server.hpp"

namespace arkmesh::emulator {

class EmulatorServer {
 public:
  // Opens all ports. Both outlive the server. Throws std::runtime_error with one sentence when a port is taken.
  EmulatorServer(Emulator& emulator, EmulatorRecord& record);

  const hal::MjpegServer& pictures() const { return pictures_; }
  std::uint16_t ohc_port() const { return reader_.port(); }
  std::uint16_t control_port() const { return control_.port(); }
  std::string terminal() const { return reader_.terminal(); }
  std::string url(std::size_t camera) const;

  // Does what is due by now and returns the moment at which to call it again. The first call sets when the emulator's
  // time 0 was: now.
  std::chrono::steady_clock::time_point step();
  // The emulator's and the pictures' counters, and `emulator.frames_skipped` for pictures that came too late to be
  // taken.
  hal::Counters counters() const;

 private:
  using TimePoint = std::chrono::steady_clock::time_point;
  hal::LabTime since_start(TimePoint moment) const { return std::chrono::duration_cast<hal::LabTime>(moment - start_); }
  void take_bytes();
  void take_pictures();

  Emulator& emulator_;
  EmulatorRecord& record_;
  hal::MjpegServer pictures_;
  SerialReader reader_;
  LinePort control_;
  bool started_ = false, plugged_ = true;
  TimePoint start_{}, known_until_{};
  std::deque<SerialReader::Chunk> chunks_;
  std::int64_t frame_ = 0;  // the next one's number
  hal::Counters counters_;
};

}  // namespace arkmesh::emulator
