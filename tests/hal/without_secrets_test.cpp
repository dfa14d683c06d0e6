// What of a text people may see.
#include "hal/config/without_secrets.hpp"

#include <doctest/doctest.h>

namespace arkmesh::hal {

TEST_CASE("user, password and query of an address are hidden, and nothing else") {
  // Proves it for lists of servers, cameras, sentences and words of a command line.
  CHECK(without_secrets("tls+nats://shark:se:cr@t@a.example.org:4222,roark:other@b.example.org") ==
        "tls+nats://a.example.org:4222,b.example.org");
  CHECK(without_secrets("nats://a.example.org, nats://u:p/w?d@127.0.0.1:4222") ==
        "nats://a.example.org, nats://127.0.0.1:4222");
  CHECK(without_secrets("rtsp://user:word@table:554/1@2") == "rtsp://table:554/1@2");
  CHECK(without_secrets("http://us@er:w@table") == "http://table");
  CHECK(without_secrets("http://table/video?user=a&pwd=b@c") == "http://table/video?...");
  CHECK(without_secrets("gateway.connect=nats://u:p@h:4222") == "gateway.connect=nats://h:4222");
  CHECK(without_secrets("a.toml:3: gateway.connect = \"nats://u:p@h\": must be\n\ta@b") ==
        "a.toml:3: gateway.connect = \"nats://h\": must be\n\ta@b");
  for (const char* plain : {"", "tls://shark.example.org:7444", "/dev/video0", "udpm://239.255.76.67:7701?ttl=0",
                            "a@b.org", "shark.toml:12: unknown key 'x'; did you mean 'y'?"})
    CHECK(without_secrets(plain) == plain);
}

}  // namespace arkmesh::hal
