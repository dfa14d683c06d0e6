// A browser's side of a page's server, byte by byte, without waiting by itself: so that a test decides what is
// sent and read, and when.
#pragma once

#include <poll.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::tests {

// What a test does while it waits, so that the server goes on: serves its loop, or steps its labs.
using Serve = std::function<void()>;

// Until that is so; false after five minutes.
inline bool comes_to(const Serve& serve, const std::function<bool()>& condition,
                     std::chrono::milliseconds within = std::chrono::seconds(300)) {
  const auto until = std::chrono::steady_clock::now() + within;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > until) return false;
    serve();
  }
  return true;
}

inline Serve serving(boost::asio::io_context& loop) {
  return [&loop] {
    loop.restart();
    loop.run_for(std::chrono::milliseconds(2));
  };
}

class Browser {
 public:
  Browser(boost::asio::io_context& loop, std::uint16_t port) : Browser(serving(loop), port) {}
  Browser(Serve serve, std::uint16_t port) : serve_(std::move(serve)), port_(port) {
    socket_.connect({boost::asio::ip::make_address("127.0.0.1"), port});
    socket_.non_blocking(true);
  }
  Browser(const Browser&) = delete;

  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
  std::string origin() const { return "http://" + host(); }

  // Sends as much as is taken now; false when the connection is over.
  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      boost::system::error_code error;
      const std::size_t n = socket_.write_some(boost::asio::buffer(bytes.data(), bytes.size()), error);
      if (error == boost::asio::error::would_block) {
        if (!comes_to(serve_, [&] { return is_writable() || gone_; })) return false;
        continue;
      }
      if (error || gone_) return false;
      bytes.remove_prefix(n);
    }
    return true;
  }

  // A whole answer to a request, headers and body; empty when the connection ended before.
  std::string ask(std::string_view first_line, const std::map<std::string, std::string>& headers = {},
                  std::string_view body = {}) {
    std::map<std::string, std::string> all{{"Host", host()}};
    for (const auto& [name, value] : headers) all[name] = value;
    if (!body.empty()) all["Content-Length"] = std::to_string(body.size());
    std::string request = std::string(first_line) + " HTTP/1.1\r\n";
    for (const auto& [name, value] : all)
      if (!value.empty()) request += name + ": " + value + "\r\n";
    in_.clear();
    if (!send(request + "\r\n" + std::string(body))) return {};
    return heard_next();
  }
  // The answer to a request that was sent; as ask().
  std::string heard_next() {
    comes_to(serve_, [&] { return read(), is_answered() || gone_; });
    return is_answered() ? in_ : std::string();
  }
  bool has_answer() { return read(), is_answered(); }
  static int status(const std::string& answer) { return answer.size() < 12 ? 0 : std::stoi(answer.substr(9, 3)); }

  // The status of the answer; 101: it is a WebSocket now.
  int join(const std::map<std::string, std::string>& headers, const std::string& path = "/ws") {
    std::map<std::string, std::string> all{{"Upgrade", "websocket"},
                                           {"Connection", "Upgrade"},
                                           {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="},
                                           {"Sec-WebSocket-Version", "13"}};
    all.insert(headers.begin(), headers.end());
    const std::string answer = ask("GET " + path, all);
    if (status(answer) == 101) in_.erase(0, in_.find("\r\n\r\n") + 4);
    return status(answer);
  }
  int join() { return join({{"Origin", origin()}}); }

  // One WebSocket frame, masked as browsers do.
  static std::string framed(std::string_view payload, int opcode = 1) {
    std::string out(1, static_cast<char>(0x80 | opcode));
    if (payload.size() < 126) {
      out += static_cast<char>(0x80 | payload.size());
    } else {
      const int bytes = payload.size() < 65'536 ? 2 : 8;
      out += static_cast<char>(0x80 | (bytes == 2 ? 126 : 127));
      for (int i = bytes - 1; i >= 0; --i) out += static_cast<char>(payload.size() >> 8 * i & 255);
    }
    out += std::string(4, '\0');  // a mask that changes nothing
    return out += payload;
  }
  bool say(const nlohmann::json& what) { return send(framed(what.dump())); }

  struct Message {
    bool text = false;
    std::string bytes;
    int kind() const { return text || bytes.size() < 16 ? 0 : bytes[0]; }
    int lab() const { return static_cast<unsigned char>(bytes[1]); }
    std::uint32_t request() const { return static_cast<std::uint32_t>(number(4, 4)); }
    std::int64_t t_us() const { return static_cast<std::int64_t>(number(8, 8)); }
    std::string channel() const { return bytes.substr(16, static_cast<unsigned char>(bytes[2])); }
    std::string data() const { return bytes.substr(16 + static_cast<unsigned char>(bytes[2])); }

   private:
    std::uint64_t number(std::size_t at, std::size_t size) const {
      std::uint64_t out = 0;
      for (std::size_t i = 0; i < size; ++i) out |= std::uint64_t{static_cast<unsigned char>(bytes[at + i])} << 8 * i;
      return out;
    }
  };
  // All that has come since it joined.
  const std::vector<Message>& messages() {
    read();
    while (take_message()) continue;
    return messages_;
  }
  // The newest text message with that member; null when there is none.
  nlohmann::json said(const char* member) {
    nlohmann::json out;
    for (const Message& message : messages())
      if (message.text)
        if (auto json = nlohmann::json::parse(message.bytes); json.contains(member)) out = json[member];
    return out;
  }
  bool hears(const char* member) {
    return comes_to(serve_, [&] { return !said(member).is_null() || gone_; }) && !said(member).is_null();
  }
  // The server has ended the connection.
  bool is_gone() { return read(), gone_; }

 private:
  bool is_writable() {
    pollfd one{socket_.native_handle(), POLLOUT, 0};
    return ::poll(&one, 1, 0) > 0;
  }
  void read() {
    for (std::array<char, 65'536> some; !gone_;) {
      boost::system::error_code error;
      const std::size_t n = socket_.read_some(boost::asio::buffer(some), error);
      in_.append(some.data(), n);
      if (error == boost::asio::error::would_block) return;
      gone_ = gone_ || error;
    }
  }
  bool is_answered() const {
    const auto end = in_.find("\r\n\r\n");
    if (end == std::string::npos) return false;
    const auto length = in_.find("Content-Length: ");
    return length == std::string::npos || length > end || in_.size() >= end + 4 + std::stoul(in_.substr(length + 16));
  }
  bool take_message() {
    if (in_.size() < 2) return false;
    std::size_t begin = 2, size = static_cast<unsigned char>(in_[1]) & 127;
    if (size >= 126) {
      const std::size_t bytes = size == 126 ? 2 : 8;
      if (in_.size() < 2 + bytes) return false;
      size = 0;
      for (std::size_t i = 0; i < bytes; ++i) size = size << 8 | static_cast<unsigned char>(in_[2 + i]);
      begin += bytes;
    }
    if (in_.size() < begin + size) return false;
    const int opcode = in_[0] & 15;
    const std::string payload = in_.substr(begin, size);
    in_.erase(0, begin + size);
    if (opcode == 1 || opcode == 2) keep({opcode == 1, payload});
    if (opcode == 9) send(framed(payload, 10));  // a ping is answered, or the server takes the browser for dead
    return true;
  }

  // A bundle as what is in it.
  void keep(Message message) {
    if (message.text || !message.bytes.starts_with('\3')) return messages_.push_back(std::move(message));
    for (std::size_t at = 4; at + 4 <= message.bytes.size();) {
      std::size_t size = 0;
      for (int i = 3; i >= 0; --i)
        size = size << 8 | static_cast<unsigned char>(message.bytes[at + static_cast<std::size_t>(i)]);
      messages_.push_back({false, message.bytes.substr(at + 4, size)});
      at += 4 + size;
    }
  }

  Serve serve_;
  std::uint16_t port_;
  boost::asio::io_context own_loop_;  // runs nothing; sockets want one
  boost::asio::ip::tcp::socket socket_{own_loop_};
  std::string in_;
  std::vector<Message> messages_;
  bool gone_ = false;
};

}  // namespace arkmesh::tests
