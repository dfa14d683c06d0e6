#include "view/server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/host_name.hpp>
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
constexpr auto rates_every = 1000ms, refresh_every = 500ms;
constexpr std::size_t max_lines = 500, max_line_bytes = 500;  // of the event log that late viewers get
constexpr int max_wrong_tokens = 5;

}  // namespace

struct Server::State final : Reception, std::enable_shared_from_this<Server::State> {
  State(hal::EventLoop& loop, ServerOptions wanted, Desk& who)
      : options(std::move(wanted)),
        desk(&who),
        tls(make_tls(options)),
        sampling(loop),
        rating(loop),
        refreshing(loop),
        seats(options.max_viewers, connections_beside_viewers),
        http(listen_from(loop, options), [this](tcp::socket socket) { return take(std::move(socket)); }),
        access(options.hosts, http.listening().port(), tls != nullptr) {}

  std::shared_ptr<hal::HttpConnection> take(tcp::socket socket) {
    if (!make_way(seats.for_connection())) return totals.add("view.refused.too_many_connections"), nullptr;
    const auto made = make_connection(std::move(socket), tls.get(), *this);
    seats.add(*made);
    return made;
  }

  // False: nobody can make way.
  bool make_way(const Seats::Verdict& verdict) {
    if (verdict.leaves) totals.add("view.sent_away.made_way"), verdict.leaves->leave();
    return verdict.admitted;
  }

  // --- what connections ask ---

  void asked(Connection& connection, const hal::HttpRequest& request) override {
    seats.heard(connection);
    if (!access.is_host(request.host, request.reached))
      return refuse(connection, 403, "host",
                    "This server has another name; view.hosts of the lab's file lists names.\n");
    if (!request.origin.empty() && !access.is_own_origin(request.origin, request.host))
      return refuse(connection, 403, "origin", "Requests from other sites are refused.\n");
    connection.may_control = connection.may_control || access.has_cookie(request.cookie);
    if (request.upgrade) return admit(connection, request);
    if (request.path == "/token" && request.method == "POST") return take_token(connection, request);
    if (request.method != "GET" && request.method != "HEAD")
      return refuse(connection, 405, "method", "Only GET and HEAD.\n");
    if (request.path == "/about.json") return connection.answer({.type = "application/json", .body = text_of(about())});
    if (const auto file = page_file(request.path))
      return connection.answer({.type = file->type, .body = std::string(file->bytes)});
    refuse(connection, 404, "no_such_file", "No such file; the page is at /.\n");
  }

  void refuse(Connection& connection, unsigned status, std::string_view why, std::string_view sentence) {
    totals.add(fmt::format("view.refused.{}", why));
    hal::HttpReply reply{.status = status, .body = std::string(sentence)};
    if (status == 405) reply.headers = {{"Allow", "GET, HEAD"}};
    connection.answer(std::move(reply));
  }

  void take_token(Connection& connection, const hal::HttpRequest& request) {
    if (request.origin.empty() || !access.is_token(request.body)) {
      totals.add("view.refused.token");
      return connection.answer_later(refused(connection, nullptr, "wrong_token"), [] {
        return hal::HttpReply{.status = 403, .body = "This is not the token in the URL that the lab printed.\n"};
      });
    }
    connection.may_control = true;
    connection.answer({.status = 204, .headers = {{"Set-Cookie", access.set_cookie()}}});
  }

  // What a viewer was refused for want of a token is written down by the desk. Returns how long the viewer is to wait.
  Patience::Wait refused(Connection& viewer, const json& what, std::string_view why) {
    desk->refused(what, why, viewer.from.to_string());
    return viewer.may_control ? Patience::Wait(0) : patience.after_wrong(viewer.from, Monotonic::now());
  }

  // It wants to watch.
  void admit(Connection& connection, const hal::HttpRequest& request) {
    if (request.origin.empty()) return refuse(connection, 403, "origin", "A WebSocket needs an Origin header.\n");
    if (request.path != "/ws") return refuse(connection, 404, "no_such_file", "The WebSocket is at /ws.\n");
    if (!make_way(seats.for_viewer(connection.may_control)))
      return refuse(connection, 503, "too_many_viewers", "Too many viewers already.\n");
    connection.open();
  }

  void joined(Connection& viewer) override {
    totals.add("view.viewers");
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
    Answer answer(std::static_pointer_cast<Connection>(viewer.shared_from_this()), numbered ? *number : json());
    const bool commands = what.contains("command") || what.contains("fault") || what.contains("move");
    Heard heard;
    try {
      if (commands && !viewer.may_control) {
        refuse(answer, "no_token", "This needs the lab's token: open the URL that the lab printed.");
        heard.wait = refused(viewer, what, "no_token");
      } else if (commands)
        desk->command(what, answer);
      else if (numbered)
        desk->request(what, answer);
      else
        refuse(answer, "unknown", "The server does not know this request.");
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
  asio::steady_timer sampling, rating, refreshing;
  Seats seats;
  Patience patience;
  Channels channels;
  std::deque<Line> lines;
  json cameras = json::array();
  Monotonic::time_point rated{};
  std::uint64_t replaced_by_gone = 0;
  hal::Counters totals;
  hal::HttpServer http;  // its connections use all that is above
  Access access;
};

Server::Server(hal::EventLoop& loop, ServerOptions options, Desk& desk)
    : state_(std::make_shared<State>(loop, std::move(options), desk)) {}
Server::~Server() = default;

std::uint16_t Server::port() const {
  return state_->http.listening().port();
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
  // Commands, and texts of robots, are few, and each counts.
  if (state_->seats.watching().empty() ||
      !(channel.ends_with("operator_command") || channel == "fleet_command" || channel == "robot_texts"))
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
