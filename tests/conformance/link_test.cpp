// Every link runs the same checks. A new transport adds its line to link_rows().
#include <doctest/doctest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "gateway/links/connections.hpp"
#include "gateway/links/loopback.hpp"
#include "tests/conformance/link_conformance.hpp"
#include "tests/examples/folder_link.hpp"
#include "tests/support/network/impairment_proxy.hpp"
#include "tests/support/network/nats_server.hpp"
#include "tests/support/network/tcp_bench.hpp"
#include "tests/support/network/test_keys.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
using namespace arkmesh::tests;

namespace {

std::string other(const std::string& lab) {
  return lab == "left" ? "right" : "left";
}

class LoopbackWorld final : public LinkWorld {
 public:
  explicit LoopbackWorld(LoopbackImpairment impairment = {}) { network_.impair("left", "right", impairment); }
  std::unique_ptr<Link> end(const std::string& lab) override { return network_.end(lab, other(lab)); }
  void cut(bool is_cut) override { network_.set_up("left", "right", !is_cut); }
  void step() override { network_.step(); }

 private:
  LoopbackNetwork network_{1};
};

// Both ends in one loop.
class LoopWorld : public LinkWorld {
 public:
  void step() override {
    io_.restart();
    io_.run_one_for(std::chrono::milliseconds(5));
    io_.poll();
  }

 protected:
  boost::asio::io_context io_;
  std::uint64_t boot_id_ = 0;
};

// Each lab has a node, and "right" goes through a proxy.
class ProxiedWorld : public LoopWorld {
 public:
  void cut(bool is_cut) override { proxy_->refuse(is_cut); }

 protected:
  void put_proxy_before(std::uint16_t port, const Impairment& impairment) {
    proxy_ = std::make_unique<ImpairmentProxy>(port);
    proxy_->set(impairment);
  }

  TestKeys keys_;
  std::map<std::string, std::unique_ptr<Connections>> nodes_;
  std::unique_ptr<ImpairmentProxy> proxy_;
};

// "left" listens, "right" connects.
class TcpWorld final : public ProxiedWorld {
 public:
  explicit TcpWorld(const Impairment& impairment = {}, bool tls = false) : tls_(tls) {
    if (tls_) keys_.join("left", "right");
    make_node("left", tls_ ? "tls://127.0.0.1:0" : "127.0.0.1:0");
    put_proxy_before(nodes_.at("left")->listening().port(), impairment);
  }
  std::unique_ptr<Link> end(const std::string& lab) override {
    if (lab == "left") return nodes_.at("left")->link("right");
    make_node("right", "");
    const std::string there = "127.0.0.1:" + std::to_string(proxy_->port());
    return tls_ ? nodes_.at("right")->tls_link("left", there) : nodes_.at("right")->link("left", there);
  }

 private:
  void make_node(const std::string& lab, const std::string& listen) {
    TcpSettings settings = tcp_settings(lab, ++boot_id_);
    settings.listen = listen;
    if (tls_) settings.keys = keys_.tls(lab);
    nodes_[lab] = std::make_unique<Connections>(io_, std::move(settings));
  }

  const bool tls_;
};

// Both meet at a server.
class NatsWorld final : public ProxiedWorld {
 public:
  explicit NatsWorld(const Impairment& impairment = {}, bool encrypt = false) : encrypt_(encrypt) {
    keys_.join("left", "right");
    put_proxy_before(server_.port(), impairment);
  }
  std::unique_ptr<Link> end(const std::string& lab) override {
    TcpSettings settings = tcp_settings(lab, ++boot_id_);
    settings.keys = keys_.tls(lab);
    settings.federation.encrypt = encrypt_;
    nodes_[lab] = std::make_unique<Connections>(io_, std::move(settings));
    const std::uint16_t port = lab == "left" ? server_.port() : proxy_->port();
    return nodes_.at(lab)->federation_link(other(lab), "127.0.0.1:" + std::to_string(port), false);
  }

 private:
  const bool encrypt_;
  NatsServerProcess server_;
};

// Both look into one folder, which is gone while the line is cut.
class FolderWorld final : public LoopWorld {
 public:
  FolderWorld() { std::filesystem::create_directory(folder_); }
  std::unique_ptr<Link> end(const std::string& lab) override {
    return std::make_unique<examples::FolderLink>(io_, examples::FolderLinkSettings{
                                                           .lab = lab,
                                                           .peer = other(lab),
                                                           .boot_id = ++boot_id_,
                                                           .folder = folder_,
                                                           .look_period = std::chrono::milliseconds(5),
                                                           .beat_period = std::chrono::milliseconds(20),
                                                       });
  }
  void cut(bool is_cut) override {
    const std::filesystem::path away = parent_.path() / "away";
    std::filesystem::rename(is_cut ? folder_ : away, is_cut ? away : folder_);
  }

 private:
  TemporaryDirectory parent_;
  std::filesystem::path folder_ = parent_.path() / "shared";
};

const std::vector<LinkRow>& link_rows() {
  using std::chrono::microseconds;
  static const std::vector<LinkRow> table{
      {"loopback", [] { return std::make_unique<LoopbackWorld>(); }},
      {"loopback, late",
       [] { return std::make_unique<LoopbackWorld>(LoopbackImpairment{.delay_steps = 5, .jitter_steps = 7}); }},
      {"tcp", [] { return std::make_unique<TcpWorld>(); }},
      {"tcp, late",
       [] {
         return std::make_unique<TcpWorld>(Impairment{.delay = microseconds(20'000), .jitter = microseconds(10'000)});
       }},
      {"tcp, in slices", [] { return std::make_unique<TcpWorld>(Impairment{.slice_bytes = 7}); }},
      {"tls", [] { return std::make_unique<TcpWorld>(Impairment{}, true); }},
      {"tls, in slices", [] { return std::make_unique<TcpWorld>(Impairment{.slice_bytes = 7}, true); }},
      {"nats", [] { return std::make_unique<NatsWorld>(); }},
      {"nats, late",
       [] {
         return std::make_unique<NatsWorld>(Impairment{.delay = microseconds(20'000), .jitter = microseconds(10'000)});
       }},
      {"nats, in slices", [] { return std::make_unique<NatsWorld>(Impairment{.slice_bytes = 70}); }},
      {"nats, encrypted", [] { return std::make_unique<NatsWorld>(Impairment{}, true); }},
      {"folder", [] { return std::make_unique<FolderWorld>(); }},
  };
  return table;
}

void for_each_link(void (*check)(const LinkRow&)) {
  for (const LinkRow& row : link_rows()) {
    CAPTURE(row.name);
    check(row);
  }
}

}  // namespace

TEST_CASE("links come up and go down") {
  // Both ends of every link learn each change once, and why.
  for_each_link(check_up_and_down);
}

TEST_CASE("links keep order and content") {
  // Messages from 0 to 5000 bytes arrive unchanged and in order, and the totals of both ends agree.
  for_each_link(check_order);
}

TEST_CASE("links carry large messages") {
  // The largest message that the default configuration allows arrives unchanged.
  for_each_link(check_large);
}

TEST_CASE("links survive an outage") {
  // After an outage the newest of `latest` and all of `ordered` arrive, and what was replaced is counted.
  for_each_link(check_outage);
}

TEST_CASE("links are bounded while down") {
  // 6.4 MiB offered to a link that is down cost the oldest ordered messages, each counted, and never the newest
  // `latest`.
  for_each_link(check_overflow);
}

TEST_CASE("stopped links are silent") {
  // No event comes after stop(), whatever is under way.
  for_each_link(check_stop);
}

TEST_CASE("links may be stopped by what they tell") {
  // A handler may end its own link.
  for_each_link(check_stop_inside);
}

TEST_CASE("links meet a restarted peer") {
  // A peer that starts again is met again, without help from the other side.
  for_each_link(check_restart);
}
