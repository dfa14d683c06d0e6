// What a lab that runs and its gateway say of themselves and their links on the lab's bus, for people and scripts.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "hal/bus/bus.hpp"
#include "hal/bus/bus_config.hpp"
#include "hal/stop_request.hpp"

namespace arkmesh::lab {

class StatusListener {
 public:
  explicit StatusListener(const hal::BusConfig& config);

  // Until both have spoken, the gateway twice, or had the time to. Throws std::runtime_error when nobody spoke, unless
  // it was stopped.
  void listen_first(hal::StopRequest& stop);
  void listen(std::chrono::milliseconds time, hal::StopRequest& stop);
  // What was heard last, with its age: {bus, lab, gateway}, null where nobody has spoken. Names and texts are
  // printable.
  nlohmann::json json() const;

 private:
  // A message and the one before it, of which rates are made.
  template <class Message>
  struct Heard {
    std::optional<Message> newest, before;
    std::chrono::steady_clock::time_point newest_at, before_at;

    void hear(Message message) {
      before = std::exchange(newest, std::move(message));
      before_at = std::exchange(newest_at, std::chrono::steady_clock::now());
    }
    double age_s() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - newest_at).count(); }
    double between_s() const { return std::chrono::duration<double>(newest_at - before_at).count(); }
  };
  nlohmann::json lab_json() const;
  nlohmann::json gateway_json() const;
  nlohmann::json peer_json(const peer_t& peer) const;
  nlohmann::json rate(const peer_t& peer, std::string_view counter) const;

  std::string url_;
  Heard<lab_status_t> lab_;
  Heard<peers_t> gateway_;
  hal::Bus bus_;
  std::map<std::string, std::string, std::less<>> settings_;  // fingerprints of peers that were heard
  std::unique_ptr<hal::Bus::Subscription> statuses_, links_, peers_;
};

}  // namespace arkmesh::lab
