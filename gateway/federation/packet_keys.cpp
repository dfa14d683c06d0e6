#include "gateway/federation/packet_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "gateway/frame/byte_fields.hpp"
#include "hal/config/config.hpp"

namespace arkmesh::gateway {
namespace {

// So many packets a second that a lab has not signed are looked at: each costs as much as one that it has. What the lab
// itself says then comes sealed, when it says it again.
constexpr double forgeries_per_s = 20;
// Of a lab's own packets no more are looked at: some hundreds are usual, and so many cost a fifth of a processor. What
// was not looked at is not acknowledged, so an honest lab says it again.
constexpr double packets_per_s = 5000;
constexpr std::chrono::minutes notice_period{1};

bool has_one(Budget& budget, PacketKeys::Time now) {
  return budget.has(1, std::chrono::floor<Budget::Time>(now.time_since_epoch()));
}

bool is_secret(PacketKind kind) {
  return kind == PacketKind::signed_secret || kind == PacketKind::watched_secret;
}

void put_text(std::vector<std::byte>& out, std::string_view text) {
  put_bytes(out, std::as_bytes(std::span(text)));
  out.push_back(std::byte{0});
}

}  // namespace

PacketKeys::PacketKeys(std::string lab, std::string experiment, std::uint64_t boot_id, std::shared_ptr<TlsKeys> keys)
    : lab_(std::move(lab)), experiment_(std::move(experiment)), boot_id_(boot_id), keys_(std::move(keys)) {
  if (!keys_->seals().can_sign())
    throw hal::ConfigError(
        fmt::format("the key of lab {0} is not an Ed25519 key, so it cannot sign messages through a NATS server; "
                    "create another: arkmesh keys renew {0} --new-key",
                    lab_));
}

std::vector<std::byte> PacketKeys::for_all(PacketKind kind, std::vector<std::byte> body) {
  std::vector<std::byte> packet = encode_head({kind, lab_, boot_id_, ++packets_});
  if (is_secret(kind)) body = seal(group_key_, body, context(packet, to_all));
  put_bytes(packet, body);
  put_bytes(packet, keys_->seals().sign(context(packet, {})));
  return packet;
}

bool PacketKeys::group_key_is_stale() const {
  const auto& others = keys_->seals().others();
  return std::ranges::any_of(readers_, [&](const Pin& pin) {
    return std::ranges::none_of(others, [&](const auto& each) { return each.second.pin == pin; });
  });
}

std::vector<std::byte> PacketKeys::group_key_for_all() {
  if (group_key_is_stale()) group_key_ = new_secret_key();
  readers_.clear();
  const std::vector<std::byte> head = encode_head({PacketKind::keys, lab_, boot_id_, packets_ + 1});
  const auto& others = keys_->seals().others();
  std::vector<std::vector<std::byte>> sealed;
  std::vector<SealedKey> keys;
  sealed.reserve(others.size());
  for (const auto& [lab, other] : others) {
    sealed.push_back(seal(other.shared, std::as_bytes(std::span(group_key_)), context(head, lab)));
    readers_.push_back(other.pin);
    SealedKey& each = keys.emplace_back();
    std::ranges::copy(std::as_bytes(std::span(other.pin)).first(each.reader.size()), each.reader.begin());
    each.sealed = sealed.back();
  }
  return for_all(PacketKind::keys, encode_keys(keys));
}

std::optional<std::vector<std::byte>> PacketKeys::for_one(const std::string& to, const std::vector<std::byte>& body) {
  const OtherSeal* const other = keys_->seals().of(to);
  if (!other) return {};
  std::vector<std::byte> packet = encode_head({PacketKind::sealed, lab_, boot_id_, ++packets_});
  put_bytes(packet, seal(other->shared, body, context(packet, to)));
  return packet;
}

std::optional<std::vector<std::byte>> PacketKeys::open(const PacketView& packet, Time now) {
  const std::string& from = packet.head.from;
  const OtherSeal* const other = keys_->seals().of(from);
  if (!other) {
    refuse("not_trusted");
    return {};
  }
  Budget& spoken = spoken_.try_emplace(from, packets_per_s).first->second;
  if (!has_one(spoken, now)) {
    refuse("too_many", from);
    return {};
  }
  std::optional<std::vector<std::byte>> plain;
  if (packet.head.kind == PacketKind::sealed) {
    plain = unseal(other->shared, packet.body, context(packet.head_bytes, lab_));
  } else if (is_secret(packet.head.kind)) {
    const auto key = group_keys_.find(from);
    if (key != group_keys_.end() && key->second.at.first == packet.head.boot_id)
      plain = unseal(key->second.key, packet.body, context(packet.head_bytes, to_all));
    // It may have been sealed with a newer one, which was lost on its way.
    if (!plain) refuse("no_key", from);
    return plain;
  } else {
    return std::vector(packet.body.begin(), packet.body.end());
  }
  if (plain)
    spoken.use(1);
  else
    refuse("seal", from);
  return plain;
}

bool PacketKeys::is_signed(const PacketView& packet, Time now) {
  const std::string& from = packet.head.from;
  const OtherSeal* const other = keys_->seals().of(from);
  Budget& budget = forgeries_.try_emplace(from, forgeries_per_s).first->second;
  if (!has_one(budget, now)) {
    refuse("too_many_forged", from);
    return false;
  }
  if (other && other->has_signed(context(packet.signed_bytes, {}), packet.signature)) {
    spoken_.try_emplace(from, packets_per_s).first->second.use(1);
    return true;
  }
  budget.use(1);
  refuse("signature", from);
  return false;
}

void PacketKeys::take_group_key(const PacketView& packet) {
  const Seals& seals = keys_->seals();
  const OtherSeal* const other = seals.of(packet.head.from);
  const auto keys = read_keys(packet.body);
  if (!keys || !other) return refuse("malformed", packet.head.from);
  for (const SealedKey& each : *keys) {
    if (!std::ranges::equal(each.reader, std::as_bytes(std::span(seals.pin())).first(each.reader.size()))) continue;
    const auto plain = unseal(other->shared, each.sealed, context(packet.head_bytes, lab_));
    GroupKey key{.at = order_of(packet.head)};
    if (const auto known = group_keys_.find(packet.head.from); known != group_keys_.end() && key.at <= known->second.at)
      return refuse("repeated", packet.head.from);
    if (!plain || plain->size() != key.key.size()) return refuse("seal", packet.head.from);
    std::ranges::copy(*plain, std::as_writable_bytes(std::span(key.key)).begin());
    group_keys_[packet.head.from] = key;
  }
}

void PacketKeys::refuse(const std::string& reason, const std::string& lab) {
  counters_.add(lab.empty() ? "federation.refused." + reason : fmt::format("federation.refused.{}.{}", reason, lab));
  if ((reason != "signature" && reason != "seal") || !notice_.empty()) return;
  const auto now = std::chrono::steady_clock::now();
  const auto [named, is_first] = named_.try_emplace(lab, now);
  if (!is_first && now - named->second < notice_period) return;
  named->second = now;
  notice_ = fmt::format("another program uses the name of lab {} on the NATS server; its messages are ignored", lab);
}

// What is signed, or sealed beside something, together with what it counts for.
std::vector<std::byte> PacketKeys::context(std::span<const std::byte> bytes, std::string_view to) const {
  std::vector<std::byte> out;
  put_text(out, "arkmesh federation 1");
  put_text(out, experiment_);
  put_text(out, to);
  put_bytes(out, bytes);
  return out;
}

}  // namespace arkmesh::gateway
