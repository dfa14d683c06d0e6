// Runs an emulator in real time and offers it to the outside as hardware would be: cameras as motion JPEG over HTTP,
// the overhead controller as a pseudo-terminal and over TCP, or nodes over TCP, a control port for faults.
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "emulator/control_port.hpp"
#include "emulator/emulator.hpp"
#include "emulator/emulator_record.hpp"
#include "emulator/node_port.hpp"
#include "emulator/serial_reader.hpp"
#include "hal/event_loop.hpp"
#include "hal/http/mjpeg_server.hpp"

namespace arkmesh::emulator {

class EmulatorServer {
 public:
  // Opens all ports and works while `loop` runs; the emulator's time 0 is now. All three outlive the server. Throws
  // std::runtime_error with one sentence when a port is taken; the loop throws when a robot's program fails.
  EmulatorServer(hal::EventLoop& loop, Emulator& emulator, EmulatorRecord& record);

  const hal::MjpegServer& pictures() const { return pictures_; }
  // One of the two is 0: of robots with nodes there is no controller.
  std::uint16_t ohc_port() const { return reader_ ? reader_->port() : std::uint16_t{0}; }
  std::uint16_t nodes_port() const { return nodes_ ? nodes_->port() : std::uint16_t{0}; }
  std::uint16_t control_port() const { return control_.port(); }
  // Empty while the controller is unplugged.
  std::string terminal() const { return reader_ ? reader_->terminal() : ""; }
  std::string url(std::size_t camera) const;
  // Hears when the terminal has become another one, or none.
  void listen(std::function<void()> on_terminal) { on_terminal_ = std::move(on_terminal); }

  // The emulator's, the pictures' and the control port's counters, and `emulator.frames_skipped` for pictures that came
  // too late to be taken.
  hal::Counters counters() const;

 private:
  using TimePoint = std::chrono::steady_clock::time_point;
  hal::LabTime since_start(TimePoint moment) const { return std::chrono::duration_cast<hal::LabTime>(moment - start_); }
  void advance_to(TimePoint moment);
  void write_bytes();
  void follow_plug();
  void drop_chunks();
  void serve_nodes();
  void wait_for_frame();
  void take_pictures();
  void show_when_due();

  Emulator& emulator_;
  EmulatorRecord& record_;
  const TimePoint start_;
  hal::MjpegServer pictures_;
  std::deque<SerialReader::Chunk> chunks_;  // read, but not on the line yet
  std::optional<SerialReader> reader_;
  std::optional<NodePort> nodes_;
  ControlPort control_;
  struct LatePicture {
    std::string camera;
    std::vector<std::uint8_t> jpeg;
  };
  std::multimap<TimePoint, LatePicture> late_;  // by when they arrive
  boost::asio::steady_timer frame_due_, line_full_, picture_due_;
  bool plugged_ = true;
  int cuts_ = 0;  // of the line to nodes
  std::function<void()> on_terminal_ = [] {};
  std::int64_t frame_ = 0;  // the next one's number
  hal::Counters counters_;
};

}  // namespace arkmesh::emulator
