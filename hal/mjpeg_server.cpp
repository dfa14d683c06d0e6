// Plain sockets that never block. All pictures in flight are shared: a client holds a reference to one of them at most.
#include "hal/mjpeg_server.hpp"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <initializer_list>
#include <list>
#include <map>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "hal/listening_socket.hpp"

namespace arkmesh::hal {
namespace {

using Monotonic = std::chrono::steady_clock;
using Bytes = std::shared_ptr<const std::string>;

constexpr std::size_t most_request_bytes = 4096;
constexpr std::chrono::seconds request_within{5}, progress_within{10};
constexpr std::chrono::seconds fresh_for{1},
    picture_within{5};  // an older picture is shown only when no newer one comes
constexpr std::string_view boundary = "arkmeshpicture";

std::string response(std::string_view status, std::string_view type, std::string_view body) {
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n{}",
      status, type, body.size(), body);
}

}  // namespace

struct MjpegServer::State {
  // glancing: wants one picture, the next; leaving: as soon as everything is sent
  enum class Stage { asking, watching, glancing, leaving };
  struct Client {
    Handle socket;
    Stage stage = Stage::asking;
    std::string request, stream;
    Bytes out;  // in flight
    std::size_t sent = 0;
    Monotonic::time_point since;  // of the stage, or of the last byte that it took
  };

  State(const std::string& address, std::uint16_t wanted)
      : listener(listen_on(address, wanted, "pictures")), port(port_of(listener.get())) {}

  void accept() {
    for (std::size_t k = 0; k < most_clients; ++k) {
      Handle socket(::accept(listener.get(), nullptr, nullptr));
      if (socket.get() < 0) return;
      if (clients.size() >= most_clients) {
        counters.add("mjpeg.refused.too_many");
        continue;
      }
      no_waiting(socket.get());
      const int yes = 1;
      ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      clients.push_back({.socket = std::move(socket), .since = Monotonic::now()});
      counters.add("mjpeg.clients");
    }
  }

  // False: the client has gone.
  bool read(Client& client) {
    std::array<char, 2048> some;
    for (int k = 0; k < 4; ++k) {
      const ssize_t n = ::recv(client.socket.get(), some.data(), some.size(), 0);
      if (n == 0) return client.stage == Stage::leaving && client.out;  // it says no more, but may still listen
      if (n < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
      if (client.stage != Stage::asking) continue;  // whatever it says now is of no interest
      client.request.append(some.data(), static_cast<std::size_t>(n));
      if (client.request.find("\r\n\r\n") != std::string::npos || client.request.find("\n\n") != std::string::npos)
        answer(client);
      else if (client.request.size() > most_request_bytes) {
        counters.add("mjpeg.refused.request_too_long");
        leave_with(client, response("431 Request Header Fields Too Large", "text/plain", "request too long\n"));
      }
    }
    return true;
  }

  void leave_with(Client& client, std::string bytes) {
    client.stage = Stage::leaving;
    client.out = std::make_shared<const std::string>(std::move(bytes));
    client.sent = 0;
    client.since = Monotonic::now();
  }

  void answer(Client& client) {
    const std::string_view line = std::string_view(client.request).substr(0, client.request.find_first_of("\r\n"));
    const std::size_t first = line.find(' '), second = line.find(' ', first + 1);
    if (first == std::string_view::npos || !line.starts_with("GET ")) {
      counters.add("mjpeg.refused.request");
      return leave_with(client, response("405 Method Not Allowed", "text/plain", "only GET\n"));
    }
    std::string_view path = line.substr(first + 1, second == std::string_view::npos ? second : second - first - 1);
    path = path.substr(0, path.find('?'));
    if (path == "/") return leave_with(client, response("200 OK", "text/html; charset=utf-8", page()));
    std::string name(path.substr(std::min<std::size_t>(1, path.size())));
    const bool single = name.ends_with(".jpg") && !streams.contains(name);
    if (single) name.resize(name.size() - 4);
    const auto stream = streams.find(name);
    if (stream == streams.end()) {
      counters.add("mjpeg.refused.no_such_stream");
      return leave_with(client, response("404 Not Found", "text/plain", "no such stream; / lists them\n"));
    }
    client.since = Monotonic::now();
    const bool fresh = stream->second.jpeg && client.since - stream->second.shown < fresh_for;
    if (single && fresh) return leave_with(client, response("200 OK", "image/jpeg", *stream->second.jpeg));
    client.stage = single ? Stage::glancing : Stage::watching;
    client.stream = name;
    if (single) return;
    client.out = std::make_shared<const std::string>(
        fmt::format("HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary={0}\r\nCache-Control: "
                    "no-store\r\nConnection: close\r\n\r\n"
                    "--{0}\r\n{1}",
                    boundary, fresh ? *stream->second.part : ""));
    client.sent = 0;
  }

  // Who waited for one picture and sees none come gets the last there was.
  void give_up_waiting(Client& client, Monotonic::time_point now) {
    if (client.stage != Stage::glancing || now - client.since <= picture_within) return;
    const auto stream = streams.find(client.stream);
    if (stream != streams.end() && stream->second.jpeg)
      return leave_with(client, response("200 OK", "image/jpeg", *stream->second.jpeg));
    counters.add("mjpeg.refused.no_picture");
    leave_with(client, response("503 Service Unavailable", "text/plain", "no picture has come yet\n"));
  }

  // All streams one below the other. A picture whose stream ended is asked for again until it is back; a page without
  // any, as well.
  std::string page() const {
    std::string out =
        "<!DOCTYPE html><title>arkmesh</title>\n<style>body { background: #222; color: #ccc; font-family: sans-serif "
        "}\n"
        "img { max-width: 100% } a { color: inherit }</style>\n";
    for (const auto& [name, stream] : streams) {
      std::string text;
      for (char c : name) text += c == '<' ? "&lt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
      out += fmt::format("<p><a href=\"/{0}\">{0}</a><br><img src=\"/{0}\" alt=\"no picture\"></p>\n", text);
    }
    if (streams.empty()) return out + "<meta http-equiv=\"refresh\" content=\"2\"><p>No pictures yet.</p>\n";
    return out +
           "<script>\nfor (const picture of document.images) {\n  const path = picture.getAttribute('src');\n"
           "  picture.onerror = () => setTimeout(() => { picture.src = path + '?' + Date.now(); }, "
           "1000);\n}\n</script>\n";
  }

  // False: the client has gone, or is done.
  bool write(Client& client) {
    while (client.out) {
      const ssize_t n =
          ::send(client.socket.get(), client.out->data() + client.sent, client.out->size() - client.sent, MSG_NOSIGNAL);
      if (n < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
      client.since = Monotonic::now();
      client.sent += static_cast<std::size_t>(n);
      if (client.sent < client.out->size()) return true;
      client.out.reset();
    }
    return client.stage != Stage::leaving;
  }

  bool too_slow(const Client& client, Monotonic::time_point now) {
    if (client.stage == Stage::asking && now - client.since > request_within)
      counters.add("mjpeg.sent_away.no_request");
    else if (client.out && now - client.since > progress_within)
      counters.add("mjpeg.sent_away.takes_nothing");
    else
      return false;
    return true;
  }

  // A picture in two forms: by itself, and as one part of a stream with what separates it from the next. Neither: none
  // has been shown.
  struct Stream {
    Bytes jpeg, part;
    Monotonic::time_point shown;
  };

  std::size_t waiting_for(const std::string& stream, std::initializer_list<Stage> stages) const {
    return static_cast<std::size_t>(std::ranges::count_if(clients, [&](const Client& client) {
      return client.stream == stream && std::ranges::find(stages, client.stage) != stages.end();
    }));
  }

  Handle listener;
  std::uint16_t port;
  std::list<Client> clients;
  std::map<std::string, Stream> streams;
  Counters counters;
};

MjpegServer::MjpegServer(const std::string& address, std::uint16_t port)
    : state_(std::make_unique<State>(address, port)) {}
MjpegServer::~MjpegServer() = default;

std::uint16_t MjpegServer::port() const {
  return state_->port;
}
const Counters& MjpegServer::counters() const {
  return state_->counters;
}

void MjpegServer::announce(const std::string& stream) {
  state_->streams[stream];
}

void MjpegServer::show(const std::string& stream, std::span<const std::byte> jpeg) {
  const std::string_view bytes(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  State::Stream& entry = state_->streams[stream];
  entry.jpeg = std::make_shared<const std::string>(bytes);
  entry.part = std::make_shared<const std::string>(fmt::format(
      "Content-Type: image/jpeg\r\nContent-Length: {}\r\n\r\n{}\r\n--{}\r\n", bytes.size(), bytes, boundary));
  entry.shown = Monotonic::now();
  for (State::Client& client : state_->clients) {
    if (client.stream != stream) continue;
    if (client.stage == State::Stage::glancing)
      state_->leave_with(client, response("200 OK", "image/jpeg", *entry.jpeg));
    if (client.stage != State::Stage::watching) continue;
    if (client.out) {
      state_->counters.add("mjpeg.skipped");
      continue;
    }
    client.out = entry.part;
    client.sent = 0;
    client.since = Monotonic::now();
  }
  serve();
}

void MjpegServer::close(const std::string& stream) {
  if (state_->streams.erase(stream) == 0) return;
  std::erase_if(state_->clients, [&](const State::Client& client) {
    return client.stream == stream &&
           (client.stage == State::Stage::watching || client.stage == State::Stage::glancing);
  });
}

std::size_t MjpegServer::watchers(const std::string& stream) const {
  return state_->waiting_for(stream, {State::Stage::watching, State::Stage::glancing});
}

// Those who have left make room for those who come.
void MjpegServer::serve() {
  const Monotonic::time_point now = Monotonic::now();
  std::erase_if(state_->clients, [&](State::Client& client) {
    if (!state_->read(client)) return true;
    state_->give_up_waiting(client, now);
    return !state_->write(client) || state_->too_slow(client, now);
  });
  state_->accept();
}

}  // namespace arkmesh::hal
