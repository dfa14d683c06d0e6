// Real bytes through the real libserialport into a pseudo-terminal, and through a socket.
#include "hal/platforms/kilobot/packet_port.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "hal/platforms/kilobot/descriptor_stream.hpp"
#include "tests/support/kilobot/listener.hpp"
#include "tests/support/kilobot/packet_ear.hpp"
#include "tests/support/processes/process.hpp"
#include "tests/support/processes/pseudo_terminal.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::kilobot;
using namespace arkmesh::tests;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::milliseconds deadline = 300s;

TimePoint now() {
  return std::chrono::steady_clock::now();
}

// A packet whose bytes differ from their neighbours, so that a lost or doubled byte shows; without header bytes, so
// that packets may follow each other directly.
Packet telling_packet(int number) {
  const auto page = static_cast<std::uint8_t>(number % 64);
  std::array<std::uint8_t, page_bytes> bytes;
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 37 + page) | 2;
  return boot_page_packet(page, bytes);
}

// Sends packets 0..count-1 through the line while `read` takes bytes at the other end, and wants them there whole and
// in order.
template <class Read>
void check_delivery(PacketPort& line, int count, Read read) {
  PacketEar ear;
  std::vector<Packet> heard;
  int sent = 0;
  CHECK(eventually(deadline, [&] {
    line.poll(now());
    if (sent < count && line.is_free()) line.send(telling_packet(sent++), now());
    for (const auto& packet : ear.hear(read())) heard.push_back(packet);
    return static_cast<int>(heard.size()) >= count;
  }));
  REQUIRE(static_cast<int>(heard.size()) == count);
  for (int i = 0; i < count; ++i) CHECK(heard[static_cast<std::size_t>(i)] == telling_packet(i));
}

std::unique_ptr<ByteStream> stream_to(const std::string& port) {
  return std::make_unique<DescriptorStream>(find_line(port));
}

std::string error_with(const std::string& port) {
  const auto stream = stream_to(port);
  stream->open();
  CHECK(stream->check() == ByteStream::State::closed);
  return stream->error();
}

void check_holds(const std::string& text, const std::string& part) {
  CAPTURE(text);
  CAPTURE(part);
  CHECK(text.find(part) != std::string::npos);
}

}  // namespace

TEST_CASE("serial device: settings and bytes") {
  // The device is set to 38400 baud, 8N1, raw, without flow control, and every byte value arrives as it was sent.
  PseudoTerminal terminal;
  hal::Counters counters;
  PacketPort line(stream_to(terminal.port()), counters);
  line.poll(now());
  REQUIRE(line.is_open());
  CHECK(line.error().empty());
  const termios settings = terminal.settings();
  CHECK(::cfgetospeed(&settings) == B38400);
  CHECK((settings.c_cflag & CSIZE) == CS8);
  CHECK((settings.c_cflag & (PARENB | CSTOPB | CRTSCTS)) == 0);
  CHECK((settings.c_iflag & (IXON | IXOFF)) == 0);
  CHECK((settings.c_oflag & OPOST) == 0);
  check_delivery(line, 20, [&] { return terminal.read(); });
}

TEST_CASE("serial device: partial writes") {
  // A device that takes bytes slowly gets whole packets in the end, and nothing blocks meanwhile.
  PseudoTerminal terminal;
  hal::Counters counters;
  PacketPort line(stream_to(terminal.port()), counters);
  line.poll(now());
  // until it takes no more: the last packet is cut somewhere
  int sent = 0;
  while (line.is_free()) {
    REQUIRE(sent < 10'000);
    line.send(telling_packet(sent++), now());
    line.poll(now());
  }
  CHECK(sent > 1);
  PacketEar ear;
  int heard = 0;
  CHECK(eventually(deadline, [&] {
    line.poll(now());
    for (const Packet& packet : ear.hear(terminal.read(77))) CHECK(packet == telling_packet(heard++));
    return heard == sent;
  }));
  CHECK(heard == sent);
  CHECK(line.is_free());
}

TEST_CASE("serial device: unplugged and plugged in again") {
  // A device that goes away is noticed and named, and opened again by its name when it is back.
  PseudoTerminal terminal;
  hal::Counters counters;
  PacketPort line(stream_to(terminal.port()), counters);
  line.poll(now());
  check_delivery(line, 3, [&] { return terminal.read(); });
  for (int times = 1; times <= 2; ++times) {
    terminal.unplug();
    CHECK(eventually(deadline, [&] { return line.poll(now()), !line.is_open(); }));
    CHECK_FALSE(line.is_free());
    check_holds(line.error(), "was unplugged");
    CHECK(eventually(
        deadline, [&] { return line.poll(now()), line.error().find("there is no serial port") != std::string::npos; }));
    terminal.plug();
    CHECK(eventually(deadline, [&] { return line.poll(now()), line.is_open(); }));
    check_delivery(line, 3, [&] { return terminal.read(); });
    CHECK(counters["overhead.port_lost"] == static_cast<std::uint64_t>(times));
    CHECK(counters["overhead.port_opened"] == static_cast<std::uint64_t>(times + 1));
  }
}

TEST_CASE("serial device: a device that talks") {
  // What comes from the device is thrown away, so that nothing piles up in the system.
  PseudoTerminal terminal;
  hal::Counters counters;
  PacketPort line(stream_to(terminal.port()), counters);
  line.poll(now());
  for (int i = 0; i < 50; ++i) {
    terminal.say(std::string(1000, 'x'));
    line.poll(now());
  }
  check_delivery(line, 3, [&] { return terminal.read(); });
}

TEST_CASE("serial device: what a device says is there for records until the next look") {
  // Proves that each look gives the bytes that came since the last one, and that a look without any gives none.
  PseudoTerminal terminal;
  Listener listener;
  for (const std::string& port : {terminal.port(), terminal.link(), listener.port()}) {
    CAPTURE(port);
    const bool tcp = port == listener.port();
    const auto stream = stream_to(port);
    stream->open();
    REQUIRE(eventually(deadline, [&] { return stream->check() == ByteStream::State::open; }));
    CHECK(stream->heard().empty());
    if (tcp)
      REQUIRE(eventually(deadline, [&] { return listener.say("hello"); }));
    else
      terminal.say("hello");
    std::string said;
    CHECK(eventually(deadline, [&] {
      stream->check();
      for (const std::uint8_t byte : stream->heard()) said += static_cast<char>(byte);
      return said.size() >= 5;
    }));
    CHECK(said == "hello");
    stream->check();
    CHECK(stream->heard().empty());
  }
}

TEST_CASE("serial device: for one program alone") {
  // A second user of the same device is told that it is in use.
  PseudoTerminal terminal;
  for (const std::string& port : {terminal.port(), terminal.link()}) {
    const auto first = stream_to(port);
    first->open();
    REQUIRE(first->check() == ByteStream::State::open);
    check_holds(error_with(terminal.port()), "in use by another program");
    check_holds(error_with(terminal.link()), "so end that one first");
  }
}

TEST_CASE("serial device: a pseudo-terminal by its own name") {
  // What socat or an emulated testbed offers is opened although libserialport knows no such terminals; bytes,
  // unplugging and plugging in work alike.
  PseudoTerminal terminal;
  hal::Counters counters;
  PacketPort line(stream_to(terminal.link()), counters);
  line.poll(now());
  check_delivery(line, 20, [&] { return terminal.read(); });
  CHECK((terminal.settings().c_oflag & OPOST) == 0);
  terminal.say(std::string(1000, 'x'));
  terminal.unplug();
  CHECK(eventually(
      deadline, [&] { return line.poll(now()), line.error().find("there is no serial port") != std::string::npos; }));
  terminal.plug();
  CHECK(eventually(deadline, [&] { return line.poll(now()), line.is_open(); }));
  check_delivery(line, 3, [&] { return terminal.read(); });
  CHECK(counters["overhead.port_lost"] == 1);
}

TEST_CASE("serial device: a pseudo-terminal is opened again by people who are not root") {
  // Each opening is for one program alone, and the next one finds the terminal free; its other end stays open.
  PseudoTerminal terminal;
  const std::string device = std::filesystem::canonical(terminal.link()).string();
  const bool root = ::geteuid() == 0;
  if (root) REQUIRE((::chmod(device.c_str(), 0666) == 0 && ::seteuid(65534) == 0));
  for (int i = 0; i < 3; ++i) {
    CAPTURE(i);
    const auto stream = stream_to(device);
    stream->open();
    CHECK(stream->check() == ByteStream::State::open);
    check_holds(error_with(device), "in use by another program");
  }
  if (root) REQUIRE(::seteuid(0) == 0);
}

TEST_CASE("serial device: what is no device") {
  // A port that does not exist, a file and a folder are named with what they are.
  check_holds(error_with("/dev/ttyNONE7"), "there is no serial port /dev/ttyNONE7");
  check_holds(error_with("ttyNONE7"), "there is no serial port /dev/ttyNONE7");
  check_holds(error_with("/etc/passwd"), "/etc/passwd is not a serial port");
  check_holds(error_with("/dev"), "is not a serial port");
  check_holds(error_with("/dev/null"), "is not a serial port");
  CHECK_THROWS_AS(find_line(""), PortError);
  CHECK_THROWS_AS(find_line("udp://here:1"), PortError);
}

TEST_CASE("serial device: no permission") {
  // Without the right to the device the group that has it and the command that joins it are named.
  PseudoTerminal terminal;
  const std::string device = std::filesystem::canonical(terminal.port()).string();
  REQUIRE(::chmod(device.c_str(), 0) == 0);
  if (::geteuid() == 0) {
    // root may open everything, so the question is asked as nobody
    REQUIRE(::seteuid(65534) == 0);
    const std::string said = error_with(device);
    REQUIRE(::seteuid(0) == 0);
    check_holds(said, "no permission to open " + device + ": it belongs to group ");
    check_holds(said, "sudo usermod -aG ");
  } else {
    check_holds(error_with(device), "sudo usermod -aG ");
  }
}

TEST_CASE("tcp: bytes") {
  // Packets arrive whole and in order at a TCP port, and its answers are thrown away.
  Listener listener;
  hal::Counters counters;
  PacketPort line(stream_to(listener.port()), counters);
  check_delivery(line, 30, [&] { return listener.read(); });
}

TEST_CASE("tcp: a connection that ends") {
  // A connection that was closed, and a port where nobody listens for a while, are named, and found again.
  Listener listener;
  hal::Counters counters;
  PacketPort line(stream_to(listener.port()), counters);
  check_delivery(line, 3, [&] { return listener.read(); });
  listener.hang_up();
  CHECK(eventually(deadline, [&] { return line.poll(now()), counters["overhead.port_lost"] == 1; }));
  CHECK(line.error() == listener.port() + ": the connection ended");
  check_delivery(line, 3, [&] { return listener.read(); });
  listener.stop();
  CHECK(eventually(deadline,
                   [&] { return line.poll(now()), line.error().find("nobody listens there") != std::string::npos; }));
  listener.listen_again();
  check_delivery(line, 3, [&] { return listener.read(); });
  CHECK(counters["overhead.port_opened"] == 3);
}

TEST_CASE("tcp: addresses") {
  // An address without a port, with a wrong one, or of an unknown host is refused with what is expected.
  for (const std::string port : {"tcp://", "tcp://host", "tcp://:1", "tcp://host:", "tcp://host:0", "tcp://host:65536",
                                 "tcp://host:12x", "tcp://host:99999999999"}) {
    CAPTURE(port);
    CHECK_THROWS_AS(find_line(port), PortError);
  }
  CHECK_THROWS_AS(find_line("tcp://no-such-host.invalid:3001"), PortError);
  CHECK_NOTHROW(find_line("tcp://[::1]:3001"));
}

TEST_CASE("a connection that is reset takes its bytes with it, and another is opened") {
  // The other end reads an error instead of the end; a device is not reset.
  Listener listener;
  PseudoTerminal terminal;
  hal::Counters counters;
  PacketPort line(stream_to(listener.port()), counters), device(stream_to(terminal.port()), counters);
  CHECK_FALSE(line.reset());
  device.poll(now());
  REQUIRE(device.is_open());
  CHECK_FALSE(device.reset());
  CHECK(device.is_open());
  REQUIRE(eventually(deadline, [&] { return line.poll(now()), line.is_open() && listener.say("x"); }));
  CHECK(line.reset());
  CHECK(eventually(deadline, [&] { return !listener.say("x"); }));
  check_holds(line.error(), "resets the connection");
  listener.hang_up();
  CHECK(eventually(deadline, [&] { return line.poll(now()), line.is_open() && line.openings() == 2; }));
  check_delivery(line, 3, [&] { return listener.read(); });
}
