// Messages out of LCM's datagrams, and what becomes of datagrams that nobody honest sends.
#include "hal/bus/datagram_assembler.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/support/network/lcm_datagrams.hpp"

using namespace std::chrono_literals;

namespace arkmesh::hal {
namespace {

using tests::fragment;
using tests::Fragment;
using tests::short_datagram;
using Source = DatagramAssembler::Source;

constexpr Source shark{0x0a000001, 4000}, roark{0x0a000002, 4000}, other_socket{0x0a000001, 4001};

struct Assembled {
  DatagramAssembler assembler;
  DatagramAssembler::TimePoint now{};

  explicit Assembled(const DatagramAssembler::Limits& limits = {}) : assembler(limits) {}

  // "channel=bytes" of the message that a datagram completes, else "".
  std::string add(const std::vector<std::byte>& datagram, const Source& from = shark) {
    const std::vector<std::byte> exact(datagram);  // so that the sanitizer sees a byte too far
    const auto message = assembler.add(from, exact, now);
    if (!message) return {};
    return std::string(message->channel) + "=" +
           std::string(reinterpret_cast<const char*>(message->bytes.data()), message->bytes.size());
  }
  std::uint64_t count(std::string_view name) const { return assembler.counters()[name]; }
};

TEST_CASE("datagrams: whole messages") {
  // One datagram is one message, an empty one too.
  Assembled a;
  CHECK(a.add(short_datagram("poses", "abc")) == "poses=abc");
  CHECK(a.add(short_datagram("poses", "")) == "poses=");
  CHECK(a.add(short_datagram(std::string(63, 'c'), "x")) == std::string(63, 'c') + "=x");
  CHECK(a.assembler.counters().all().empty());
}

TEST_CASE("datagrams: what is none of LCM's, or names no channel, is refused") {
  // Too short, another magic, a header cut short; a name too long, empty, without its zero, or with bytes that do harm
  // in a terminal.
  Assembled a;
  CHECK(a.add({}) == "");
  CHECK(a.add(std::vector<std::byte>(7)) == "");
  CHECK(a.add(std::vector<std::byte>(40)) == "");
  auto cut = fragment({.channel = "poses", .size = 10, .bytes = "0123456789"});
  cut.resize(19);
  CHECK(a.add(cut) == "");
  CHECK(a.count("refused.not_lcm") == 4);
  CHECK(a.add(short_datagram(std::string(64, 'c'), "x")) == "");
  CHECK(a.add(short_datagram("", "x")) == "");
  CHECK(a.add(short_datagram("po\x1bses", "x")) == "");
  CHECK(a.add(short_datagram("p\xc3\xb6", "x")) == "");
  auto endless = short_datagram("poses", "");
  endless.pop_back();
  CHECK(a.add(endless) == "");
  CHECK(a.add(fragment({.channel = "", .size = 10, .bytes = "01234"})) == "");
  CHECK(a.count("refused.bad_channel_name") == 6);
}

TEST_CASE("datagrams: fragments make a message in any order, each counted once") {
  // Also when they are repeated, and while another socket sends under the same sequence.
  const auto first = fragment({.channel = "poses", .size = 9, .offset = 0, .number = 0, .count = 3, .bytes = "abc"});
  const auto second = fragment({.size = 9, .offset = 3, .number = 1, .count = 3, .bytes = "def"});
  const auto third = fragment({.size = 9, .offset = 6, .number = 2, .count = 3, .bytes = "ghi"});
  for (const auto& order : std::vector<std::vector<const std::vector<std::byte>*>>{{&first, &second, &third},
                                                                                   {&third, &second, &first},
                                                                                   {&second, &third, &first},
                                                                                   {&third, &first, &second}}) {
    Assembled a;
    CHECK(a.add(*order[0]) == "");
    CHECK(a.add(*order[0]) == "");
    CHECK(a.add(*order[1], other_socket) == "");
    CHECK(a.add(*order[1]) == "");
    CHECK(a.add(*order[1]) == "");
    CHECK(a.add(*order[2]) == "poses=abcdefghi");
    CHECK(a.count("repeated.fragment") == 2);
    CHECK(a.assembler.unfinished() == 1);
    CHECK(a.assembler.counters().all().size() == 1);
  }
}

TEST_CASE("datagrams: fragments that do not fit their message are refused") {
  // Offsets near 2^32 do not wrap round, a message longer than allowed is never begun, and none of it takes memory.
  Assembled a;
  CHECK(a.add(fragment(
            {.size = 1000, .offset = 0xffffffff - 299, .number = 1, .count = 2, .bytes = std::string(301, 'x')})) ==
        "");
  CHECK(a.add(fragment({.size = 10, .offset = 5, .number = 1, .count = 2, .bytes = "123456"})) == "");
  CHECK(a.add(fragment({.size = 10, .offset = 5, .number = 2, .count = 2, .bytes = "1"})) == "");
  CHECK(a.add(fragment({.size = 10, .offset = 5, .number = 1, .count = 2, .bytes = ""})) == "");
  CHECK(a.add(fragment({.channel = "poses", .size = 0, .count = 1, .bytes = "1"})) == "");
  CHECK(a.count("refused.bad_fragment") == 5);
  CHECK(a.add(fragment({.channel = "poses", .size = 1 << 28, .count = 2, .bytes = "1"})) == "");
  CHECK(a.add(fragment({.channel = "poses", .size = 0xffffffff, .count = 2, .bytes = "1"})) == "");
  CHECK(a.count("refused.too_long") == 2);
  CHECK(a.assembler.held_bytes() == 0);
}

TEST_CASE("datagrams: fragments that overlap never leave a hole unseen") {
  // By their lengths alone the three would make nine bytes, but three of these never came.
  Assembled a;
  CHECK(a.add(fragment({.channel = "poses", .size = 9, .offset = 0, .number = 0, .count = 3, .bytes = "abcd"})) == "");
  CHECK(a.add(fragment({.size = 9, .offset = 2, .number = 1, .count = 3, .bytes = "cdef"})) == "");
  CHECK(a.count("refused.overlapping_fragments") == 1);
  CHECK(a.assembler.unfinished() == 0);
  // In pieces that never meet a message is given up.
  for (std::uint32_t i = 0; i < 65; ++i)
    CHECK(a.add(fragment({.size = 9000, .offset = 1 + 2 * i, .number = 1, .count = 2, .bytes = "x"})) == "");
  CHECK(a.count("refused.scattered_fragments") == 1);
  CHECK(a.assembler.unfinished() == 0);
}

TEST_CASE("datagrams: what stays unfinished is forgotten after its time") {
  // Counted from its first fragment; a fragment that comes later begins anew. A source that starts again with another
  // size under the same sequence begins anew, too.
  Assembled a;
  const auto first = fragment({.channel = "poses", .size = 6, .count = 2, .bytes = "abc"});
  const auto second = fragment({.size = 6, .offset = 3, .number = 1, .count = 2, .bytes = "def"});
  a.add(first);
  a.now += 499ms;
  CHECK(a.assembler.unfinished() == 1);
  CHECK(a.add(second) == "poses=abcdef");
  a.add(first);
  a.now += 500ms;
  CHECK(a.add(second) == "");
  CHECK(a.count("lost.fragments_missing") == 1);
  CHECK(a.add(fragment({.channel = "poses", .size = 4, .count = 2, .bytes = "ab"})) == "");
  CHECK(a.count("lost.fragments_missing") == 2);
  CHECK(a.add(fragment({.size = 4, .offset = 2, .number = 1, .count = 2, .bytes = "cd"})) == "poses=abcd");
  CHECK(a.assembler.held_bytes() == 0);
}

TEST_CASE("datagrams: what is unfinished is bounded, and the newest stays") {
  // In bytes per source and in all, and in number; a flood of beginnings hinders no message that comes at once.
  Assembled a({.bytes = 1000, .bytes_of_source = 600, .messages = 4, .patience = 500ms});
  const auto begin = [](std::uint32_t sequence, std::uint32_t size) {
    return fragment({.channel = "poses", .sequence = sequence, .size = size, .count = 2, .bytes = "a"});
  };
  a.add(begin(1, 300));
  a.add(begin(2, 300));
  a.add(begin(3, 300));  // the source's first goes
  CHECK(a.assembler.held_bytes() == 600);
  a.add(begin(1, 300), roark);
  CHECK(a.assembler.held_bytes() == 900);
  a.add(begin(2, 300), roark);  // the oldest of all goes
  CHECK(a.assembler.held_bytes() == 900);
  CHECK(a.count("dropped.too_many_unfinished") == 2);
  for (std::uint32_t sequence = 10; sequence < 100'000; ++sequence) a.add(begin(sequence, 10));
  CHECK(a.assembler.unfinished() == 4);
  const std::string rest(598, 'b');
  a.add(begin(1, 599), other_socket);
  CHECK(a.add(fragment({.sequence = 1, .size = 599, .offset = 1, .number = 1, .count = 2, .bytes = rest}),
              other_socket) == "poses=a" + rest);
}

}  // namespace
}  // namespace arkmesh::hal
