// Pictures over HTTP: what a browser and OpenCV get, and what clients cannot do to the server.
#include "hal/http/mjpeg_server.hpp"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <thread>
#include <vector>

namespace {

// A server that works whenever the test lets its loop run.
struct Loop {
  arkmesh::hal::EventLoop loop;
};
struct MjpegServer : Loop, arkmesh::hal::MjpegServer {
  MjpegServer(const std::string& address, std::uint16_t port) : arkmesh::hal::MjpegServer(loop, address, port) {}
  void serve() { loop.poll(); }
};

// A client that does only what the test says; its descriptor never blocks.
class RawClient {
 public:
  explicit RawClient(std::uint16_t port) : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ::connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  ~RawClient() { ::close(fd_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;
  bool send(const std::string& text) {
    return ::send(fd_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  void no_more() { ::shutdown(fd_, SHUT_WR); }
  // Adds what has come; false at the connection's end.
  bool read() {
    std::array<char, 65536> some;
    const ssize_t n = ::recv(fd_, some.data(), some.size(), 0);
    if (n > 0) got.append(some.data(), static_cast<std::size_t>(n));
    return n > 0 || (n < 0 && (errno == EAGAIN || errno == EINPROGRESS || errno == ENOTCONN));
  }
  std::string got;

 private:
  int fd_;
};

// Serves until the condition holds; false after five minutes.
bool serve_until(MjpegServer& server, const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(300);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    server.serve();
    std::this_thread::yield();
  }
  return true;
}

std::vector<std::uint8_t> jpeg(int shade, int side = 64) {
  std::vector<std::uint8_t> out;
  cv::imencode(".jpg", cv::Mat(side, side, CV_8UC3, cv::Scalar::all(shade)), out);
  return out;
}

void show(MjpegServer& server, const std::string& stream, const std::vector<std::uint8_t>& bytes) {
  server.show(stream, std::as_bytes(std::span(bytes)));
}

std::string answer_to(MjpegServer& server, const std::string& request) {
  RawClient client(server.port());
  bool sent = false;
  serve_until(server, [&] {
    if (!sent) sent = client.send(request);
    return sent && !client.read();
  });
  return client.got;
}

}  // namespace

TEST_CASE("OpenCV opens a stream by its URL and sees the pictures in order") {
  // As any IP camera: shades grow from picture to picture, and so they must arrive.
  MjpegServer server("127.0.0.1", 0);
  show(server, "camera0", jpeg(20));
  std::vector<double> shades;
  bool opened = false, done = false;
  std::thread client([&] {
    cv::VideoCapture capture("http://127.0.0.1:" + std::to_string(server.port()) + "/camera0", cv::CAP_FFMPEG);
    opened = capture.isOpened();
    cv::Mat picture;
    while (opened && shades.size() < 10 && capture.read(picture)) shades.push_back(cv::mean(picture)[0]);
    done = true;
  });
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(300);
  for (int shade = 20; !done && std::chrono::steady_clock::now() < deadline;) {
    server.serve();
    if (server.watchers("camera0") > 0 && server.counters()["mjpeg.skipped"] == 0)
      show(server, "camera0", jpeg(shade = std::min(230, shade + 2)));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  server.close("camera0");
  client.join();
  CHECK(opened);
  REQUIRE(shades.size() == 10);
  for (std::size_t k = 1; k < shades.size(); ++k) CHECK(shades[k] >= shades[k - 1]);
  CHECK(shades.back() > shades.front());
}

TEST_CASE("a stream has its parts with their lengths, a single picture and a page") {
  // Byte for byte what was shown.
  MjpegServer server("127.0.0.1", 0);
  const auto picture = jpeg(100);
  show(server, "table", picture);
  const std::string bytes(picture.begin(), picture.end());
  const std::string single = answer_to(server, "GET /table.jpg HTTP/1.1\r\nHost: x\r\n\r\n");
  CHECK(single.starts_with("HTTP/1.1 200 OK\r\n"));
  CHECK(single.ends_with("\r\n\r\n" + bytes));
  const std::string page = answer_to(server, "GET / HTTP/1.0\r\n\r\n");
  CHECK(page.find("src=\"/table\"") != std::string::npos);

  RawClient watcher(server.port());
  bool sent = false;
  CHECK(serve_until(server, [&] {
    if (!sent) sent = watcher.send("GET /table?x=1 HTTP/1.1\r\n\r\n");
    watcher.read();
    return watcher.got.find(bytes) != std::string::npos && server.watchers("table") == 1;
  }));
  CHECK(watcher.got.find("multipart/x-mixed-replace; boundary=") != std::string::npos);
  CHECK(watcher.got.find("Content-Length: " + std::to_string(bytes.size()) + "\r\n\r\n" + bytes) != std::string::npos);
  server.close("table");
  CHECK(server.watchers("table") == 0);
  CHECK(serve_until(server, [&] { return !watcher.read(); }));
}

TEST_CASE("clients come to a stream of which nothing was shown yet, and have its first picture") {
  // As in a program that encodes pictures only while somebody watches: one client streams, one wants a single picture.
  MjpegServer server("127.0.0.1", 0);
  server.announce("table");
  RawClient watcher(server.port()), glancer(server.port());
  bool watcher_sent = false, glancer_sent = false;
  REQUIRE(serve_until(server, [&] {
    if (!watcher_sent) watcher_sent = watcher.send("GET /table HTTP/1.1\r\n\r\n");
    if (!glancer_sent) glancer_sent = glancer.send("GET /table.jpg HTTP/1.1\r\n\r\n");
    return server.watchers("table") == 2;
  }));
  const auto picture = jpeg(100);
  const std::string bytes(picture.begin(), picture.end());
  show(server, "table", picture);
  CHECK(serve_until(server, [&] { return !glancer.read(); }));
  CHECK(glancer.got.starts_with("HTTP/1.1 200 OK\r\n"));
  CHECK(glancer.got.ends_with("\r\n\r\n" + bytes));
  CHECK(serve_until(server, [&] {
    watcher.read();
    return watcher.got.find(bytes) != std::string::npos;
  }));
  CHECK(server.watchers("table") == 1);
  CHECK(answer_to(server, "GET / HTTP/1.0\r\n\r\n").find("src=\"/table\"") != std::string::npos);
}

TEST_CASE("who wants one picture of a stream without any is told so") {
  // After a few seconds, and not never.
  MjpegServer server("127.0.0.1", 0);
  server.announce("table");
  CHECK(answer_to(server, "GET /table.jpg HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 503"));
  CHECK(server.counters()["mjpeg.refused.no_picture"] == 1);
}

TEST_CASE("nonsense is answered and counted") {
  // No such stream, no such verb, a request without end, bytes of all kinds.
  MjpegServer server("127.0.0.1", 0);
  show(server, "table", jpeg(100));
  CHECK(answer_to(server, "GET /nothing HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 404"));
  CHECK(answer_to(server, "POST /table HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 405"));
  CHECK(answer_to(server, "GET\r\n\r\n").starts_with("HTTP/1.1 400"));
  CHECK(answer_to(server, "GET  \r\n\r\n").starts_with("HTTP/1.1 400"));
  CHECK(answer_to(server, std::string("\xff\xfe\r\n\r\n")).starts_with("HTTP/1.1 400"));
  answer_to(server, std::string(20'000, 'a'));
  CHECK(server.counters()["mjpeg.refused.request_too_long"] == 1);
  CHECK(server.counters()["mjpeg.refused.no_such_stream"] == 1);
  CHECK(server.counters()["mjpeg.refused.request"] == 4);
}

TEST_CASE("a client that takes nothing misses pictures and holds up nobody") {
  // It never reads; the other one gets every picture meanwhile.
  MjpegServer server("127.0.0.1", 0);
  const auto large = std::vector<std::uint8_t>(400'000, 7);
  show(server, "table", large);
  RawClient lazy(server.port()), eager(server.port());
  bool lazy_sent = false, eager_sent = false;
  REQUIRE(serve_until(server, [&] {
    if (!lazy_sent) lazy_sent = lazy.send("GET /table HTTP/1.1\r\n\r\n");
    if (!eager_sent) eager_sent = eager.send("GET /table HTTP/1.1\r\n\r\n");
    return server.watchers("table") == 2;
  }));
  for (int k = 0; k < 40; ++k) {
    const std::size_t before = eager.got.size();
    if (k > 0) show(server, "table", large);
    REQUIRE(serve_until(server, [&] {
      eager.read();
      return eager.got.size() >= before + large.size();
    }));
  }
  CHECK(server.counters()["mjpeg.skipped"] > 20);
  CHECK(server.watchers("table") == 2);
}

TEST_CASE("no more clients than there is room for") {
  // The 33rd is sent away; when one leaves there is room again.
  MjpegServer server("127.0.0.1", 0);
  show(server, "table", jpeg(100));
  std::vector<std::unique_ptr<RawClient>> clients;
  for (std::size_t k = 0; k < MjpegServer::max_clients + 5; ++k) {
    clients.push_back(std::make_unique<RawClient>(server.port()));
    REQUIRE(serve_until(server, [&] {
      return server.counters()["mjpeg.clients"] + server.counters()["mjpeg.refused.too_many"] == k + 1;
    }));
  }
  CHECK(server.counters()["mjpeg.clients"] == MjpegServer::max_clients);
  CHECK(server.counters()["mjpeg.refused.too_many"] == 5);
  clients.clear();
  CHECK(answer_to(server, "GET /table.jpg HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 200"));
}

TEST_CASE("a port that is taken, and an address that is none, are refused with a sentence") {
  // What to do stands in it.
  const MjpegServer first("127.0.0.1", 0);
  CHECK_THROWS_WITH_AS(MjpegServer("127.0.0.1", first.port()), doctest::Contains("is in use by another program"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(MjpegServer("nowhere", 0), doctest::Contains("is not an address"), std::runtime_error);
}
