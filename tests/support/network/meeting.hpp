// Labs of a test that meet at a hostile server, all in one loop, and a member that keeps to no protocol.
#pragma once

#include <doctest/doctest.h>

#include <boost/asio/io_context.hpp>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gateway/federation/packet.hpp"
#include "gateway/federation/relay.hpp"
#include "gateway/federation/seals.hpp"
#include "gateway/links/connections.hpp"
#include "tests/support/network/accounts.hpp"
#include "tests/support/network/hostile_nats.hpp"
#include "tests/support/network/tcp_bench.hpp"
#include "tests/support/network/test_keys.hpp"

namespace arkmesh::tests {

// One lab's gateway.
struct MeetingLab {
  std::string name;
  std::vector<std::string> notices;
  std::map<std::string, std::vector<std::string>> heard;  // on `events`, by peer
  std::unique_ptr<gateway::Connections> node;
  std::map<std::string, std::unique_ptr<gateway::Link>> links;  // by peer

  bool up(const std::string& peer) const { return links.at(peer)->stats().up; }
  std::uint64_t count(const std::string& peer, const std::string& counter) const {
    return links.at(peer)->stats().counters[counter];
  }
  // federation.refused.* and the like.
  std::uint64_t count(const std::string& counter) const { return node->counters()[counter]; }
  // To all peers, as a gateway does.
  void say(std::string_view text, const std::string& channel = "events") {
    node->corked([&] {
      for (const auto& [peer, link] : links)
        link->offer({channel, gateway::Delivery::ordered}, channel, std::as_bytes(std::span(text)));
    });
  }
};

struct Meeting {
  struct Habits {
    bool encrypt = false;
    std::string experiment = "dhtf", connect;  // connect: where the hostile server is not
  };

  boost::asio::io_context io;
  HostileNats server;
  TestKeys keys;
  std::map<std::string, MeetingLab> labs;
  std::uint64_t boots = 100;

  explicit Meeting(std::size_t max_payload = 1 << 20) : server(io, max_payload) {}
  MeetingLab& start(const std::string& name, const std::vector<std::string>& peers, const Habits& habits) {
    for (const std::string& peer : peers)
      if (!trusts(name, peer)) keys.trust(name, peer);
    MeetingLab& lab = labs[name];
    lab.links.clear();  // before their node
    lab = {};
    lab.name = name;
    gateway::TcpSettings settings = tcp_settings(name, ++boots);
    settings.times = {};
    settings.experiment = habits.experiment;
    settings.keys = keys.tls(name);
    settings.federation.encrypt = habits.encrypt;
    settings.notice = [&lab](const std::string& sentence) { lab.notices.push_back(sentence); };
    lab.node = std::make_unique<gateway::Connections>(io, std::move(settings));
    for (const std::string& peer : peers) {
      auto& link = lab.links[peer];
      link = lab.node->federation_link(peer, habits.connect.empty() ? server.address() : habits.connect, false);
      link->start({.arrived =
                       [&heard = lab.heard[peer]](std::string_view, auto bytes) {
                         heard.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                       },
                   .changed = [](bool, std::string_view) {}});
    }
    return lab;
  }
  MeetingLab& start(const std::string& name, const std::vector<std::string>& peers) { return start(name, peers, {}); }
  bool trusts(const std::string& name, const std::string& other) const {
    for (const auto& each : keys.of(name).list().trusted)
      if (each.lab == other) return true;
    return false;
  }

  template <class Condition>
  [[nodiscard]] bool until(Condition condition, std::chrono::seconds deadline = std::chrono::seconds(300)) {
    return run_until(io, condition, deadline);
  }
  void pass(std::chrono::milliseconds time) {
    const auto end = std::chrono::steady_clock::now() + time;
    (void)until([&] { return std::chrono::steady_clock::now() > end; });
  }
  bool all_up() const {
    for (const auto& [name, lab] : labs)
      for (const auto& [peer, link] : lab.links)
        if (!link->stats().up) return false;
    return true;
  }
  // That each of both has heard these of the other, each once and in order; and that its books say so.
  [[nodiscard]] bool heard(const std::string& name, const std::string& of, const std::vector<std::string>& said) {
    return until([&] {
             const auto& all = labs.at(name).heard[of];
             for (std::size_t i = 0; i < all.size(); ++i)
               if (i >= said.size() || all[i] != said[i]) return true;
             return all.size() == said.size();
           }) &&
           labs.at(name).heard[of] == said;
  }
  // What was said is acknowledged in the end, and the books balance.
  void check_settled() {
    for (const auto& lab : labs)
      for (const auto& to : lab.second.links) {
        CAPTURE(lab.first);
        CAPTURE(to.first);
        const gateway::Link* const link = to.second.get();
        CHECK(until([&] {
          const auto counters = link->stats().counters;
          return counters["outbox.acknowledged.events"] == counters["outbox.accepted.events"];
        }));
        check_accounts(link->stats());
      }
  }
};

// What a lab signs, or seals something beside, in an experiment, for one lab or (empty) for whoever reads it.
inline std::vector<std::byte> federation_context(std::string_view experiment, std::string_view to,
                                                 std::span<const std::byte> bytes) {
  std::vector<std::byte> out;
  for (const std::string_view each : {std::string_view("arkmesh federation 1"), experiment, to}) {
    const auto text = std::as_bytes(std::span(each));
    out.insert(out.end(), text.begin(), text.end());
    out.push_back(std::byte{0});
  }
  out.insert(out.end(), bytes.begin(), bytes.end());
  return out;
}

// A member with a key that the others may trust, who says whatever the test wants. Hears what the server is given.
class RogueMember {
 public:
  RogueMember(Meeting& meeting, std::string name)
      : relay(0xabcdef), meeting_(meeting), name_(std::move(name)), keys_(meeting.keys.tls(name_)) {
    meeting_.server.published = [this](const HostileNats::Message& message) { hear(message); };
  }
  ~RogueMember() { meeting_.server.published = {}; }

  // Signed with its own key, as a packet of `from`.
  HostileNats::Message signed_packet(const gateway::PacketBody& body, const std::string& from) const {
    std::vector<std::byte> packet = gateway::encode_head({gateway::PacketKind::signed_open, from, 1, ++number_});
    const auto encoded = gateway::encode_body(body);
    packet.insert(packet.end(), encoded.begin(), encoded.end());
    const auto signature = keys_->seals().sign(federation_context("dhtf", {}, packet));
    packet.insert(packet.end(), signature.begin(), signature.end());
    return {"arkmesh.dhtf." + from + ".ALL", text(packet)};
  }
  // Sealed with what it and `to` have in common, as a packet of `from`.
  HostileNats::Message sealed_packet(const gateway::PacketBody& body, const std::string& to,
                                     const std::string& from) const {
    std::vector<std::byte> packet = gateway::encode_head({gateway::PacketKind::sealed, from, 1, ++number_});
    const auto* const seal = keys_->seals().of(to);
    REQUIRE(seal);
    const auto sealed = gateway::seal(seal->shared, gateway::encode_body(body), federation_context("dhtf", to, packet));
    packet.insert(packet.end(), sealed.begin(), sealed.end());
    return {"arkmesh.dhtf." + from + "." + to, text(packet)};
  }
  void say_sealed(const gateway::PacketBody& body, const std::string& to) {
    meeting_.server.forward(sealed_packet(body, to, name_));
  }
  // Opens a stream with that lab, as its relay would, and hears what it says there.
  void meet(const std::string& lab) {
    victim_ = lab;
    REQUIRE(meeting_.until([&] { return relay.met() && !relay.unread().empty(); }));
  }
  void say(std::vector<std::vector<std::byte>> chunks) {
    for (auto& each : chunks) relay.put(std::make_shared<gateway::Chunk>(gateway::Chunk{std::move(each), false}));
    gateway::PacketBody body;
    gateway::Piece piece = relay.piece();
    while (relay.next()) {
      piece.chunks.push_back(static_cast<std::uint16_t>(body.chunks.size()));
      held_.push_back(relay.share_next());
      body.chunks.emplace_back(held_.back()->bytes);
      relay.sent({});
    }
    body.pieces.push_back(piece);
    say_sealed(body, victim_);
  }

  gateway::Relay relay;

 private:
  static std::string text(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  void hear(const HostileNats::Message& message) {
    const auto bytes = std::as_bytes(std::span(message.bytes));
    const auto packet = gateway::read_packet(bytes);
    if (!packet || packet->head.from != victim_) return;
    std::optional<std::vector<std::byte>> plain;
    auto body_bytes = packet->body;
    if (packet->head.kind == gateway::PacketKind::sealed) {
      plain = gateway::unseal(keys_->seals().of(victim_)->shared, packet->body,
                              federation_context("dhtf", name_, packet->head_bytes));
      if (!plain) return;
      body_bytes = *plain;
    }
    const auto body = gateway::read_body(body_bytes);
    if (!body) return;
    for (const auto& each : body->greetings)
      if (each.to == name_) {
        relay.hear(each, gateway::order_of(packet->head));
        gateway::Greeting answer = relay.greeting(victim_, each.mine);
        answer.asks = false;
        say_sealed({.greetings = {answer}}, victim_);
      }
    for (const auto& each : body->pieces)
      if (each.yours == relay.mine()) {
        relay.take(each, *body, gateway::order_of(packet->head), std::chrono::steady_clock::now());
        say({});
      }
  }

  Meeting& meeting_;
  const std::string name_;
  const std::shared_ptr<gateway::TlsKeys> keys_;
  std::string victim_;
  std::vector<gateway::ChunkPointer> held_;
  mutable std::uint64_t number_ = 0;  // of its packets: one that comes twice is not looked at
};

}  // namespace arkmesh::tests
