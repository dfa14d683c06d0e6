// Callbacks on the loop. All pictures in flight are shared: a client holds a reference to one of them at most.
#include "hal/mjpeg_server.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_static_buffer.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "hal/listen.hpp"

namespace arkmesh::hal {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::asio::ip::tcp;
using Monotonic = std::chrono::steady_clock;
using Bytes = std::shared_ptr<const std::string>;
using Error = boost::system::error_code;

constexpr std::size_t max_request_bytes = 4096;
constexpr std::chrono::seconds request_within{5}, progress_within{10};
constexpr std::chrono::seconds fresh_for{1},
    picture_within{5};  // an older picture is shown only when no newer one comes
constexpr std::chrono::milliseconds accept_again_after{100};
constexpr std::string_view boundary = "arkmeshpicture";

Bytes shared(std::string bytes) {
  return std::make_shared<const std::string>(std::move(bytes));
}

http::response<http::string_body> answer(http::status status, std::string_view type, std::string body) {
  http::response<http::string_body> out(status, 11, std::move(body));
  out.set(http::field::content_type, {type.data(), type.size()});
  out.set(http::field::cache_control, "no-store");
  out.keep_alive(false);
  return out;
}

template <class Message>
std::string in_bytes(const Message& message) {
  std::ostringstream out;
  out << message;
  return std::move(out).str();
}

// With its length: nothing comes after it.
Bytes complete(http::status status, std::string_view type, std::string body) {
  auto message = answer(status, type, std::move(body));
  message.prepare_payload();
  return shared(in_bytes(message));
}

Bytes plain(http::status status, std::string_view sentence) {
  return complete(status, "text/plain", std::string(sentence) + "\n");
}

// A picture in two forms: by itself, and as one part of a stream with what separates it from the next. Neither: none
// has been shown.
struct Stream {
  Bytes jpeg, part;
  Monotonic::time_point shown;
  bool fresh() const { return jpeg && Monotonic::now() - shown < fresh_for; }
  Bytes single() const { return complete(http::status::ok, "image/jpeg", *jpeg); }
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

class Client;

// What all clients of a server share.
struct Shared {
  std::set<std::shared_ptr<Client>> clients;
  Streams streams;
  Counters counters;
};

// One connection. The loop keeps it while something is on its way; it does nothing more once it has left.
class Client : public std::enable_shared_from_this<Client> {
 public:
  Client(tcp::socket socket, Shared& shared)
      : socket_(std::move(socket)), timer_(socket_.get_executor()), all_(&shared) {
    ::fcntl(socket_.native_handle(), F_SETFD, FD_CLOEXEC);
    Error ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
  }

  void ask() {
    parser_.header_limit(max_request_bytes);
    wait_for(request_within);
    http::async_read_header(socket_, buffer_, parser_, [self = shared_from_this()](Error error, std::size_t) {
      if (self->all_) self->asked(error);
    });
  }

  // The server is no more, the client has gone, or it is done.
  void leave() {
    if (!all_) return;
    Shared& all = *std::exchange(all_, nullptr);
    Error ignored;
    socket_.close(ignored);
    timer_.cancel();
    all.clients.erase(shared_from_this());
  }

  bool waits_for(std::string_view stream) const {
    return stream_ == stream && (stage_ == Stage::watching || stage_ == Stage::glancing);
  }

  // A new picture of the stream that it waits for.
  void show(const Stream& stream) {
    if (stage_ == Stage::glancing) return leave_with(stream.single());
    if (out_) return all_->counters.add("mjpeg.skipped");
    send(stream.part);
  }

 private:
  // glancing: wants one picture, the next; leaving: as soon as everything is sent
  enum class Stage { asking, watching, glancing, leaving };

  void asked(Error error) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow) {
      all_->counters.add("mjpeg.refused.request_too_long");
      return leave_with(plain(http::status::request_header_fields_too_large, "request too long"));
    }
    const bool ended = error == http::error::end_of_stream || error == http::error::partial_message;
    if (!ended && error.category() == Error(http::error::bad_method).category())
      return refuse("request", http::status::bad_request, "no HTTP request");
    if (error) return leave();
    if (parser_.get().method() != http::verb::get)
      return refuse("request", http::status::method_not_allowed, "only GET");
    answer_to({parser_.get().target().data(), parser_.get().target().size()});
  }

  void answer_to(std::string_view path) {
    path = path.substr(0, path.find('?'));
    if (path == "/") return leave_with(complete(http::status::ok, "text/html; charset=utf-8", page_of(all_->streams)));
    std::string name(path.substr(std::min<std::size_t>(1, path.size())));
    const bool single = name.ends_with(".jpg") && !all_->streams.contains(name);
    if (single) name.resize(name.size() - 4);
    const auto stream = all_->streams.find(name);
    if (stream == all_->streams.end())
      return refuse("no_such_stream", http::status::not_found, "no such stream; / lists them");
    const bool fresh = stream->second.fresh();
    if (single && fresh) return leave_with(stream->second.single());
    stage_ = single ? Stage::glancing : Stage::watching;
    stream_ = name;
    notice_end();
    if (single) return wait_for(picture_within);
    const std::string type = fmt::format("multipart/x-mixed-replace; boundary={}", boundary);
    send(shared(fmt::format("{}--{}\r\n{}", in_bytes(answer(http::status::ok, type, "")), boundary,
                            fresh ? *stream->second.part : "")));
  }

  void refuse(std::string_view why, http::status status, std::string_view sentence) {
    all_->counters.add(fmt::format("mjpeg.refused.{}", why));
    leave_with(plain(status, sentence));
  }

  void leave_with(Bytes bytes) {
    stage_ = Stage::leaving;
    send(std::move(bytes));
  }

  void send(Bytes bytes) {
    out_ = std::move(bytes);
    sent_ = 0;
    send_some();
  }

  void send_some() {
    wait_for(progress_within);
    socket_.async_write_some(asio::buffer(out_->data() + sent_, out_->size() - sent_),
                             [self = shared_from_this()](Error error, std::size_t n) {
                               if (self->all_) self->took(error, n);
                             });
  }

  void took(Error error, std::size_t n) {
    if (error) return leave();
    sent_ += n;
    if (sent_ < out_->size()) return send_some();
    out_.reset();
    timer_.cancel();
    if (stage_ == Stage::leaving) leave();
  }

  // Whatever a client says after its request is of no interest, but for its end; one that has all it will get may be
  // still and listen.
  void notice_end() {
    socket_.async_read_some(asio::buffer(ignored_), [self = shared_from_this()](Error error, std::size_t) {
      if (!self->all_ || self->stage_ == Stage::leaving) return;
      if (error) return self->leave();
      self->notice_end();
    });
  }

  void wait_for(std::chrono::seconds time) {
    timer_.expires_after(time);
    timer_.async_wait([self = shared_from_this()](Error error) {
      // one that was set anew meanwhile may have been on its way already
      if (!error && self->all_ && self->timer_.expiry() <= Monotonic::now()) self->waited();
    });
  }

  void waited() {
    if (stage_ == Stage::asking) {
      all_->counters.add("mjpeg.sent_away.no_request");
      return leave();
    }
    if (out_) {
      all_->counters.add("mjpeg.sent_away.takes_nothing");
      return leave();
    }
    if (stage_ != Stage::glancing) return;
    // Who waited for one picture and sees none come gets the last there was.
    const auto stream = all_->streams.find(stream_);
    if (stream != all_->streams.end() && stream->second.jpeg) return leave_with(stream->second.single());
    refuse("no_picture", http::status::service_unavailable, "no picture has come yet");
  }

  tcp::socket socket_;
  asio::steady_timer timer_;
  Shared* all_;  // null: it has left
  Stage stage_ = Stage::asking;
  beast::flat_static_buffer<max_request_bytes> buffer_;
  http::request_parser<http::empty_body> parser_;
  std::array<char, 512> ignored_;
  std::string stream_;
  Bytes out_;  // in flight
  std::size_t sent_ = 0;
};

}  // namespace

struct MjpegServer::State : std::enable_shared_from_this<State> {
  State(EventLoop& loop, const std::string& address, std::uint16_t wanted)
      : acceptor(listen_on(loop, address, wanted, "pictures")), again(loop), port(acceptor.local_endpoint().port()) {}

  void accept() {
    acceptor.async_accept([weak = weak_from_this()](Error error, tcp::socket socket) {
      const auto self = weak.lock();
      if (!self || error == asio::error::operation_aborted) return;
      if (error) return self->accept_later();
      // those who have left make room for those who come
      if (self->all.clients.size() >= max_clients)
        asio::post(self->acceptor.get_executor(), [weak, socket = std::move(socket)]() mutable {
          if (const auto later = weak.lock()) later->take(std::move(socket));
        });
      else
        self->take(std::move(socket));
    });
  }

  void take(tcp::socket socket) {
    if (all.clients.size() >= max_clients) {
      all.counters.add("mjpeg.refused.too_many");
    } else {
      all.counters.add("mjpeg.clients");
      (*all.clients.insert(std::make_shared<Client>(std::move(socket), all)).first)->ask();
    }
    accept();
  }

  // Without a file descriptor to spare, say.
  void accept_later() {
    again.expires_after(accept_again_after);
    again.async_wait([weak = weak_from_this()](Error error) {
      if (const auto self = weak.lock(); self && !error) self->accept();
    });
  }

  void leave_all(const std::function<bool(const Client&)>& which) {
    for (const auto clients = all.clients; const auto& client : clients)
      if (which(*client)) client->leave();
  }

  tcp::acceptor acceptor;
  asio::steady_timer again;
  std::uint16_t port;
  Shared all;
};

MjpegServer::MjpegServer(EventLoop& loop, const std::string& address, std::uint16_t port)
    : state_(std::make_shared<State>(loop, address, port)) {
  state_->accept();
}
MjpegServer::~MjpegServer() {
  state_->leave_all([](const Client&) { return true; });
}

std::uint16_t MjpegServer::port() const {
  return state_->port;
}
const Counters& MjpegServer::counters() const {
  return state_->all.counters;
}

void MjpegServer::announce(const std::string& stream) {
  state_->all.streams[stream];
}

void MjpegServer::show(const std::string& stream, std::span<const std::byte> jpeg) {
  const std::string_view bytes(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  Stream& entry = state_->all.streams[stream];
  entry.jpeg = shared(std::string(bytes));
  entry.part = shared(fmt::format("Content-Type: image/jpeg\r\nContent-Length: {}\r\n\r\n{}\r\n--{}\r\n", bytes.size(),
                                  bytes, boundary));
  entry.shown = Monotonic::now();
  for (const auto& client : state_->all.clients)
    if (client->waits_for(stream)) client->show(entry);
}

void MjpegServer::close(const std::string& stream) {
  if (state_->all.streams.erase(stream) == 0) return;
  state_->leave_all([&](const Client& client) { return client.waits_for(stream); });
}

std::size_t MjpegServer::watchers(const std::string& stream) const {
  const auto& clients = state_->all.clients;
  return static_cast<std::size_t>(
      std::ranges::count_if(clients, [&](const auto& client) { return client->waits_for(stream); }));
}

}  // namespace arkmesh::hal
