// Videos and streams that are damaged, change on the way, or end the process that reads them.
#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/processes/temporary_directory.hpp"
#include "tracker/camera/jpeg_stream.hpp"
#include "tracker/camera/jpeg_video.hpp"
#include "tracker/camera/live_camera.hpp"
#include "tracker/camera/picture_child.hpp"
#include "tracker/camera/source.hpp"

namespace arkmesh::tests::damaged_pictures {

using namespace tracker;
using namespace std::chrono_literals;

namespace {

using Bytes = std::vector<std::uint8_t>;

cv::Mat grey(int level, cv::Size size = {64, 48}) {
  return cv::Mat(size, CV_8UC3, cv::Scalar::all(level));
}
Bytes jpeg_of(const cv::Mat& picture) {
  Bytes out;
  cv::imencode(".jpg", picture, out);
  return out;
}
// Of another format than those in colour.
Bytes grey_jpeg(int level) {
  return jpeg_of(cv::Mat(48, 64, CV_8UC1, cv::Scalar(level)));
}
// The first half of its pixels, with a proper end, which decoders fill up with grey.
Bytes early_end(Bytes jpeg) {
  jpeg.resize(jpeg.size() / 2);
  jpeg.insert(jpeg.end(), {0xFF, 0xD9});
  return jpeg;
}
Bytes noise(std::size_t size) {
  Bytes out(size);
  std::uint32_t state = 1;
  for (std::uint8_t& byte : out) byte = static_cast<std::uint8_t>((state = state * 1664525 + 1013904223) >> 24);
  return out;
}

cv::Mat noise_picture() {
  return cv::Mat(48, 64, CV_8UC3, noise(48 * 64 * 3).data()).clone();
}

void put(std::string& to, std::uint32_t number, int bytes = 4) {
  for (int i = 0; i < bytes; ++i) to += static_cast<char>(number >> 8 * i);
}
std::string chunk(const char* name, const std::string& data) {
  std::string out = name;
  put(out, static_cast<std::uint32_t>(data.size()));
  return out + data + (data.size() % 2 ? std::string(1, '\0') : "");
}
// An AVI of pictures as they are, ten a second.
std::string avi_of(const std::vector<Bytes>& pictures) {
  std::string main, head = "vidsMJPG", format, moved = "movi", index;
  for (const std::uint32_t n :
       {100'000u, 0u, 0u, 16u, static_cast<std::uint32_t>(pictures.size()), 0u, 1u, 100'000u, 64u, 48u, 0u, 0u, 0u, 0u})
    put(main, n);
  for (const std::uint32_t n : {0u, 0u, 0u, 1u, 10u, 0u, static_cast<std::uint32_t>(pictures.size()), 100'000u,
                                0xFFFFFFFFu, 0u, 0u, 64u | 48u << 16})
    put(head, n);
  for (const std::uint32_t n : {40u, 64u, 48u, 1u | 24u << 16}) put(format, n);
  format += "MJPG";
  for (const std::uint32_t n : {9216u, 0u, 0u, 0u, 0u}) put(format, n);
  for (const Bytes& picture : pictures) {
    index += "00dc";
    for (const std::size_t n : {std::size_t{16}, moved.size(), picture.size()})
      put(index, static_cast<std::uint32_t>(n));
    moved += chunk("00dc", std::string(picture.begin(), picture.end()));
  }
  const std::string heads =
      "hdrl" + chunk("avih", main) + chunk("LIST", "strl" + chunk("strh", head) + chunk("strf", format));
  return chunk("RIFF", "AVI " + chunk("LIST", heads) + chunk("LIST", moved) + chunk("idx1", index));
}

struct Watched {
  std::vector<int> levels;  // of each picture's first pixel; -1: damaged
  std::vector<std::int64_t> times_ms;
  std::string error;
};
Watched watch(const std::string& file) {
  Watched out;
  const auto recording = open_recording(file);
  while (const auto picture = recording->next()) {
    out.levels.push_back(picture->bgr.empty() ? -1 : picture->bgr.at<cv::Vec3b>(0, 0)[0]);
    out.times_ms.push_back(picture->stamp.count() / 1000);
  }
  out.error = recording->error();
  return out;
}

// Answers each connection on a port of its own with the same bytes, and holds it open or not.
class OddCamera {
 public:
  OddCamera(std::string says, bool holds)
      : says_(std::move(says)), holds_(holds), socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::bind(socket_, reinterpret_cast<sockaddr*>(&at), sizeof at) == 0);
    REQUIRE(::listen(socket_, 4) == 0);
    socklen_t length = sizeof at;
    ::getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &length);
    url = fmt::format("http://127.0.0.1:{}/cam", ntohs(at.sin_port));
    thread_ = std::thread([this] { serve(); });
  }
  ~OddCamera() {
    ends_ = true;
    ::shutdown(socket_, SHUT_RDWR);
    thread_.join();
    ::close(socket_);
    for (const int held : held_) ::close(held);
  }
  std::string url;

 private:
  void serve() {
    while (!ends_) {
      const int client = ::accept(socket_, nullptr, nullptr);
      if (client < 0) return;
      char asked[2048];
      static_cast<void>(::recv(client, asked, sizeof asked, 0));
      static_cast<void>(::send(client, says_.data(), says_.size(), MSG_NOSIGNAL));
      if (holds_)
        held_.push_back(client);
      else
        ::close(client);
    }
  }
  std::string says_;
  bool holds_;
  int socket_;
  std::atomic<bool> ends_ = false;
  std::vector<int> held_;
  std::thread thread_;
};

std::string multipart(const std::vector<Bytes>& pictures) {
  std::string out = "HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=frame\r\n\r\n";
  for (const Bytes& picture : pictures)
    out += "--frame\r\nContent-Type: image/jpeg\r\n\r\n" + std::string(picture.begin(), picture.end()) + "\r\n";
  return out;
}

bool soon(const std::function<bool()>& so) {
  for (const auto end = std::chrono::steady_clock::now() + 60s; std::chrono::steady_clock::now() < end;) {
    if (so()) return true;
    std::this_thread::sleep_for(5ms);
  }
  return false;
}

// What the camera says once it has been tried.
std::string fault(const std::string& url) {
  const auto feed = open_camera({.source = url});
  std::string error;
  soon([&] { return !(error = feed->error()).empty() && !error.starts_with("no picture has arrived yet"); });
  return error;
}

bool has(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("JPEGs are found between heads, padding and damage, in parts of any length") {
  // Proves that whole pictures come out as they went in, and that cut ones and what is none are counted.
  const Bytes first = jpeg_of(grey(10)), second = jpeg_of(grey(200));
  Bytes all{'-', '-', 'f', '\r', '\n'};
  const auto add = [&](const Bytes& bytes) { all.insert(all.end(), bytes.begin(), bytes.end()); };
  add(first);
  add(Bytes(first.begin(), first.begin() + static_cast<long>(first.size()) / 2));
  add(second);
  add(Bytes(5000, 'x'));
  add(first);
  add(Bytes(second.begin(), second.end() - 2));
  for (const std::size_t part : {std::size_t{1}, std::size_t{7}, all.size()}) {
    JpegStream stream;
    std::vector<Bytes> found;
    for (std::size_t at = 0; at < all.size(); at += part) {
      stream.add(std::span(all).subspan(at, std::min(part, all.size() - at)));
      while (auto jpeg = stream.next()) found.push_back(std::move(*jpeg));
    }
    stream.end();
    CHECK(found == std::vector<Bytes>{first, second, first});
    CHECK(stream.take_damaged() == 3);
  }
  CHECK(decode_jpeg(second).at<cv::Vec3b>(0, 0)[0] == 200);
  CHECK(decode_jpeg({}).empty());
  // as OpenCV does, whatever colours and order there are
  cv::Mat noise(61, 83, CV_8UC3);
  cv::randu(noise, 0, 255);
  for (const int channels : {1, 3})
    for (const int progressive : {0, 1}) {
      Bytes jpeg;
      cv::imencode(".jpg", channels == 1 ? noise.reshape(1) : noise, jpeg, {cv::IMWRITE_JPEG_PROGRESSIVE, progressive});
      CHECK(cv::norm(decode_jpeg(jpeg), cv::imdecode(jpeg, cv::IMREAD_COLOR), cv::NORM_INF) == 0);
      CHECK_FALSE(lacks_pixels(jpeg));
      const Bytes half = early_end(jpeg);
      CHECK(decode_jpeg(half).empty());
      CHECK(lacks_pixels(half));
      Bytes arithmetic = jpeg;  // so its head says, and any bytes decode to some pixels
      const Bytes head{0xFF, static_cast<std::uint8_t>(progressive ? 0xC2 : 0xC0)};
      std::search(arithmetic.begin(), arithmetic.end(), head.begin(), head.end())[1] = progressive ? 0xCA : 0xC9;
      CHECK(decode_jpeg(arithmetic).empty());
      CHECK(lacks_pixels(arithmetic));
      jpeg.insert(jpeg.end() - 2, 3, 0);  // as some cameras pad
      CHECK_FALSE(decode_jpeg(jpeg).empty());
    }
  Bytes huge = first;
  const std::vector<std::uint8_t> frame_head{0xFF, 0xC0};
  const auto at = std::search(huge.begin(), huge.end(), frame_head.begin(), frame_head.end());
  std::fill(at + 5, at + 9, std::uint8_t{0xFF});  // 65535 x 65535 pixels
  CHECK(decode_jpeg(huge).empty());
  // A picture's memory is used again, but not while somebody has it.
  const cv::Mat held = decode_jpeg(first), as_decoded = held.clone();
  std::vector<cv::Mat> more;
  for (int i = 0; i < 5; ++i) more.push_back(decode_jpeg(second));
  CHECK(cv::norm(held, as_decoded, cv::NORM_INF) == 0);
  more.clear();
  const std::uint8_t* const memory = decode_jpeg(second).data;
  CHECK(decode_jpeg(second).data == memory);
}

TEST_CASE("a video's damaged pictures are left out one by one, and those after them keep their times") {
  // Proves it for noise, cut pictures and one that the camera left out; a format that changes harms nothing.
  const TemporaryDirectory folder;
  Bytes cut = jpeg_of(grey(50));
  cut.resize(cut.size() / 2);
  const Bytes ended = early_end(jpeg_of(noise_picture()));
  const std::string file = folder.write(
      "odd.avi",
      avi_of({jpeg_of(grey(10)), noise(900), jpeg_of(grey(30)), grey_jpeg(40), cut, {}, grey_jpeg(70), ended}));
  const Watched all = watch(file);
  CHECK(all.levels == std::vector<int>{10, -1, 30, 40, -1, 70, -1});
  REQUIRE(all.times_ms.size() == 7);
  const std::string picture = folder.write("ended.jpg", std::string(ended.begin(), ended.end()));
  CHECK(watch(picture).levels == std::vector<int>{-1});
  CHECK(all.times_ms[2] == 200);
  CHECK(all.times_ms[3] == 300);
  CHECK(all.times_ms[5] == 600);
  CHECK(all.error.empty());
}

TEST_CASE("a video that is cut says how many pictures are missing") {
  // Proves that what its head tells and what came are compared.
  const TemporaryDirectory folder;
  std::string bytes = avi_of(std::vector<Bytes>(20, jpeg_of(grey(90))));
  const Watched all = watch(folder.write("cut.avi", bytes.substr(0, bytes.size() / 2)));
  CHECK(all.levels.size() < 12);
  CHECK(has(all.error, "more pictures that it does not contain: it is cut or damaged"));
}

TEST_CASE("a video of JPEGs that was written here is whole") {
  // Proves that each of 300 pictures comes back with all its pixels, at its time.
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "noise.avi").string();
  cv::Mat picture(48, 64, CV_8UC3);
  {
    JpegVideo video(file, picture.size(), 20);
    for (int i = 0; i < 300; ++i) {
      cv::theRNG().state = static_cast<std::uint64_t>(i) + 1;
      cv::randu(picture, 0, 255);
      video.write(picture);
    }
  }
  const auto recording = open_recording(file);
  CHECK(recording->pictures() == 300u);
  for (int i = 0; i < 300; ++i) {
    const auto read = recording->next();
    REQUIRE(read.has_value());
    REQUIRE(read->bgr.size() == picture.size());
    CHECK(read->stamp.count() == 50'000 * i);
  }
  CHECK_FALSE(recording->next().has_value());
  CHECK(recording->error().empty());
  CHECK_THROWS_WITH_AS(JpegVideo("/nowhere/video.avi", {64, 48}, 20), doctest::Contains("/nowhere/video.avi"),
                       std::runtime_error);
}

TEST_CASE("a video's pictures are as OpenCV decodes them") {
  // Proves that reading in a process of its own changes no pixel.
  const std::string file = std::string(ARKMESH_TEST_DATA) + "/kilobot-images/bodyguard_clip.mp4";
  // It forks, so it goes first: the decoder below starts threads, and a lock that one holds is never freed in the
  // child.
  const auto recording = open_recording(file);
  cv::VideoCapture known(file, cv::CAP_FFMPEG);
  int pictures = 0;
  for (cv::Mat bgr; known.read(bgr); ++pictures) {
    const auto picture = recording->next();
    REQUIRE(picture.has_value());
    REQUIRE(picture->bgr.size() == bgr.size());
    CHECK(cv::norm(picture->bgr, bgr, cv::NORM_INF) == 0);
    CHECK(std::abs(static_cast<double>(picture->stamp.count()) / 1000 - known.get(cv::CAP_PROP_POS_MSEC)) < 1);
  }
  CHECK(pictures == 242);
  CHECK_FALSE(recording->next().has_value());
  CHECK(recording->error().empty());
}

TEST_CASE("a process that reads pictures may die or hang") {
  // Proves that its death, and its silence, are one sentence for who waits for its pictures.
  const TemporaryDirectory folder;
  // more than a pipe holds, so that it cannot be done before
  const std::string file = folder.write("long.avi", avi_of(std::vector<Bytes>(400, jpeg_of(noise_picture()))));
  const auto never = [] { return false; };
  for (const int signal : {SIGKILL, SIGSTOP}) {
    PictureChild child({.path = file, .shown = "long.avi", .patience = signal == SIGKILL ? 60s : 1s});
    REQUIRE(child.next(never).record.kind == PictureRecord::Kind::opened);
    REQUIRE(!child.next(never).bgr.empty());
    child.process().signal(signal);
    PictureChild::Event event;
    int pictures = 0;
    do event = child.next(never);
    while (event.record.kind == PictureRecord::Kind::jpeg && ++pictures);
    CHECK(pictures < 399);
    CHECK(event.record.kind == PictureRecord::Kind::failed);
    CHECK(event.error == (signal == SIGKILL
                              ? "the decoder failed while reading long.avi; a damaged picture can cause that"
                              : "reading long.avi hung and was abandoned"));
  }
}

TEST_CASE("a stream's damaged pictures are counted and cost no connection") {
  // Proves that the others are used, and that pictures of another size are refused with a sentence, the camera's own
  // being used again as soon as they come.
  std::vector<Bytes> pictures;
  for (int i = 0; i < 12; ++i) pictures.push_back(i % 3 == 1 ? noise(4000) : jpeg_of(grey(10 * i)));
  pictures.insert(pictures.begin() + 3, early_end(jpeg_of(noise_picture())));
  pictures.push_back(jpeg_of(grey(200, {32, 48})));
  const OddCamera camera(multipart(pictures), true);
  const auto feed = open_camera({.source = camera.url});
  CHECK(soon([&] { return feed->counters()["camera.refused.changed"] > 0; }));
  CHECK(feed->counters()["camera.refused.damaged"] == 5);
  CHECK(feed->counters()["camera.skipped"] == 7);
  CHECK(feed->newest().at<cv::Vec3b>(0, 0)[0] == 110);
  CHECK(has(feed->error(), "now sends pictures of 32 x 48 pixels instead of 64 x 48"));
  CHECK(feed->faults() == std::vector<std::string>{feed->error()});
  CHECK(feed->faults().empty());
}

TEST_CASE("each fault of a camera on the network has its own sentence") {
  // Proves which one; nobody's password is in them.
  const std::string head = "HTTP/1.1 ", end = "Content-Length: 0\r\n\r\n";
  const auto said = [](const std::string& reply, bool holds = false) { return fault(OddCamera(reply, holds).url); };
  CHECK(has(fault("http://user:word@127.0.0.1:1/cam"), "nothing listens at http://127.0.0.1:1/cam"));
  CHECK(has(said(head + "404 Not Found\r\n" + end), "(404)"));
  CHECK(has(said(head + "401 No\r\nWWW-Authenticate: Basic realm=\"cam\"\r\n" + end), "(401)"));
  CHECK(has(said(head + "403 No\r\n" + end), "(403)"));
  CHECK(has(said(head + "500 No\r\n" + end), "(5xx)"));
  CHECK(has(said(head + "200 OK\r\nContent-Type: text/html\r\n\r\n<html></html>"), "is a web page"));
  CHECK(has(said("", true), "does not answer"));
  CHECK(has(said(head + "200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=f\r\n\r\n", true),
            "is connected and sends no pictures"));
  CHECK(has(said(head + "200 OK\r\nContent-Type: video/mp4\r\n\r\nthese are no pixels"), "no readable video"));
  CHECK(has(said(multipart({jpeg_of(grey(1))})), "has ended its stream"));
  const std::string damaged = said(multipart(std::vector<Bytes>(3, early_end(jpeg_of(noise_picture())))), true);
  CHECK_MESSAGE(has(damaged, "sends pictures, but none could be decoded"), damaged);
}

}  // namespace arkmesh::tests::damaged_pictures
