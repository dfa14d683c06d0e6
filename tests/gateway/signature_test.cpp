// Signatures of labs.
#include "gateway/frame/signature.hpp"

#include <doctest/doctest.h>

#include <vector>

#include "tests/support/network/test_keys.hpp"

namespace arkmesh::gateway {
namespace {

TEST_CASE("a signature is good for its bytes and its lab alone") {
  const tests::TestKeys labs;
  const KeyFolder::Own shark = labs.of("shark").own("shark"), roark = labs.of("roark").own("roark");
  std::vector<std::uint8_t> bytes{1, 2, 3};
  Signature signature = sign(shark.key_pem, bytes).value();
  CHECK(has_signed(shark.certificate.pem, bytes, signature));
  CHECK_FALSE(has_signed(roark.certificate.pem, bytes, signature));
  CHECK_FALSE(has_signed("no certificate", bytes, signature));
  CHECK_FALSE(has_signed(shark.certificate.pem, bytes, std::span(signature).first(63)));
  signature[63] ^= 1;
  CHECK_FALSE(has_signed(shark.certificate.pem, bytes, signature));
  signature[63] ^= 1;
  bytes.push_back(4);
  CHECK_FALSE(has_signed(shark.certificate.pem, bytes, signature));
  CHECK_FALSE(sign("no key", bytes).has_value());
}

}  // namespace
}  // namespace arkmesh::gateway
