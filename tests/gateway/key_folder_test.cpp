// What `arkmesh keys` does to its folder, and what it refuses.
#include "gateway/links/key_folder.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <filesystem>
#include <functional>
#include <string>

#include "hal/config/config.hpp"
#include "tests/support/network/test_keys.hpp"

namespace arkmesh::gateway {
namespace {

using namespace tests;
namespace fs = std::filesystem;

std::string keys_refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const hal::ConfigError& error) {
    return error.what();
  }
  return "nothing was refused";
}

mode_t mode_of(const fs::path& file) {
  struct stat facts {};
  REQUIRE(::stat(file.c_str(), &facts) == 0);
  return facts.st_mode & 07777;
}

TEST_CASE("a lab's key is made once and belongs to its user alone") {
  // Whatever the umask: 0600 for the key; ten years; a key that others can read is refused, in one sentence that mends
  // it.
  const TemporaryDirectory folder;
  const KeyFolder keys(folder.path() / "keys");
  const mode_t before = ::umask(0);
  const Certificate made = keys.init("roark");
  ::umask(before);
  CHECK(made.lab == "roark");
  CHECK(mode_of(keys.path() / "roark.key") == 0600);
  CHECK(made.until > std::chrono::system_clock::now() + std::chrono::days(3649));
  CHECK(keys.own("roark").certificate.pin == made.pin);
  CHECK(keys_refusal([&] { keys.init("roark"); }).find("has a key in") != std::string::npos);
  CHECK(keys_refusal([&] { keys.init("../roark"); }).find("is not a lab name") != std::string::npos);
  CHECK(keys_refusal([&] { keys.own("shark"); }).find("arkmesh keys init shark") != std::string::npos);
  for (const mode_t mode : {0640, 0604, 0620, 0644}) {
    REQUIRE(::chmod((keys.path() / "roark.key").c_str(), mode) == 0);
    CHECK(keys_refusal([&] { keys.own("roark"); }).find("chmod 600") != std::string::npos);
  }
}

TEST_CASE("a fingerprint is 25 digits of the key, and stays when the certificate is renewed") {
  const TestKeys labs;
  const KeyFolder keys = labs.of("roark");
  const std::string digits = fingerprint(keys.own("roark").certificate.pin);
  CHECK(digits.size() == 29);
  CHECK(digits.find_first_not_of("0123456789 ") == std::string::npos);
  labs.date("roark", std::chrono::system_clock::now() - std::chrono::days(3640));
  CHECK(keys.own("roark").certificate.until < std::chrono::system_clock::now() + std::chrono::days(11));
  const Certificate renewed = keys.renew("roark", false);
  CHECK(renewed.until > std::chrono::system_clock::now() + std::chrono::days(3649));
  CHECK(fingerprint(renewed.pin) == digits);
  CHECK(fingerprint(keys.renew("roark", true).pin) != digits);
}

TEST_CASE("who is trusted, revoked, and trusted again") {
  // A second certificate of a name, and a revoked one, get in on request only.
  const TestKeys labs;
  const KeyFolder keys = labs.of("shark");
  const fs::path roark = labs.of("roark").certificate_file("roark");
  const Certificate first = keys.trust(roark, false);
  keys.trust(roark, false);  // again is no error
  labs.of("roark").renew("roark", true);
  const std::string why = keys_refusal([&] { keys.trust(roark, false); });
  CHECK(why.find("another certificate of lab roark is already trusted") == 0);
  CHECK(why.find(fingerprint(first.pin)) != std::string::npos);
  const Certificate second = keys.trust(roark, true);
  REQUIRE(keys.list().trusted.size() == 1);
  CHECK(keys.list().trusted[0].pin == second.pin);

  CHECK(keys.revoke("roark").pin == second.pin);
  CHECK(keys.list().trusted.empty());
  REQUIRE(keys.list().revoked.size() == 1);
  CHECK(keys_refusal([&] { keys.revoke("roark"); }).find("nothing to revoke") != std::string::npos);
  CHECK(keys_refusal([&] { keys.trust(roark, false); }).find("was revoked") != std::string::npos);
  keys.trust(roark, true);
  CHECK(keys.list().revoked.empty());
  CHECK(keys.list().trusted.size() == 1);
  REQUIRE(keys.list().own.size() == 1);
}

TEST_CASE("what is no certificate is refused in one sentence") {
  // Garbage, huge files, folders, keys, certificates of others' names, and ones that their own key has not signed.
  const TestKeys labs;
  const TemporaryDirectory folder;
  const KeyFolder keys = labs.of("shark");
  const std::string pem = labs.of("roark").own("roark").certificate.pem;
  const std::string key = labs.of("roark").own("roark").key_pem;
  std::string flipped = pem;
  flipped[flipped.find('\n') + 100] ^= 1;
  const std::pair<fs::path, std::string> table[] = {
      {folder.write("empty", ""), "is not a certificate"},
      {folder.write("garbage", std::string(500, '\xff')), "is not a certificate"},
      {folder.write("cut", pem.substr(0, pem.size() / 2)), "is not a certificate"},
      {folder.write("key", key), "is not a certificate"},
      {folder.write("flipped", flipped), "flipped"},
      {folder.write("huge", pem + std::string(1 << 20, ' ')), "is longer than 16384 bytes"},
      {folder.write("name", make_certificate(key, "Not A Lab")), "is not a lab's certificate"},
      {folder.path(), "is not a file"},
      {folder.path() / "nowhere", "there is no file"},
      {"/dev/zero", "is not a file"},
  };
  for (const auto& row : table) {
    CAPTURE(row.first);
    const std::string why = keys_refusal([&] { keys.trust(row.first, false); });
    CAPTURE(why);
    CHECK(why.find(row.second) != std::string::npos);
    CHECK(why.find('\n') == std::string::npos);
  }
  // Its name changed on the way, which its digits would not show.
  labs.of("lynx");
  std::string stolen = make_certificate(labs.of("lynx").own("lynx").key_pem, "roark");
  folder.write("stolen", stolen);
  keys.trust(folder.path() / "stolen", false);
  CHECK(keys_refusal([&] {
          keys.trust(labs.of("lynx").certificate_file("lynx"), false);
        }).find("has the key of lab roark, which is trusted already") != std::string::npos);
}

TEST_CASE("a file of the folder that is damaged trusts nobody and is named") {
  const TestKeys labs;
  const KeyFolder keys = labs.of("shark");
  labs.trust("shark", "roark");
  fs::copy(keys.path() / "trusted/roark.crt", keys.path() / "trusted/lynx.crt");
  std::ofstream(keys.path() / "trusted/mole.crt") << "junk";
  const KeyFolder::Listing listing = keys.list();
  REQUIRE(listing.trusted.size() == 1);
  CHECK(listing.trusted[0].lab == "roark");
  REQUIRE(listing.damaged.size() == 2);
  CHECK(listing.damaged[0].find("lynx.crt belongs to lab roark; it is ignored") != std::string::npos);
  CHECK(listing.damaged[1].find("mole.crt is not a certificate") != std::string::npos);
  const std::string before = keys.stamp();
  CHECK(keys.stamp() == before);
  keys.revoke("roark");
  CHECK(keys.stamp() != before);
}

}  // namespace
}  // namespace arkmesh::gateway
