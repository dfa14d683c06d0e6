// The hello: what is read, and when two gateways refuse each other.
#include "gateway/frame/hello.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <string>

#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/world_t.hpp"

namespace arkmesh::gateway {
namespace {

Hello hello_of(const std::string& lab) {
  Hello hello;
  hello.lab = lab;
  hello.software = "1.2.3";
  hello.experiment = "dhtf";
  hello.boot_id = 0x0102030405060708;
  hello.max_message_bytes = 1 << 20;
  hello.channels = {exported("world"), exported("status"), exported("events")};
  return hello;
}

TEST_CASE("a hello comes back as it was") {
  // Every field survives the way over the network.
  const auto read = read_hello(encode_hello(hello_of("shark")));
  REQUIRE(read.has_value());
  CHECK(read->version == protocol_version);
  CHECK(read->lab == "shark");
  CHECK(read->software == "1.2.3");
  CHECK(read->experiment == "dhtf");
  CHECK(read->boot_id == 0x0102030405060708);
  CHECK(read->max_message_bytes == 1 << 20);
  REQUIRE(read->channels.size() == 3);
  CHECK(read->channels[0].name == "world");
  CHECK(read->channels[0].type == static_cast<std::uint64_t>(world_t::getHash()));
  CHECK(read->channels[1].type == static_cast<std::uint64_t>(lab_status_t::getHash()));
  CHECK(read->channels[2].type == 0);
}

TEST_CASE("the largest hello fits its limit") {
  // A configuration with as many and as long channel names as are allowed can still introduce itself.
  Hello hello = hello_of("fifteen-letters");
  hello.software = hello.experiment = std::string(63, 'x');
  hello.channels.clear();
  for (std::size_t i = 0; i < max_hello_channels; ++i)
    hello.channels.push_back({std::to_string(1000 + i) + std::string(43, 'c'), 1});
  CHECK(encode_hello(hello).size() <= max_hello_bytes);
  CHECK(read_hello(encode_hello(hello)).has_value());
}

TEST_CASE("what is no hello is not read") {
  // Every truncation, every surplus byte, wrong magic, illegal names and a missing boot id.
  const auto good = encode_hello(hello_of("shark"));
  for (std::size_t size = 0; size < good.size(); ++size)
    CHECK_FALSE(read_hello(std::span(good).first(size)).has_value());
  auto longer = good;
  longer.push_back(std::byte{0});
  CHECK_FALSE(read_hello(longer).has_value());
  for (std::size_t i = 0; i < 8; ++i) {
    auto bad = good;
    bad[i] ^= std::byte{1};
    CHECK_FALSE(read_hello(bad).has_value());
  }
  for (const char* lab : {"", "Shark", "two words", "sixteen-letters-", "a/b"})
    CHECK_FALSE(read_hello(encode_hello(hello_of(lab))).has_value());
  for (const char* channel : {"", "a/b", "tab\t"}) {
    Hello hello = hello_of("shark");
    hello.channels.push_back({channel, 0});
    CHECK_FALSE(read_hello(encode_hello(hello)).has_value());
  }
  for (const std::string& text : {std::string("\x1b[2J"), std::string("a\nb"), std::string(64, 'x')}) {
    Hello software = hello_of("shark"), experiment = software;
    software.software = experiment.experiment = text;
    CHECK_FALSE(read_hello(encode_hello(software)).has_value());
    CHECK_FALSE(read_hello(encode_hello(experiment)).has_value());
  }
  Hello twice = hello_of("shark");
  twice.channels.push_back({"world", 5});
  CHECK_FALSE(read_hello(encode_hello(twice)).has_value());
  Hello many = hello_of("shark");
  for (std::size_t i = many.channels.size(); i <= max_hello_channels; ++i)
    many.channels.push_back({std::to_string(i), 0});
  CHECK_FALSE(read_hello(encode_hello(many)).has_value());
  Hello no_boot = hello_of("shark");
  no_boot.boot_id = 0;
  CHECK_FALSE(read_hello(encode_hello(no_boot)).has_value());
  // A count of channels that are not there.
  Hello none = hello_of("shark");
  none.channels.clear();
  auto forged = encode_hello(none);
  forged[forged.size() - 1] = std::byte{0xff};
  forged[forged.size() - 2] = std::byte{0xff};
  CHECK_FALSE(read_hello(forged).has_value());
}

TEST_CASE("a list of channels by itself is read as strictly") {
  // Whole, with nothing behind it, each name once.
  const std::vector<ExportedChannel> channels{{"world", 5}, {"cam_*", 0}};
  auto bytes = encode_channels(channels);
  const auto read = read_channels(bytes);
  REQUIRE(read.has_value());
  REQUIRE(read->size() == 2);
  CHECK((*read)[1].name == "cam_*");
  CHECK((*read)[0].type == 5);
  CHECK(read_channels(encode_channels({})).has_value());
  for (std::size_t size = 0; size < bytes.size(); ++size) CHECK_FALSE(read_channels(std::span(bytes).first(size)));
  bytes.push_back(std::byte{0});
  CHECK_FALSE(read_channels(bytes));
  CHECK_FALSE(read_channels(encode_channels({{"a", 0}, {"a", 1}})));
  CHECK_FALSE(read_channels(encode_channels({{"a/b", 0}})));
}

TEST_CASE("of another version only version and lab are read") {
  // What a later version may have changed is not looked at.
  Hello later = hello_of("roark");
  later.version = 7;
  auto bytes = encode_hello(later);
  bytes.resize(8 + 2 + 1 + 5);
  bytes.push_back(std::byte{42});
  const auto read = read_hello(bytes);
  REQUIRE(read.has_value());
  CHECK(read->version == 7);
  CHECK(read->lab == "roark");
}

TEST_CASE("who refuses whom") {
  // Another version, another experiment or another type of a common channel is refused in words that name both; all
  // else is accepted.
  const Hello shark = hello_of("shark");
  CHECK_FALSE(why_refused(shark, hello_of("roark")).has_value());

  Hello other = hello_of("roark");
  other.version = 1;
  CHECK(why_refused(shark, other)->counter == "session.refused.version");
  CHECK(why_refused(shark, other)->sentence ==
        fmt::format("lab roark speaks protocol version 1, lab shark version {}; install the same arkmesh in both",
                    protocol_version));
  CHECK(why_refused(other, shark)->sentence ==
        fmt::format("lab shark speaks protocol version {}, lab roark version 1; install the same arkmesh in both",
                    protocol_version));

  other = hello_of("roark");
  other.experiment = "cre";
  CHECK(why_refused(shark, other)->counter == "session.refused.experiment");
  CHECK(why_refused(shark, other)->sentence ==
        "gateway of roark belongs to experiment 'cre', this one to 'dhtf'; end that gateway, or set shared.experiment "
        "alike");
  CHECK(why_refused(other, shark)->sentence.starts_with("gateway of shark belongs to experiment 'dhtf'"));

  // The text of another arkmesh is no reason.
  other = hello_of("roark");
  other.software = "7.0";
  CHECK_FALSE(why_refused(shark, other).has_value());

  other.channels[0].type = 0xabc;
  CHECK(why_refused(shark, other)->counter == "session.refused.message_type");
  CHECK(why_refused(shark, other)
            ->sentence.find("messages on channel world have another type in lab roark (0000000000000abc)") == 0);
  CHECK(why_refused(other, shark).has_value());

  // A type that one side does not know, and channels that only one side has, are no reason.
  other.channels[0].type = 0;
  CHECK_FALSE(why_refused(shark, other).has_value());
  other.channels.erase(other.channels.begin());
  other.channels.push_back({"more", 5});
  CHECK_FALSE(why_refused(shark, other).has_value());
}

}  // namespace
}  // namespace arkmesh::gateway
