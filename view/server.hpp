// The page of a lab or of a recorded run, for browsers: HTTP and WebSocket on an event loop. It does not know what
// messages mean: it passes LCM messages on as they are, of each channel the newest, sampled, and the page decodes them.
// view/PROTOCOL.md has what goes over the wire. Who owns a server feeds it with show() and answers viewers with a
// Desk. Nothing here blocks, and no viewer can make it hold much: messages wait as the newest of their channel, answers
// and events up to a limit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/counters.hpp"
#include "hal/event_loop.hpp"
#include "view/answer.hpp"
#include "view/channels.hpp"

namespace arkmesh::view {

// Who answers viewers: a lab that runs, or a recorded run. Calls come from the loop, one at a time; what they throw
// goes to the viewer as a refusal.
class Desk {
 public:
  virtual ~Desk() = default;
  // {"mode": "live" or "recorded", "labs": [...], "control": bool, "run": "...", ...}: about.json, and the viewer's
  // hello. Asked each time; "version" is added.
  virtual nlohmann::json about() = 0;
  // A viewer that has shown the token wants something done: `what` is the object that it sent, with one of the members
  // "command", "fault", "move".
  virtual void command(const nlohmann::json& what, Answer& answer) = 0;
  // A viewer asks: `what` has "request": n beside "seek", "frames", "events" or "series". No token is needed.
  virtual void request(const nlohmann::json& what, Answer& answer) = 0;
  // The server refused a viewer at that address for want of the token: "wrong_token", with `what` null, or "no_token",
  // with the object that it sent. Who keeps books about commands wants to know; unbounded many may come.
  virtual void refused(const nlohmann::json& what, std::string_view why, const std::string& from) {
    (void)what, (void)why, (void)from;
  }
  // Twice a second while somebody watches, and when the first viewer comes: the time to show() what comes on no bus, or
  // too seldom.
  virtual void refresh() {}
};

struct ServerOptions {
  std::string address = "127.0.0.1";  // an IP address of this machine
  std::uint16_t port = 8800;          // 0: any free one
  std::uint16_t ports = 100;          // how many to try from there on
  std::vector<std::string> hosts;     // names by which browsers may reach it, beside the address itself and loopback's
  double per_s = 30;                  // samples of each channel in a second of wall time, at most
  std::size_t max_viewers = 32;       // further ones are told so; who has the token gets the place of one without
  std::string identity;  // PEM, a key and its certificate: https and wss only. Empty: the address is one of loopback
};

class Server {
 public:
  // Listens at once. Loop and desk outlive it. Throws std::runtime_error in one sentence: no port is free, or the
  // address is beyond loopback and there is no identity.
  Server(hal::EventLoop& loop, ServerOptions options, Desk& desk);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::uint16_t port() const;
  // "http://127.0.0.1:8800/", and the same with the token of control in its fragment.
  std::string url() const;
  std::string url_with_token() const;

  // The newest message of a channel of lab number `lab`, or a part of the newest frame; t_us as in Answer. Costs a copy
  // when nobody watches.
  void show(int lab, std::int64_t t_us, std::string_view channel, std::span<const std::byte> data, Part part = {});
  // The newest picture of a camera, as JPEG.
  void show_picture(int lab, std::int64_t t_us, std::string_view camera, std::span<const std::byte> jpeg);
  // How pictures lie in the arena: {"lab", "name", "width_px", "height_px", "arena_to_px"}. Viewers that come later get
  // it, too.
  void set_camera(int lab, nlohmann::json camera);
  // A line of a lab's event log; lab -1: of none alone. Never sampled; viewers that come later get the newest ones.
  void tell(int lab, std::int64_t t_us, std::string_view text);
  // How many watch now. Who makes pictures asks.
  std::size_t viewers() const;
  // What is new goes out now, not with the next sample: for who is about to end.
  void sample();
  // Something is on its way to a viewer, or waits for it.
  bool sending() const;
  // Everything refused, replaced, dropped and sent away, and why.
  hal::Counters counters() const;

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with the loop's next call, which looks whether it still lives
};

}  // namespace arkmesh::view
