// What it costs to sign and to verify a message that goes through a NATS server to many, and to seal and open one for a
// peer. seals_bench BYTES; prints lines of names and microseconds, the median of many.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <vector>

#include "gateway/federation/seals.hpp"
#include "gateway/links/certificate.hpp"

namespace {

using namespace arkmesh::gateway;
using Clock = std::chrono::steady_clock;

constexpr int rounds = 2000;

double median_us(const std::function<bool()>& once) {
  std::vector<double> all;
  for (int i = 0; i < rounds; ++i) {
    const auto begin = Clock::now();
    if (!once()) throw std::runtime_error("a packet was not taken");
    all.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
  }
  std::ranges::nth_element(all, all.begin() + rounds / 2);
  return all[rounds / 2];
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "seals_bench BYTES\n");
    return 2;
  }
  const std::vector<std::byte> message(static_cast<std::size_t>(std::atoi(argv[1])), std::byte{7});
  const std::string our_key = make_key(), their_key = make_key();
  const Certificate us = read_certificate(make_certificate(our_key, "shark"));
  const Certificate them = read_certificate(make_certificate(their_key, "roark"));
  const Seals ours(our_key, us.pin, {them}), theirs(their_key, them.pin, {us});
  const OtherSeal& other = *ours.of("roark");
  const auto signature = theirs.sign(message);
  const SecretKey key = new_secret_key();
  const auto sealed = seal(key, message, {});
  fmt::print("sign {:.1f}\n", median_us([&] { return !ours.sign(message).empty(); }));
  fmt::print("verify {:.1f}\n", median_us([&] { return other.has_signed(message, signature); }));
  fmt::print("seal {:.1f}\n", median_us([&] { return !seal(key, message, {}).empty(); }));
  fmt::print("unseal {:.1f}\n", median_us([&] { return unseal(key, sealed, {}).has_value(); }));
  return 0;
}
