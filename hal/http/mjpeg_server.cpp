// Callbacks on the loop. All pictures in flight are shared: a client holds a reference to one of them at most.
#include "hal/http/mjpeg_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/write.hpp>
#include <chrono>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/http/http_server.hpp"
#include "hal/listen.hpp"

namespace arkmesh::hal {
namespace {

using boost::asio::ip::tcp;
using Monotonic = std::chrono::steady_clock;
using Bytes = std::shared_ptr<const std::string>;
using Error = boost::system::error_code;

constexpr HttpLimits limits{};
constexpr std::chrono::seconds fresh_for{1},
    picture_within{5};  // an older picture is shown only when no newer one comes
constexpr std::string_view boundary = "arkmeshpicture";

Bytes shared(std::string bytes) {
  return std::make_shared<const std::string>(std::move(bytes));
}

// A picture in two forms: by itself, and as one part of a stream with what separates it from the next. Neither: none
// has been shown.
struct Stream {
  Bytes jpeg, part;
  Monotonic::time_point shown;
  bool fresh() const { return jpeg && Monotonic::now() - shown < fresh_for; }
  HttpReply single() const { return {.type = "image/jpeg", .body = *jpeg}; }
};

using Streams = std::map<std::string, Stream, std::less<>>;

// All streams one below the other. A picture whose stream ended is asked for again until it is back; a page without
// any, as well.
std::string page_of(const Streams& streams) {
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

// What all clients of a server share.
struct Shared {
  Streams streams;
  Counters counters;
};

class Client final : public HttpConnection {
 public:
  Client(tcp::socket socket, Shared& all) : HttpConnection(std::move(socket), limits, nullptr), all_(all) {}

  bool waits_for(std::string_view stream) const { return !waits_for_.empty() && waits_for_ == stream; }

  // A new picture of the stream that it waits for.
  void show(const Stream& stream) {
    if (glances_) return complete(stream.single());
    if (out_) return all_.counters.add("mjpeg.skipped");
    send(stream.part);
  }

 private:
  void count(const std::string& what) override {
    all_.counters.add("mjpeg." + (what == "refused.no_http" ? "refused.request" : what));
  }

  void asked(const HttpRequest& request) override {
    if (request.method != "GET") return complete(refusal("request", 405, "only GET"));
    const std::string_view path = request.path;
    if (path == "/") return complete({.type = "text/html; charset=utf-8", .body = page_of(all_.streams)});
    std::string name(path.substr(std::min<std::size_t>(1, path.size())));
    glances_ = name.ends_with(".jpg") && !all_.streams.contains(name);
    if (glances_) name.resize(name.size() - 4);
    const auto stream = all_.streams.find(name);
    if (stream == all_.streams.end()) return complete(refusal("no_such_stream", 404, "no such stream; / lists them"));
    const bool fresh = stream->second.fresh();
    if (glances_ && fresh) return complete(stream->second.single());
    waits_for_ = name;
    notice_end();
    if (glances_) return answer_later(picture_within, [this] { return last(); });
    send(
        shared(fmt::format("HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary={0}\r\n"
                           "Cache-Control: no-store\r\nConnection: close\r\n\r\n--{0}\r\n{1}",
                           boundary, fresh ? *stream->second.part : "")));
  }

  HttpReply refusal(std::string_view why, unsigned status, std::string_view sentence) {
    all_.counters.add(fmt::format("mjpeg.refused.{}", why));
    return {.status = status, .type = "text/plain", .body = std::string(sentence) + "\n"};
  }

  // It waits for nothing more.
  void complete(HttpReply reply) {
    waits_for_.clear();
    answer(std::move(reply));
  }

  // Who waited for one picture and sees none come gets the last there was.
  HttpReply last() {
    const auto stream = all_.streams.find(std::exchange(waits_for_, {}));
    if (stream != all_.streams.end() && stream->second.jpeg) return stream->second.single();
    return refusal("no_picture", 503, "no picture has come yet");
  }

  void send(Bytes bytes) {
    out_ = std::move(bytes);
    const auto slowly = [this](Error error, std::size_t) -> std::size_t {
      if (error || has_left()) return 0;
      wait_for(limits.progress_within, "sent_away.takes_nothing");
      return out_->size();
    };
    boost::asio::async_write(stream_, boost::asio::buffer(*out_), slowly,
                             [this, self = shared_from_this()](Error error, std::size_t) {
                               if (has_left()) return;
                               if (error) return leave();
                               out_.reset();
                               timer_.cancel();
                             });
  }

  // Whatever a client says after its request is of no interest, but for its end; one that has all it will get may be
  // still and listen.
  void notice_end() {
    stream_.async_read_some(boost::asio::buffer(ignored_), [this, self = shared_from_this()](Error error, std::size_t) {
      if (has_left() || waits_for_.empty()) return;
      if (error) return leave();
      notice_end();
    });
  }

  Shared& all_;
  std::string waits_for_;  // a stream; empty: none
  bool glances_ = false;   // wants one picture, the next
  std::array<char, 512> ignored_;
  Bytes out_;  // in flight
};

}  // namespace

struct MjpegServer::State : Shared {
  State(EventLoop& loop, const std::string& address, std::uint16_t port)
      : server(listen_on(loop, address, port, "pictures"),
               [this](tcp::socket socket) { return take(std::move(socket)); }) {}

  std::shared_ptr<HttpConnection> take(tcp::socket socket) {
    const bool room = server.connections().size() < max_clients;
    counters.add(room ? "mjpeg.clients" : "mjpeg.refused.too_many");
    return room ? std::make_shared<Client>(std::move(socket), *this) : nullptr;
  }

  std::vector<std::shared_ptr<Client>> waiting_for(std::string_view stream) const {
    std::vector<std::shared_ptr<Client>> out;
    for (const auto& each : server.connections())
      if (auto client = std::static_pointer_cast<Client>(each); client->waits_for(stream)) out.push_back(client);
    return out;
  }

  HttpServer server;
};

MjpegServer::MjpegServer(EventLoop& loop, const std::string& address, std::uint16_t port)
    : state_(std::make_unique<State>(loop, address, port)) {}
MjpegServer::~MjpegServer() = default;

std::uint16_t MjpegServer::port() const {
  return state_->server.listening().port();
}
const Counters& MjpegServer::counters() const {
  return state_->counters;
}

void MjpegServer::announce(const std::string& stream) {
  state_->streams[stream];
}

void MjpegServer::show(const std::string& stream, std::span<const std::byte> jpeg) {
  const std::string_view bytes(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  Stream& entry = state_->streams[stream];
  entry.jpeg = shared(std::string(bytes));
  entry.part = shared(fmt::format("Content-Type: image/jpeg\r\nContent-Length: {}\r\n\r\n{}\r\n--{}\r\n", bytes.size(),
                                  bytes, boundary));
  entry.shown = Monotonic::now();
  for (const auto& client : state_->waiting_for(stream)) client->show(entry);
}

void MjpegServer::close(const std::string& stream) {
  if (state_->streams.erase(stream) == 0) return;
  for (const auto& client : state_->waiting_for(stream)) client->leave();
}

std::size_t MjpegServer::watchers(const std::string& stream) const {
  return state_->waiting_for(stream).size();
}

}  // namespace arkmesh::hal
