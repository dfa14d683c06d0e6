// Whose signatures a lab believes, as its folder of keys is at the moment.
#include "app/trusted_signatures.hpp"

#include <doctest/doctest.h>

#include <vector>

#include "gateway/frame/signature.hpp"
#include "gateway/links/key_folder.hpp"
#include "tests/support/network/test_keys.hpp"

using namespace arkmesh;

TEST_CASE("a lab believes the signatures of labs that it trusts, and no more when it revokes them") {
  const tests::TestKeys labs;
  const gateway::KeyFolder shark = labs.of("shark"), roark = labs.of("roark");
  const std::vector<std::uint8_t> bytes{1, 2, 3};
  const gateway::Signature signature = gateway::sign(roark.own("roark").key_pem, bytes).value();
  app::TrustedSignatures signatures(shark.path());
  CHECK_FALSE(signatures.has_signed("roark", bytes, signature));
  labs.trust("shark", "roark");
  CHECK(signatures.has_signed("roark", bytes, signature));
  CHECK_FALSE(signatures.has_signed("lynx", bytes, signature));
  shark.revoke("roark");
  CHECK_FALSE(signatures.has_signed("roark", bytes, signature));
}
