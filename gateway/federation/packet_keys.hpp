// How one lab makes packets that only it can have made, and reads those of labs that it trusts. Says what it refused,
// and why. Threading: that of its caller.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gateway/federation/packet.hpp"
#include "gateway/federation/seals.hpp"
#include "gateway/links/tls_keys.hpp"
#include "gateway/outbox/budget.hpp"
#include "hal/counters.hpp"

namespace arkmesh::gateway {

class PacketKeys {
 public:
  using Time = std::chrono::steady_clock::time_point;
  // `boot_id`: of the gateway; of somebody who only reads, anything.
  // Throws hal::ConfigError when the lab's key is of a kind that cannot sign packets.
  PacketKeys(std::string lab, std::string experiment, std::uint64_t boot_id, std::shared_ptr<TlsKeys> keys);

  bool trusts(const std::string& lab) const { return keys_->seals().of(lab) != nullptr; }

  // For all, signed; a secret kind for those who have this lab's group key.
  std::vector<std::byte> for_all(PacketKind kind, std::vector<std::byte> body);
  // This lab's group key, for each lab that it trusts: another one than before when one of those that had it is trusted
  // no more.
  std::vector<std::byte> group_key_for_all();
  // It is: nothing secret is for_all() until the next group_key_for_all().
  bool group_key_is_stale() const;
  // For one. Nothing when it is trusted no more.
  std::optional<std::vector<std::byte>> for_one(const std::string& to, const std::vector<std::byte>& body);

  // The body of a packet of a lab that is trusted: nothing when it is to be refused, which was counted then. Of a
  // signed one nobody has looked at the signature yet: is_signed() does, and costs most. `now`: for the rates.
  std::optional<std::vector<std::byte>> open(const PacketView& packet, Time now = std::chrono::steady_clock::now());
  bool is_signed(const PacketView& packet, Time now = std::chrono::steady_clock::now());
  // Of a packet of kind `keys` that is signed.
  void take_group_key(const PacketView& packet);

  // Counts what is refused, under federation.refused.REASON, of labs that are trusted with their name.
  void refuse(const std::string& reason, const std::string& lab = {});
  const hal::Counters& counters() const { return counters_; }
  // A sentence about somebody who speaks in another's name, once a minute of each; empty: nobody does.
  std::string take_notice() { return std::exchange(notice_, {}); }

 private:
  std::vector<std::byte> context(std::span<const std::byte> bytes, std::string_view to) const;

  const std::string lab_, experiment_;
  const std::uint64_t boot_id_;
  const std::shared_ptr<TlsKeys> keys_;
  std::uint64_t packets_ = 0;
  SecretKey group_key_ = new_secret_key();
  std::vector<Pin> readers_;  // of the labs that have it
  struct GroupKey {
    PacketOrder at{};  // the packet that it came with
    SecretKey key{};
  };
  std::map<std::string, GroupKey> group_keys_;  // of others
  std::map<std::string, Budget> spoken_;        // how many more packets a lab may make
  std::map<std::string, Budget> forgeries_;     // how many more are looked at, by the lab that they say they are from
  hal::Counters counters_;
  std::string notice_;
  std::map<std::string, Time> named_;  // when a notice was about that lab's name
};

}  // namespace arkmesh::gateway
