#include "view/server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>
#include <utility>

#include "view/access.hpp"
#include "view/connection.hpp"
#include "view/door.hpp"
#include "view/page_files.hpp"
#include "view/patience.hpp"
#include "view/seats.hpp"

namespace arkmesh::view {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Monotonic = std::chrono::steady_clock;
using nlohmann::json;
using namespace std::chrono_literals;

constexpr std::size_t connections_beside_viewers = 32;  // for the page's files
constexpr auto accept_again_after = 100ms, rates_every = 1000ms, refresh_every = 500ms;
constexpr std::size_t max_lines = 500, max_line_bytes = 500;  // of the event log that late viewers get
constexpr int max_wrong_tokens = 5;

}  // namespace

struct Server::State final : Reception, std::enable_shared_from_this<Server::State> {
  State(hal::EventLoop& loop, ServerOptions wanted, Desk& who)
      : options(std::move(wanted)),
        desk(&who),
        tls(make_tls(options)),
        acceptor(listen_from(loop, options)),
        again(loop),
        sampling(loop),
        rating(loop),
        refreshing(loop),
        port(acceptor.local_endpoint().port()),
        access(options.hosts, port, tls != nullptr),
        seats(options.max_viewers, connections_beside_viewers) {}

  void accept() {
    acceptor.async_accept([weak = weak_from_this()](error_code error, tcp::socket socket) {
      const auto self = weak.lock();
      if (!self || error == asio::error::operation_aborted) return;
      if (error) return self->accept_later();
      self->take(std::move(socket));
      self->accept();
    });
  }

  // Without a file descriptor to spare, say.
  void accept_later() {
    again.expires_after(accept_again_after);
    again.async_wait([weak = weak_from_this()](error_code error) {
      if (const auto self = weak.lock(); self && !error) self->accept();
    });
  }

  void take(tcp::socket socket) {
    if (!make_way(seats.for_connection())) return totals.add("view.refused.too_many_connections");
    const auto made = make_connection(std::move(socket), tls.get(), *this);
    seats.add(made);
    made->start();
  }

  // False: nobody can make way.
  bool make_way(const Seats::Verdict& verdict) {
    if (verdict.leaves) totals.add("view.sent_away.made_way"), verdict.leaves->leave();
    return verdict.admitted;
  }

  // --- what connections ask ---

  // Empty when the request comes as it should.
  Reply strange(const Request& request) {
    if (!access.is_host(request.host, request.reached)) {
      totals.add("view.refused.host");
      return {.status = 403,
              .body = "This server is not known by that name; view.hosts of the lab's file lists names.\n"};
    }
    if (!request.origin.empty() && !access.is_own_origin(request.origin, request.host)) {
      totals.add("view.refused.origin");
      return {.status = 403, .body = "Pages of other sites may not ask here.\n"};
    }
    return {};
  }

  Reply reply_to(Connection& connection, const Request& request) override {
    seats.heard(connection);
    if (Reply refusal = strange(request); refusal.status != 200) return refusal;
    connection.may_control = connection.may_control || access.has_cookie(request.cookie);
    if (request.path == "/token" && request.method == "POST") return reply_to_token(connection, request);
    if (request.method != "GET" && request.method != "HEAD") {
      totals.add("view.refused.method");
      return {.status = 405, .body = "Only GET and HEAD.\n"};
    }
    if (request.path == "/about.json") return {.type = "application/json", .body = text_of(about())};
    if (const auto file = page_file(request.path)) return {.type = file->type, .body = std::string(file->bytes)};
    totals.add("view.refused.no_such_file");
    return {.status = 404, .body = "There is no such file here; / is the page.\n"};
  }

  Reply reply_to_token(Connection& connection, const Request& request) {
    if (request.origin.empty() || !access.is_token(request.body)) {
      totals.add("view.refused.token");
      return {.status = 403,
              .body = "This is not the token in the URL that the lab printed.\n",
              .after = refused(connection, nullptr, "wrong_token")};
    }
    connection.may_control = true;
    return {.status = 204, .body = {}, .set_cookie = access.set_cookie()};
  }

  // What a viewer was refused for want of a token is written down by the desk. Returns how long the viewer is to wait.
  Patience::Wait refused(Connection& viewer, const json& what, std::string_view why) {
    desk->refused(what, why, viewer.from.to_string());
    return viewer.may_control ? Patience::Wait(0) : patience.after_wrong(viewer.from, Monotonic::now());
  }

  Reply admit(Connection& connection, const Request& request) override {
    seats.heard(connection);
    if (Reply refusal = strange(request); refusal.status != 200) return refusal;
    if (request.origin.empty()) {
      totals.add("view.refused.origin");
      return {.status = 403, .body = "A WebSocket must say of which page it is (Origin).\n"};
    }
    if (request.path != "/ws") {
      totals.add("view.refused.no_such_file");
      return {.status = 404, .body = "The WebSocket is at /ws.\n"};
    }
    if (!make_way(seats.for_viewer(access.has_cookie(request.cookie)))) {
      totals.add("view.refused.too_many_viewers");
      return {.status = 503, .body = "Too many watch already.\n"};
    }
    return {.status = 101};
  }

  void joined(Connection& viewer, const Request& request) override {
    totals.add("view.viewers");
    viewer.may_control = access.has_cookie(request.cookie);
    if (seats.watching().empty()) start_clocks();
    seats.watch(viewer);
    greet(viewer);
    if (!cameras.empty()) viewer.outbox().say(text_of({{"cameras", cameras}}));
    for (const Line& line : lines) viewer.outbox().event(as_event(line));
    for (auto& [slot, parcel] : channels.all()) viewer.outbox().newest(slot, parcel);
  }

  void greet(Connection& viewer) {
    json hello = about();
    hello["token_ok"] = viewer.may_control;
    viewer.outbox().say(text_of({{"hello", std::move(hello)}}));
  }

  json about() {
    json out = desk->about();
    out["version"] = ARKMESH_VERSION;
    return out;
  }

  Heard said(Connection& viewer, std::string_view text) override {
    const json what = json::parse(text, nullptr, false);
    if (!what.is_object()) return {.good = false};
    if (const auto token = what.find("token"); token != what.end()) return show_token(viewer, *token);
    const auto number = what.find("request");
    const bool numbered = number != what.end() && number->is_number_unsigned() && *number <= 0xffff'ffffu;
    Answer answer(viewer.weak_from_this(), numbered ? *number : json());
    const bool commands = what.contains("command") || what.contains("fault") || what.contains("move");
    Heard heard;
    try {
      if (commands && !viewer.may_control) {
        refuse(answer, "no_token", "Only who has the lab's token may do this: open the URL that the lab printed.");
        heard.wait = refused(viewer, what, "no_token");
      } else if (commands)
        desk->command(what, answer);
      else if (numbered)
        desk->request(what, answer);
      else
        refuse(answer, "unknown", "The server does not know this message.");
    } catch (const std::exception& error) {
      refuse(answer, "request", error.what());
    }
    return heard;
  }

  Heard show_token(Connection& viewer, const json& token) {
    viewer.may_control =
        viewer.may_control || (token.is_string() && access.is_token(token.get_ref<const std::string&>()));
    Heard heard;
    if (!viewer.may_control) {
      totals.add("view.refused.token");
      heard = {.good = ++viewer.wrong_tokens < max_wrong_tokens, .wait = refused(viewer, nullptr, "wrong_token")};
    }
    greet(viewer);
    return heard;
  }

  void refuse(Answer& answer, std::string_view why, std::string_view sentence) {
    totals.add(fmt::format("view.refused.{}", why));
    answer.refuse(sentence);
  }

  void left(Connection& connection) override {
    if (!seats.remove(connection)) return;
    replaced_by_gone += connection.outbox().replaced();
    if (seats.watching().empty()) sampling.cancel(), rating.cancel(), refreshing.cancel();
  }

  hal::Counters& counters() override { return totals; }

  // --- what viewers get ---

  void start_clocks() {
    channels.start_rates();
    rated = Monotonic::now();
    desk->refresh();
    repeat(sampling, std::chrono::duration_cast<Monotonic::duration>(std::chrono::duration<double>(1 / options.per_s)),
           [](State& self) { self.sample(); });
    repeat(rating, rates_every, [](State& self) { self.tell_rates(); });
    repeat(refreshing, refresh_every, [](State& self) { self.desk->refresh(); });
  }

  // As long as somebody watches.
  void repeat(asio::steady_timer& timer, Monotonic::duration every, void (*what)(State&)) {
    timer.expires_after(every);
    timer.async_wait([weak = weak_from_this(), &timer, every, what](error_code error) {
      const auto self = weak.lock();
      if (!self || error || self->seats.watching().empty()) return;
      what(*self);
      self->repeat(timer, every, what);
    });
  }

  void sample() {
    const auto fresh = channels.take_fresh();
    if (fresh.empty()) return;
    for_each_viewer([&](Connection& viewer) {
      for (const auto& [slot, parcel] : fresh) viewer.outbox().newest(slot, parcel);
    });
  }

  void tell_rates() {
    const auto now = Monotonic::now();
    json rates = {{"t_us", channels.newest_us()},
                  {"labs", channels.rates(std::chrono::duration<double>(now - std::exchange(rated, now)).count())}};
    for_each_viewer([&](Connection& viewer) {
      rates["viewer"] = {{"replaced", viewer.outbox().replaced()}};
      // The newest is enough: a slot of its own, behind those of all channels.
      viewer.outbox().newest(Channels::max_channels,
                             {std::make_shared<const std::string>(text_of({{"rates", rates}})), true});
    });
  }

  // A viewer may leave when it is sent something.
  template <class What>
  void for_each_viewer(What what) {
    const auto& watching = seats.watching();
    for (const std::vector<Connection*> all(watching.begin(), watching.end()); Connection * viewer : all) {
      if (!watching.contains(viewer)) continue;
      what(*viewer);
      viewer->send();
    }
  }

  struct Line {
    int lab;
    std::int64_t t_us;
    std::string text;
  };
  static Parcel as_event(const Line& line) {
    const json what = {{"events",
                        {{"lab", line.lab < 0 ? json() : json(line.lab)},
                         {"lines", json::array({{{"t_us", line.t_us}, {"text", line.text}}})}}}};
    return {std::make_shared<const std::string>(text_of(what)), true};
  }

  ServerOptions options;
  Desk* desk;
  std::unique_ptr<asio::ssl::context> tls;  // null: plain
  tcp::acceptor acceptor;
  asio::steady_timer again, sampling, rating, refreshing;
  std::uint16_t port;
  Access access;
  Seats seats;
  Patience patience;
  Channels channels;
  std::deque<Line> lines;
  json cameras = json::array();
  Monotonic::time_point rated{};
  std::uint64_t replaced_by_gone = 0;
  hal::Counters totals;
};

Server::Server(hal::EventLoop& loop, ServerOptions options, Desk& desk)
    : state_(std::make_shared<State>(loop, std::move(options), desk)) {
  state_->accept();
}

Server::~Server() {
  for (const auto& connection : state_->seats.all()) connection->leave();
}

std::uint16_t Server::port() const {
  return state_->port;
}

std::string Server::url() const {
  const ServerOptions& options = state_->options;
  error_code wrong;
  const auto ip = asio::ip::make_address(options.address, wrong);
  std::string host = options.address;
  if (!options.hosts.empty())
    host = options.hosts.front();
  else if (!wrong && ip.is_unspecified())
    host = asio::ip::host_name(wrong);
  else if (!wrong && ip.is_v6())
    host = fmt::format("[{}]", host);
  const bool has_port = host.rfind(':') != std::string::npos && host.back() != ']';
  return fmt::format("{}://{}{}/", state_->tls ? "https" : "http", host, has_port ? "" : fmt::format(":{}", port()));
}

std::string Server::url_with_token() const {
  return fmt::format("{}#token={}", url(), state_->access.token());
}

void Server::show(int lab, std::int64_t t_us, std::string_view channel, std::span<const std::byte> data, Part part) {
  state_->channels.note(Kind::message, lab, t_us, channel, data, part);
  // Commands are few, and each counts.
  if (state_->seats.watching().empty() || !(channel.ends_with("operator_command") || channel == "fleet_command"))
    return;
  const Parcel event{std::make_shared<const std::string>(frame(Kind::message, lab, 0, t_us, channel, data))};
  state_->for_each_viewer([&](Connection& viewer) { viewer.outbox().event(event); });
}

void Server::show_picture(int lab, std::int64_t t_us, std::string_view camera, std::span<const std::byte> jpeg) {
  state_->channels.note(Kind::picture, lab, t_us, camera, jpeg);
}

void Server::set_camera(int lab, json camera) {
  camera["lab"] = lab;
  json& all = state_->cameras;
  const auto same = std::ranges::find_if(all, [&](const json& one) {
    return one["lab"] == camera["lab"] && one.value("name", "") == camera.value("name", "");
  });
  if (same != all.end())
    *same = std::move(camera);
  else
    all.push_back(std::move(camera));
  const std::string text = text_of({{"cameras", all}});
  state_->for_each_viewer([&](Connection& viewer) { viewer.outbox().say(text); });
}

void Server::tell(int lab, std::int64_t t_us, std::string_view text) {
  auto& lines = state_->lines;
  lines.push_back({lab, t_us, std::string(text.substr(0, max_line_bytes))});
  if (lines.size() > max_lines) lines.pop_front();
  if (state_->seats.watching().empty()) return;
  const Parcel event = State::as_event(lines.back());
  state_->for_each_viewer([&](Connection& viewer) { viewer.outbox().event(event); });
}

std::size_t Server::viewers() const {
  return state_->seats.watching().size();
}

void Server::sample() {
  state_->sample();
}

bool Server::sending() const {
  return std::ranges::any_of(state_->seats.watching(), [](const Connection* viewer) { return viewer->sending(); });
}

hal::Counters Server::counters() const {
  hal::Counters all = state_->totals;
  all.merge(state_->channels.counters());
  std::uint64_t replaced = state_->replaced_by_gone;
  for (const Connection* viewer : state_->seats.watching()) replaced += viewer->outbox().replaced();
  if (replaced > 0) all.set("view.replaced", replaced);
  return all;
}

}  // namespace arkmesh::view
