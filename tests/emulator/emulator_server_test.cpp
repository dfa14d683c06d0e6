// The emulator in real time: its cameras by URL, its controller by terminal and TCP, its control port.
#include "emulator/emulator_server.hpp"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <fcntl.h>
#include <linux/capability.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <thread>
#include <vector>

#include "tests/emulator/emulator_builder.hpp"
#include "tests/support/processes/temporary_directory.hpp"

using namespace arkmesh;
using namespace arkmesh::emulator;

namespace {

using hal::Handle;

Handle connect_to(std::uint16_t port) {
  Handle out(::socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  REQUIRE(::connect(out.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0);
  ::fcntl(out.get(), F_SETFL, O_NONBLOCK);
  return out;
}

// Lets the loop turn until the condition holds; false after `seconds`.
bool run_until(hal::EventLoop& loop, const std::function<bool()>& condition, int seconds = 300) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    loop.restart();  // it may have had nothing to do
    loop.run_one_for(std::chrono::milliseconds(2));
  }
  return true;
}

// While it lives this thread, and those that it starts, may not open what another one took with TIOCEXCL, nor what its
// mode forbids: root is as anybody else there.
class NoAdministrator {
 public:
  NoAdministrator() {
    REQUIRE(::syscall(SYS_capget, &header_, before_) == 0);
    __user_cap_data_struct without[2] = {before_[0], before_[1]};
    without[0].effective &= ~(1U << CAP_SYS_ADMIN | 1U << CAP_DAC_OVERRIDE);
    REQUIRE(::syscall(SYS_capset, &header_, without) == 0);
  }
  ~NoAdministrator() { ::syscall(SYS_capset, &header_, before_); }
  NoAdministrator(const NoAdministrator&) = delete;
  NoAdministrator& operator=(const NoAdministrator&) = delete;

 private:
  __user_cap_header_struct header_{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct before_[2] = {};
};

// What the control port answers.
std::string ask(hal::EventLoop& loop, const EmulatorServer& server, const std::string& line) {
  const Handle client = connect_to(server.control_port());
  std::string got;
  REQUIRE(::send(client.get(), line.data(), line.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(line.size()));
  run_until(loop, [&] {
    char some[4096];
    const ssize_t n = ::recv(client.get(), some, sizeof some, 0);
    if (n > 0) got.append(some, static_cast<std::size_t>(n));
    return n == 0 || got.ends_with('\n');
  });
  return got;
}

}  // namespace

TEST_CASE("in real time a host runs robots over the terminal and over TCP, unplugged and plugged in between") {
  // Packets written in one go arrive as a serial line would bring them; the terminal is another one after the
  // unplugging.
  const tests::TemporaryDirectory folder;
  const std::string link = (folder.path() / "ohc").string();
  Emulator emulator = TestEmulator{.robots = 2, .emulator = "ids = \"in_order\"\nohc_link = \"" + link + "\""}.make();
  EmulatorRecord record(emulator, (folder.path() / "truth.csv").string(), "");
  hal::EventLoop loop;
  EmulatorServer server(loop, emulator, record);
  // more than the line takes by then: it waits outside, and none is lost
  const std::vector<std::uint8_t> idle(10'000);
  std::size_t idled = 0;
  {
    const Handle host(::open(link.c_str(), O_WRONLY | O_NOCTTY | O_NONBLOCK));
    REQUIRE(host);
    REQUIRE(run_until(loop, [&] {
      const ssize_t n = ::write(host.get(), idle.data(), idle.size() - idled);
      if (n > 0) idled += static_cast<std::size_t>(n);
      return idled == idle.size() && emulator.now() > ms(2'050);
    }));
  }
  const std::string terminal = server.terminal();
  CHECK(std::filesystem::read_symlink(link) == terminal);
  const Packet run = make_packet(2, {}, 0x88), message = make_packet(2, {1}, 7);
  {
    const Handle host(::open(link.c_str(), O_WRONLY | O_NOCTTY));
    REQUIRE(host);
    REQUIRE(::write(host.get(), run.data(), run.size()) == static_cast<ssize_t>(run.size()));
    CHECK(run_until(loop, [&] { return led_of(emulator, 1) == hal::Led::red; }));
    CHECK(emulator.counters()["ohc.packets.forward"] == 1);
    CHECK(emulator.counters()["serial.bytes_lost.overflow"] == 0);
  }
  CHECK(ask(loop, server, "ohc unplug\n") == "ok\n");
  CHECK(run_until(loop, [&] { return server.terminal().empty(); }));
  CHECK_FALSE(std::filesystem::exists(std::filesystem::symlink_status(link)));
  CHECK(ask(loop, server, "ohc plug\n") == "ok\n");
  CHECK(run_until(loop, [&] { return !server.terminal().empty(); }));
  CHECK(std::filesystem::read_symlink(link) == server.terminal());

  const hal::LabTime plugged = emulator.now();
  CHECK(run_until(loop, [&] { return emulator.now() > plugged + ms(2'100); }));
  const Handle first = connect_to(server.ohc_port());
  REQUIRE(::send(first.get(), message.data(), message.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(message.size()));
  CHECK(run_until(loop, [&] { return led_of(emulator, 1) == hal::Led::white; }));
  // a second host is sent away, as from a port that is in use
  const Handle second = connect_to(server.ohc_port());
  CHECK(run_until(loop, [&] {
    char byte;
    return ::recv(second.get(), &byte, 1, 0) == 0;
  }));
  CHECK(run_until(loop, [&] { return server.counters()["serial.refused.in_use"] == 1; }));

  std::ifstream truth(folder.path() / "truth.csv");
  std::string header, row;
  std::getline(truth, header);
  CHECK(header == "time_s,robot,id,x_m,y_m,heading_rad,led,in_arena");
  int rows = 0;
  while (std::getline(truth, row)) ++rows;
  CHECK(rows >= 2 * 15 * 2);
}

TEST_CASE("bytes keep the time of their arrival while the emulator draws") {
  // The loop is away for longer than two packets are apart: what came meanwhile is handed over piece by piece, each
  // with its time. Nothing comes of a writer that does not stop but what the line will take: the rest stays with him.
  hal::EventLoop loop;
  std::vector<SerialReader::Chunk> chunks;
  std::size_t bytes = 0;
  SerialReader reader(loop, "127.0.0.1", 0, "", [&](SerialReader::Chunk chunk) {
    bytes += chunk.bytes.size();
    chunks.push_back(std::move(chunk));
  });
  const Handle host(::open(reader.terminal().c_str(), O_WRONLY | O_NOCTTY | O_NONBLOCK));
  REQUIRE(host);
  const Packet packet = make_packet(2, {}, 0x88);
  const auto begun = std::chrono::steady_clock::now();
  REQUIRE(::write(host.get(), packet.data(), packet.size()) == static_cast<ssize_t>(packet.size()));
  std::this_thread::sleep_for(
      std::chrono::seconds(2));  // drawing, for longer than a busy machine hands bytes over late
  const auto then = std::chrono::steady_clock::now();
  REQUIRE(::write(host.get(), packet.data(), packet.size()) == static_cast<ssize_t>(packet.size()));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const auto ended = std::chrono::steady_clock::now();
  CHECK(run_until(loop, [&] { return bytes == 2 * packet.size(); }));
  CHECK(chunks.front().at >= begun);
  CHECK(chunks.front().at < then);
  CHECK(chunks.back().at >= then);
  CHECK(chunks.back().at < ended);

  reader.done(bytes);
  bytes = 0;
  const std::vector<std::uint8_t> endless(1000, 0x55);
  const auto enough = std::chrono::steady_clock::now() + std::chrono::milliseconds(100);
  CHECK(run_until(loop, [&] {
    [[maybe_unused]] const ssize_t ignored = ::write(host.get(), endless.data(), endless.size());
    return bytes >= 4096 && std::chrono::steady_clock::now() > enough;
  }));
  CHECK(bytes < 4096 + 1024);
}

TEST_CASE("what a host has written is lost where it resets its connection, and the next host is let in") {
  // The reader holds what a line takes in a second; the rest waits in the connection, and goes with it.
  hal::EventLoop loop;
  std::size_t bytes = 0, resets = 0;
  SerialReader reader(loop, "127.0.0.1", 0, "", [&](const SerialReader::Chunk& chunk) {
    bytes += chunk.bytes.size();
    resets += chunk.bytes.empty();
  });
  Handle first = connect_to(reader.port());
  const std::vector<std::uint8_t> much(20'000, 0x55);
  REQUIRE(::write(first.get(), much.data(), much.size()) == 20'000);
  CHECK(run_until(loop, [&] { return bytes >= 4096; }));
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  REQUIRE(::setsockopt(first.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once) == 0);
  first = Handle();
  const Handle second = connect_to(reader.port());
  REQUIRE(::write(second.get(), much.data(), 100) == 100);
  CHECK(run_until(loop, [&] { return resets == 1; }));
  const std::size_t held = bytes;
  CHECK(held < 4096 + 1024);
  reader.done(held);
  CHECK(run_until(loop, [&] { return bytes == held + 100; }));
}

TEST_CASE("a terminal that a host took for itself is free when the host has gone, and not before") {
  // As with a serial line; what the host wrote last is read, too. Three hosts, one after the other, and each keeps the
  // terminal for longer than the emulator takes to look.
  const NoAdministrator nobody;
  hal::EventLoop loop;
  std::size_t bytes = 0;
  SerialReader reader(loop, "127.0.0.1", 0, "", [&](SerialReader::Chunk chunk) { bytes += chunk.bytes.size(); });
  const std::string path = reader.terminal();
  const auto open = [&path] { return Handle(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK)); };
  for (std::size_t turn = 1; turn <= 3; ++turn) {
    Handle host;
    CHECK(run_until(loop, [&] { return static_cast<bool>(host = open()); }));
    REQUIRE(host);
    REQUIRE(::ioctl(host.get(), TIOCEXCL) == 0);
    const auto later = std::chrono::steady_clock::now() + std::chrono::milliseconds(250);
    CHECK(run_until(loop, [&] { return std::chrono::steady_clock::now() > later; }));
    CHECK_FALSE(open());
    REQUIRE(::write(host.get(), "abc", 3) == 3);
    host = Handle();
    CHECK(run_until(loop, [&] { return bytes == 3 * turn; }));
  }
}

TEST_CASE("OpenCV opens an emulator's camera, loses it while it is gone, and opens it again") {
  // The picture is the emulator's own; a camera that is gone ends its stream and is not found.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  EmulatorRecord record(emulator, "", "");
  hal::EventLoop loop;
  EmulatorServer server(loop, emulator, record);
  REQUIRE(run_until(loop, [&] { return emulator.now() > ms(100); }));
  const std::string url = server.url(0);
  for (int turn = 0; turn < 2; ++turn) {
    std::atomic<int> pictures = 0, ended = 0;
    cv::Mat last;
    std::thread viewer([&] {
      cv::VideoCapture capture(url, cv::CAP_FFMPEG);
      cv::Mat picture;
      while (capture.isOpened() && capture.read(picture)) {
        if (++pictures == 8) picture.copyTo(last);
      }
      ended = 1;
    });
    CHECK(run_until(loop, [&] { return pictures >= 8 || ended; }));
    CHECK(ask(loop, server, "camera camera0 gone\n") == "ok\n");
    CHECK(run_until(loop, [&] { return ended == 1; }));
    viewer.join();
    REQUIRE(pictures >= 8);
    CHECK(last.cols == 320);
    CHECK(ask(loop, server, "camera camera0 ok\n") == "ok\n");
    cv::Mat own;
    REQUIRE(emulator.picture(0, own));
    CHECK(cv::norm(own, last, cv::NORM_L1) / static_cast<double>(own.total() * 3) < 4);
    CHECK(run_until(loop, [&] { return server.pictures().counters()["mjpeg.clients"] > 0; }));
    const hal::LabTime back = emulator.now();
    CHECK(run_until(loop, [&] { return emulator.now() > back + ms(500); }));
  }
}

TEST_CASE("the control port answers line by line, and sends away who never ends a line") {
  // Two lines in one packet, two answers; 2 kB without an end are too much.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  EmulatorRecord record(emulator, "", "");
  hal::EventLoop loop;
  EmulatorServer server(loop, emulator, record);
  CHECK(ask(loop, server, "bogus\n").starts_with("error: "));
  const Handle client = connect_to(server.control_port());
  const std::string two = "robot 0 take\r\nrobot 0 put 0 0 0\r\n";
  REQUIRE(::send(client.get(), two.data(), two.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(two.size()));
  std::string got;
  CHECK(run_until(loop, [&] {
    char some[256];
    const ssize_t n = ::recv(client.get(), some, sizeof some, 0);
    if (n > 0) got.append(some, static_cast<std::size_t>(n));
    return got == "ok\nok\n";
  }));
  CHECK(emulator.truth()[0].seen.pose.x_m == 0);
  const std::string endless(2'000, 'x');
  const Handle rude = connect_to(server.control_port());
  CHECK(run_until(loop, [&] {
    ::send(rude.get(), endless.data(), endless.size(), MSG_NOSIGNAL);
    char byte;
    const ssize_t n = ::recv(rude.get(), &byte, 1, 0);
    return n == 0 || (n < 0 && errno == ECONNRESET);
  }));
}

TEST_CASE("the control port takes no commands from a browser") {
  // A web page may post any text to a port of this machine: of that no line is a command, and the connection ends with
  // a sentence, however the request comes in pieces.
  Emulator emulator = TestEmulator{.robots = 2}.make();
  EmulatorRecord record(emulator, "", "");
  hal::EventLoop loop;
  EmulatorServer server(loop, emulator, record);
  const std::string head = "Host: 127.0.0.1\r\nContent-Type: text/plain\r\nContent-Length: 30\r\n\r\n",
                    command = "\nrobot 0 take\nohc unplug\n";
  std::uint64_t refused = 0;
  for (const std::string& request : {"POST / HTTP/1.1\r\n" + head + command, "GET /x HTTP/1.0\n" + head + command,
                                     "OPTIONS * HTTP/2.0\r\n" + command, std::string("POST / HTTP/1.1\r\n")}) {
    CAPTURE(request);
    const Handle browser = connect_to(server.control_port());
    std::string got;
    for (const std::string& piece : {request.substr(0, 9), request.substr(9), command}) {
      ::send(browser.get(), piece.data(), piece.size(), MSG_NOSIGNAL);
      run_until(loop, [&, turns = 0]() mutable { return ++turns > 20; });
    }
    CHECK(run_until(loop, [&] {
      char some[256];
      const ssize_t n = ::recv(browser.get(), some, sizeof some, 0);
      if (n > 0) got.append(some, static_cast<std::size_t>(n));
      return n == 0 || (n < 0 && errno == ECONNRESET);
    }));
    CHECK(got.starts_with("error: this port accepts no HTTP"));
    CHECK(std::count(got.begin(), got.end(), '\n') == 1);
    CHECK(server.counters()["control.refused.http"] == ++refused);
  }
  CHECK(emulator.truth()[0].seen.in_arena);
  CHECK(emulator.ohc_plugged());
  CHECK(ask(loop, server, "robot 0 take\n") == "ok\n");  // who is none goes on as before
}

TEST_CASE("bytes that wait for the line when the controller is unplugged are counted") {
  Emulator emulator = TestEmulator{.robots = 2}.make();
  EmulatorRecord record(emulator, "", "");
  hal::EventLoop loop;
  EmulatorServer server(loop, emulator, record);
  const std::string bytes(60'000, 'x');  // 15 s of the line
  // On a busy machine what is to wait behind the full port comes late, so each attempt waits longer.
  for (int turns = 1; turns < 5000 && server.counters()["serial.bytes_lost.cut_off"] == 0; turns *= 2) {
    CHECK(ask(loop, server, "ohc plug\n") == "ok\n");
    const Handle host = connect_to(server.ohc_port());
    REQUIRE(::send(host.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT) > 0);
    int full = 0;
    CHECK(run_until(loop, [&] { return emulator.serial_free() == 0 && ++full >= turns; }));
    CHECK(ask(loop, server, "ohc unplug\n") == "ok\n");
  }
  CHECK(server.counters()["serial.bytes_lost.cut_off"] > 0);
}

TEST_CASE("the control port serves eight at once, and counts who is sent away") {
  Emulator emulator = TestEmulator{.robots = 2}.make();
  EmulatorRecord record(emulator, "", "");
  hal::EventLoop loop;
  EmulatorServer server(loop, emulator, record);
  std::vector<Handle> clients;
  for (int i = 0; i < 10; ++i) clients.push_back(connect_to(server.control_port()));
  CHECK(run_until(loop, [&] { return server.counters()["control.refused.too_many"] == 2; }));
}

TEST_CASE("a taken port, a link that is a file and a video without a folder are refused with a sentence") {
  // Each names what it is about.
  const tests::TemporaryDirectory folder;
  Emulator emulator = TestEmulator{.robots = 2}.make();
  EmulatorRecord record(emulator, "", "");
  hal::EventLoop loop;
  const EmulatorServer first(loop, emulator, record);
  Emulator other = TestEmulator{.robots = 2, .emulator = fmt::format("[emulator.scene]\ntexture = 0.0")}.make();
  CHECK_THROWS_WITH_AS(SerialReader(loop, "127.0.0.1", first.ohc_port(), "", {}),
                       doctest::Contains("is in use by another program"), std::runtime_error);
  const std::string file = folder.write("occupied", "text").string();
  CHECK_THROWS_WITH_AS(SerialReader(loop, "127.0.0.1", 0, file, {}), doctest::Contains("not a symbolic link"),
                       std::runtime_error);
  CHECK(std::filesystem::exists(file));
  CHECK_THROWS_WITH_AS(EmulatorRecord(emulator, "/nowhere/truth.csv", ""), doctest::Contains("/nowhere/truth.csv"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(EmulatorRecord(emulator, "", "/nowhere/video.mp4"), doctest::Contains("/nowhere/video.mp4"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(EmulatorRecord(emulator, "", "video.txt"), doctest::Contains(".avi or .mp4"),
                       std::runtime_error);
}

TEST_CASE("calibration and chessboards are written for every camera") {
  // The file holds what the renderer uses; pictures have the cameras' size.
  const tests::TemporaryDirectory folder;
  Emulator emulator = TestEmulator{.robots = 2,
                                   .cameras =
                                       "[[emulator.camera]]\nname = \"a\"\nwidth_px = 320\nheight_px = 240\nz_m = 0.8\n"
                                       "distortion = [-0.1, 0.01, 0.001, 0.002, 0.0]\n"
                                       "[[emulator.camera]]\nname = \"b\"\nwidth_px = 400\nheight_px = 300\nx_m = "
                                       "0.2\nlook_x_m = 0.1\nz_m = 0.9"}
                          .make();
  const std::string file = (folder.path() / "emulator.yaml").string();
  write_calibration(emulator, file);
  const cv::FileStorage read(file, cv::FileStorage::READ);
  REQUIRE(read.isOpened());
  REQUIRE(read["cameras"].size() == 2);
  cv::Mat matrix, rotation, translation;
  std::vector<double> distortion;
  read["cameras"][1]["camera_matrix"] >> matrix;
  read["cameras"][1]["rotation"] >> rotation;
  read["cameras"][1]["translation"] >> translation;
  read["cameras"][0]["distortion_coefficients"] >> distortion;
  CHECK(static_cast<std::string>(read["cameras"][1]["name"]) == "b");
  CHECK(static_cast<int>(read["cameras"][1]["image_width"]) == 400);
  CHECK(static_cast<double>(read["cameras"][1]["arena_height_m"]) == 0.4);
  REQUIRE(distortion.size() == 5);
  CHECK(distortion[3] == 0.002);
  // and landmarks of the empty arena
  CHECK(read["cameras"][0]["landmarks"].size() >= 8);
  // a point goes through these numbers to where the camera shows it
  const cv::Mat at = matrix * (rotation * (cv::Mat_<double>(3, 1) << 0.1, -0.1, 0) + translation);
  const cv::Point2d expected = *emulator.camera(1).model().project(0.1, -0.1, 0);
  CHECK(at.at<double>(0) / at.at<double>(2) == doctest::Approx(expected.x));
  CHECK(at.at<double>(1) / at.at<double>(2) == doctest::Approx(expected.y));
  write_chessboards(emulator, 2, (folder.path() / "boards").string());
  for (const char* const name : {"a-00.png", "a-01.png", "b-00.png", "b-01.png"})
    CHECK(std::filesystem::exists(folder.path() / "boards" / name));
  CHECK_THROWS_WITH_AS(write_calibration(emulator, "/nowhere/x.yaml"), doctest::Contains("/nowhere/x.yaml"),
                       std::runtime_error);
}

TEST_CASE("a video keeps time while a camera is gone") {
  // Ten pictures, three of them missing: ten frames.
  const tests::TemporaryDirectory folder;
  Emulator emulator = TestEmulator{.robots = 2}.make();
  const std::string file = (folder.path() / "emulator.avi").string();
  {
    EmulatorRecord record(emulator, "", file);
    cv::Mat picture;
    for (int k = 0; k < 10; ++k) {
      if (k == 4) CHECK(emulator.command("camera camera0 gone") == "ok");
      if (k == 7) CHECK(emulator.command("camera camera0 ok") == "ok");
      emulator.advance_to(k * emulator.config().frame_period);
      record.add_picture(0, emulator.picture(0, picture) ? picture : cv::Mat());
    }
  }
  cv::VideoCapture video(file, cv::CAP_FFMPEG);
  REQUIRE(video.isOpened());
  int frames = 0;
  for (cv::Mat picture; video.read(picture);) ++frames;
  CHECK(frames == 10);
  CHECK(video.get(cv::CAP_PROP_FPS) == doctest::Approx(15).epsilon(0.01));
}
