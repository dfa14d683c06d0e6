// The keys of [gateway]: defaults, every rule that a file can break, and addresses.
#include "gateway/config.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "gateway/address.hpp"
#include "gateway/links/links.hpp"

namespace arkmesh::gateway {
namespace {

const std::vector<std::string> both_labs = {"roark", "shark"};

GatewayConfig read(const std::string& keys, const std::vector<std::string>& shared_labs = both_labs) {
  const hal::Config config = hal::Config::from_text(keys, "shark.toml");
  GatewayConfig gateway = read_gateway_config(config.root().section("gateway"), "shark", shared_labs);
  config.refuse_unknown("gateway");
  return gateway;
}

TEST_CASE("defaults") {
  // A lab without [gateway] exports world and status, the newest each, and serves nobody.
  const GatewayConfig config = read("");
  REQUIRE(config.rules.all().size() == 4);
  CHECK(config.rules.all()[0].allow == "world");
  CHECK(config.rules.all()[0].delivery == Delivery::latest);
  CHECK(config.rules.all()[1].allow == "status");
  CHECK(config.outbox_bytes == 4 << 20);
  CHECK(config.max_message_bytes == 1 << 20);
  CHECK(config.peers.empty());
  CHECK(config.listen.empty());
}

TEST_CASE("every key is read") {
  // Channels keep their delivery, peers their order; a peer outside shared.labs is left out and named.
  const GatewayConfig config = read(R"(
    [gateway]
    listen = "127.0.0.1:7801"
    exports = ["world"]
    ordered = ["events", "log"]
    outbox_bytes = 2000000
    max_message_bytes = 100000
    [[gateway.peers]]
    lab = "roark"
    [[gateway.peers]]
    lab = "lynx"
    connect = "[::1]:7803"
    [[gateway.peers]]
    lab = "mole"
  )",
                                    {"lynx", "roark", "shark"});
  CHECK(config.listen == "127.0.0.1:7801");
  REQUIRE(config.rules.all().size() == 5);
  CHECK(config.rules.all()[1].allow == "events");
  CHECK(config.rules.all()[1].delivery == Delivery::ordered);
  CHECK(config.outbox_bytes == 2'000'000);
  CHECK(config.max_message_bytes == 100'000);
  REQUIRE(config.peers.size() == 2);
  CHECK(config.peers[0].lab == "roark");
  CHECK(config.peers[0].connect.empty());
  CHECK(config.peers[1].connect == "[::1]:7803");
  CHECK(config.ignored == std::vector<std::string>{"mole"});
}

TEST_CASE("a peer's address may say that it is TCP's") {
  // With and without its scheme the address is the same.
  for (const char* connect : {"127.0.0.1:7801", "tcp://127.0.0.1:7801"}) {
    CAPTURE(connect);
    const GatewayConfig config = read("[[gateway.peers]]\nlab = \"roark\"\nconnect = \"" + std::string(connect) + "\"");
    REQUIRE(config.peers.size() == 1);
    CHECK(config.peers[0].connect == connect);
    boost::asio::io_context io;
    Connections node(io, {.lab = "shark", .boot_id = 1});
    CHECK(make_link({io, node, "shark", 1, config}, config.peers[0])->peer() == "roark");
  }
}

TEST_CASE("a run's config.toml holds no password") {
  // It is published with the run. What the gateway uses has it.
  const hal::Config config = hal::Config::from_text(
      "[gateway]\nconnect = \"nats://shark:secret@127.0.0.1\"\n[[gateway.peers]]\nlab = \"roark\"\n"
      "connect = \"tls+nats://shark:secret@nats.example.org\"",
      "shark.toml");
  const GatewayConfig read = read_gateway_config(config.root().section("gateway"), "shark", {"shark", "roark"});
  CHECK(read.connect == "nats://shark:secret@127.0.0.1");
  const std::string written = config.effective();
  CHECK(written.find("secret") == std::string::npos);
  CHECK(written.find("tls+nats://nats.example.org") != std::string::npos);
}

TEST_CASE("rules come before the short forms") {
  // Their order is that of the file; each knows where it is written, and a default that it is written nowhere.
  const GatewayConfig config = read(R"([gateway]
exports = ["world"]
ordered = ["events"]
peers = [{lab = "roark", connect = "127.0.0.1:1"}]
rules = [{deny = "world", direction = "export", peers = ["roark"]},
  {allow = "cam_*", direction = "export", delivery = "ordered"},
  {allow = "tally", direction = "import"}]
)");
  std::vector<std::string> said;
  for (const ChannelRule& rule : config.rules.all())
    said.push_back(rule.key + " " + rule.pattern() + " " + (rule.direction == Direction::exports ? "to" : "from") +
                   " " + (rule.delivery == Delivery::ordered ? "all " : "") + rule.place);
  CHECK(said ==
        std::vector<std::string>{"gateway.rules[0] world to shark.toml:5", "gateway.rules[1] cam_* to all shark.toml:6",
                                 "gateway.rules[2] tally from shark.toml:7", "gateway.exports world to shark.toml:2",
                                 "gateway.ordered events to all shark.toml:3", "gateway.imports world from ",
                                 "gateway.imports status from "});
}

TEST_CASE("it listens only when somebody is to be accepted") {
  // The address is checked in any case, and used when a peer that takes part does not listen itself.
  const std::string listen = "[gateway]\nlisten = \"127.0.0.1:7802\"\n";
  CHECK(read(listen +
             "[[gateway.peers]]\nlab = \"roark\"\nconnect = \"127.0.0.1:7801\"\n[[gateway.peers]]\nlab = \"lynx\"")
            .listen.empty());
  CHECK_FALSE(read(listen + "[[gateway.peers]]\nlab = \"roark\"").listen.empty());
}

TEST_CASE("what a file may not say") {
  // One wrong file per rule; each error names file, line and key, and says what to do.
  const std::string peer = "[[gateway.peers]]\n", rule = "[[gateway.rules]]\n";
  const std::pair<std::string, std::string> table[] = {
      {"gateway.listen = \"0.0.0.0:7801\"", "shark.toml:1: gateway.listen = \"0.0.0.0:7801\": is not on this machine"},
      {"gateway.listen = \"7801\"", "must be HOST:PORT"},
      {"gateway.listen = 7801", "must be a text"},
      {"gateway.exports = [\"roark/world\"]", "'roark/world' cannot be exported"},
      {"gateway.exports = [\"" + std::string(48, 'c') + "\"]", "a channel's name has 1 to 47 printable characters"},
      {"gateway.exports = [\"world\", \"world\"]", "channel 'world' is listed twice"},
      {"gateway.ordered = [\"world\"]",
       "gateway.ordered = [ \"world\" ]: channel 'world' is listed twice in gateway.exports and gateway.ordered"},
      {"gateway.max_message_bytes = 100", "must be between 1024 and 67108864"},
      {"gateway.outbox_bytes = 1000000", "must be at least gateway.max_message_bytes = 1048576 and 17632 more"},
      {"gateway.lisen = \"127.0.0.1:7801\"", "unknown key 'gateway.lisen'; did you mean 'gateway.listen'?"},
      {peer + "lab = \"Roark\"", "gateway.peers[0].lab = \"Roark\": is not a lab name"},
      {peer + "lab = \"shark\"", "is this lab itself"},
      {peer + "lab = \"lynx\"\n" + peer + "lab = \"lynx\"", "gateway.peers[1].lab = \"lynx\": is listed twice"},
      {peer + "lab = \"roark\"", "has no `connect`, so gateway.listen must say where its connection is accepted"},
      {peer + "connect = \"127.0.0.1:7801\"", "gateway.peers[0].lab: is missing"},
      {peer + "lab = \"roark\"\nconnect = \"10.0.0.2:7801\"",
       "shark.toml:3: gateway.peers[0].connect = \"10.0.0.2:7801\": is not on this machine"},
      {peer + "lab = \"roark\"\nconnect = \"tcp://10.0.0.2:7801\"",
       "gateway.peers[0].connect = \"tcp://10.0.0.2:7801\": is not on this machine"},
      {peer + "lab = \"roark\"\nconnect = \"stomp://127.0.0.1:4222\"",
       "shark.toml:3: gateway.peers[0].connect = \"stomp://127.0.0.1:4222\": begins with 'stomp://', which is not a "
       "kind of link; there are: tcp://, tls://, nats://, tls+nats://"},
      {peer + "lab = \"roark\"\nconnect = \"nats://user@nats.example.org\"",
       "shark.toml:3: gateway.peers[0].connect = \"nats://nats.example.org\": must be [USER:PASSWORD@]HOST[:PORT], or "
       "several"},
      {"gateway.connect = \"nats://\"",
       "shark.toml:1: gateway.connect = \"nats://\": must be [USER:PASSWORD@]HOST[:PORT], or several"},
      {"gateway.connect = \"nats://a,,b\"",
       "gateway.connect = \"nats://a,,b\": must be [USER:PASSWORD@]HOST[:PORT], or several"},
      {"gateway.connect = \"nats.example.org\"",
       "must begin with nats:// or tls+nats://; one lab's address belongs in"},
      {"gateway.connect = \"tls://nats.example.org:4222\"", "must begin with nats:// or tls+nats://"},
      {"gateway.connect = \"nats://lab:secret@nats.example.org\"",
       "would send a password to nats.example.org:4222 unencrypted; use tls+nats://"},
      {"gateway.connect = [\"nats://a\"]", "gateway.connect = [ \"nats://a\" ]: must be a text"},
      {"gateway.encrypt = \"yes\"", "shark.toml:1: gateway.encrypt = \"yes\": must be true or false"},
      {"gateway.server_ca = 1", "shark.toml:1: gateway.server_ca = 1: must be a path"},
      {"gateway.credentials = true", "shark.toml:1: gateway.credentials = true: must be a path"},
      {"gateway.credential = \"a.creds\"", "unknown key 'gateway.credential'; did you mean 'gateway.credentials'?"},
      {"gateway.listen = \"tcp://127.0.0.1:7801\"", "is not on this machine"},
      {"gateway.listen = \"tls://roark.example.org:7444\"", "must be tls://ADDRESS:PORT"},
      {peer + "lab = \"roark\"\nconnect = \"tls://roark.example.org\"",
       "gateway.peers[0].connect = \"tls://roark.example.org\": must be HOST:PORT with a port from 1 to 65535"},
      {peer + "lab = \"lynx\"\nport = 7801", "unknown key 'gateway.peers[0].port'"},
      {rule + "direction = \"export\"", "shark.toml:1: gateway.rules[0]: has neither allow = \"CHANNEL\" nor deny"},
      {rule + "allow = \"a\"\ndeny = \"b\"\ndirection = \"export\"",
       "shark.toml:3: gateway.rules[0].deny = \"b\": cannot be combined with `allow`"},
      {rule + "allow = \"a\"",
       "gateway.rules[0].direction: is missing; it must be a text in quotes, such as \"export\""},
      {rule + "allow = \"a\"\ndirection = \"out\"", "must be one of \"export\", \"import\""},
      {rule + "deny = \"roark/world\"\ndirection = \"import\"",
       "shark.toml:2: gateway.rules[0].deny = \"roark/world\": is not a channel that can cross"},
      {rule + "deny = \"a\"\ndirection = \"export\"\ndelivery = \"ordered\"", "only to a rule that allows an export"},
      {rule + "allow = \"a\"\ndirection = \"import\"\ndelivery = \"ordered\"", "only to a rule that allows an export"},
      {rule + "allow = \"a\"\ndirection = \"import\"\nrate_hz = 0",
       "gateway.rules[0].rate_hz = 0: must be between 0.001 and"},
      {rule + "deny = \"a\"\ndirection = \"import\"\nrate_hz = 5", "does not apply to a rule that denies"},
      {rule + "allow = \"a\"\ndirection = \"import\"\nrename = \"b\"", "unknown key 'gateway.rules[0].rename'"},
      {rule + "allow = \"a\"\ndirection = \"export\"\npriority = \"high\"", "unknown key 'gateway.rules[0].priority'"},
      {peer + "lab = \"lynx\"\nimport_bytes_per_s = 0",
       "gateway.peers[0].import_bytes_per_s = 0: must be between 1 and"},
      {rule + "allow = \"a\"\ndirection = \"export\"\npeers = [\"lynx\"]",
       "shark.toml:4: gateway.rules[0].peers = [ \"lynx\" ]: lab lynx has no entry in gateway.peers"},
  };
  for (const auto& row : table) {
    const auto& [text, sentence] = row;
    CAPTURE(row.first);
    std::string said;
    try {
      read(text);
    } catch (const hal::ConfigError& error) {
      said = error.what();
    }
    CAPTURE(said);
    CHECK(said.starts_with("shark.toml:"));
    CHECK(said.find(sentence) != std::string::npos);
  }
}

TEST_CASE("a federation is where labs without an entry are met") {
  // All of shared.labs but this one; an entry without an address is met there, too, unless its lab connects to us.
  const std::string federation = "gateway.connect = \"tls+nats://a.example.org,b.example.org\"\n";
  const std::string roark = "[[gateway.peers]]\nlab = \"roark\"\nimport_rate_hz = 5\n";
  const std::vector<std::string> labs{"lynx", "roark", "shark"};
  const auto places = [](const GatewayConfig& config) {
    std::string text;
    for (const PeerConfig& peer : config.peers) text += peer.lab + " " + peer.connect + "; ";
    return text;
  };
  const std::string there = "tls+nats://a.example.org,b.example.org; ";
  CHECK(places(read(federation, labs)) == "lynx " + there + "roark " + there);
  CHECK(places(read(federation + roark, labs)) == "roark " + there + "lynx " + there);
  CHECK(places(read(federation + "gateway.listen = \"127.0.0.1:7801\"\n" + roark, labs)) == "roark ; lynx " + there);
  CHECK(places(read(federation + roark + "connect = \"127.0.0.1:7801\"", labs)) ==
        "roark 127.0.0.1:7801; lynx " + there);
  CHECK(places(read(federation, {"shark"})).empty());

  const GatewayConfig config = read(federation +
                                    "gateway.encrypt = true\ngateway.server_ca = \"ca.pem\"\n"
                                    "gateway.credentials = \"shark.creds\"");
  CHECK(config.needs_keys());
  CHECK(config.federation.encrypt);
  CHECK(config.federation.server_ca.filename() == "ca.pem");
  CHECK(config.federation.credentials.filename() == "shark.creds");
  CHECK_FALSE(read(federation).federation.encrypt);
  CHECK_FALSE(read("").needs_keys());
}

TEST_CASE("addresses of this machine and all others") {
  // The whole 127 network, ::1 and localhost with a port; nothing else, whatever it resolves to.
  for (const char* good : {"127.0.0.1:7801", "127.255.0.3:1", "localhost:7801", "[::1]:65535", "127.0.0.1:0"}) {
    CAPTURE(good);
    CHECK(why_not_loopback(good).empty());
  }
  CHECK(to_text(loopback_endpoint("localhost:7801")) == "127.0.0.1:7801");
  CHECK(to_text(loopback_endpoint("[::1]:7801")) == "[::1]:7801");
  for (const char* elsewhere : {"0.0.0.0:1", "10.1.2.3:7801", "128.0.0.1:80", "[::]:1", "[fe80::1]:1",
                                "shark.example.org:7801", "localhost.example.org:1", "[::ffff:10.0.0.1]:1"}) {
    CAPTURE(elsewhere);
    CHECK(why_not_loopback(elsewhere).find("is not on this machine") == 0);
  }
  for (const char* wrong : {"", ":", "7801", "127.0.0.1", "127.0.0.1:", ":7801", "127.0.0.1:65536", "127.0.0.1:-1",
                            "127.0.0.1:78x", "127.0.0.1: 80", "::1:7801", "[127.0.0.1]:80", "[]:80", "[::1:80"}) {
    CAPTURE(wrong);
    CHECK_FALSE(why_not_loopback(wrong).empty());
  }
  CHECK_THROWS_AS((void)loopback_endpoint("10.1.2.3:7801"), hal::ConfigError);
}

TEST_CASE("addresses over TLS may be anywhere") {
  // Names, numbers, bracketed numbers with colons; to listen numbers only.
  for (const char* good :
       {"roark.example.org:7444", "10.1.2.3:1", "[2001:db8::7]:65535", "lab_1:7444", "localhost:7"}) {
    CAPTURE(good);
    CHECK(why_no_host(good).empty());
    CHECK(to_text(read_host(good)) == good);
  }
  for (const char* wrong : {"", ":1", "roark", "roark:0", "roark:65536", "ro ark:1", "[roark]:1", "::1:7444", "a/b:1",
                            "roark\n:1", "tls://roark:1"}) {
    CAPTURE(wrong);
    CHECK_FALSE(why_no_host(wrong).empty());
  }
  for (const char* good : {"tls://0.0.0.0:7444", "tls://[::]:7444", "tls://localhost:0", "127.0.0.1:7801"}) {
    CAPTURE(good);
    CHECK(why_not_listenable(good).empty());
    CHECK(read_listen_address(good).tls == std::string_view(good).starts_with("tls"));
  }
  for (const char* wrong : {"0.0.0.0:7444", "tls://", "tls://roark:7444", "tls://0.0.0.0", "ssl://0.0.0.0:1"}) {
    CAPTURE(wrong);
    CHECK_FALSE(why_not_listenable(wrong).empty());
  }
}

TEST_CASE("keys are needed where something is TLS, and only there") {
  const std::string peer = "[[gateway.peers]]\nlab = \"roark\"\n";
  CHECK_FALSE(read(peer + "connect = \"127.0.0.1:7801\"").needs_keys());
  CHECK(read(peer + "connect = \"tls://roark.example.org:7444\"").needs_keys());
  CHECK(read("[gateway]\nlisten = \"tls://0.0.0.0:7444\"\n" + peer).needs_keys());
  CHECK_FALSE(
      read("[gateway]\nlisten = \"tls://0.0.0.0:7444\"\n" + peer + "connect = \"127.0.0.1:7801\"").needs_keys());
}

}  // namespace
}  // namespace arkmesh::gateway
