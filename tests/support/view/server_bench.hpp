// A page's server on a loop of its own, with a desk that keeps what it was asked.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/view/browser.hpp"
#include "view/server.hpp"

namespace arkmesh::tests {

struct TestDesk final : view::Desk {
  nlohmann::json about() override { return {{"mode", "live"}, {"labs", {"a", "b"}}, {"control", true}}; }
  void command(const nlohmann::json& what, view::Answer& answer) override {
    commands.push_back(what);
    answer.done();
  }
  void request(const nlohmann::json& what, view::Answer& answer) override {
    if (what.contains("fail")) throw std::runtime_error("This cannot be.");
    const std::string data(what.value("bytes", std::size_t{4}), 'x');
    for (int i = 0; i < what.value("count", 1); ++i)
      if (!answer.message(1, i, "poses", std::as_bytes(std::span(data)))) return answer.refuse("Ask for less.");
    answer.done({{"count", what.value("count", 1)}});
  }
  void refused(const nlohmann::json& what, std::string_view why, const std::string& from) override {
    refusals.push_back({{"what", what}, {"why", why}, {"from", from}});
  }
  void refresh() override { ++refreshed; }
  std::vector<nlohmann::json> refusals;
  std::vector<nlohmann::json> commands;
  int refreshed = 0;
};

struct ServerBench {
  boost::asio::io_context loop;
  TestDesk desk;
  view::Server server{loop, {.port = 0}, desk};

  std::string token() const {
    const std::string url = server.url_with_token();
    return url.substr(url.find("#token=") + 7);
  }
  std::uint64_t count(const std::string& name) const { return server.counters()["view." + name]; }
  void show(const std::string& channel, const std::string& data, int lab = 0, std::int64_t t_us = 1) {
    server.show(lab, t_us, channel, std::as_bytes(std::span(data)));
  }
  bool counts(const std::string& name, std::uint64_t n = 1) {
    return comes_to(serving(loop), [&] { return count(name) >= n; });
  }
};

}  // namespace arkmesh::tests
