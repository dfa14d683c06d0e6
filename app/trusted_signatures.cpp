#include "app/trusted_signatures.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "gateway/frame/signature.hpp"
#include "gateway/links/key_folder.hpp"

namespace arkmesh::app {

bool TrustedSignatures::has_signed(const std::string& peer, std::span<const std::uint8_t> bytes,
                                   std::span<const std::uint8_t> signature) {
  try {
    read();
  } catch (const std::exception&) {  // no folder, or the machine cannot read it at the moment
    return false;
  }
  const auto it = certificate_.find(peer);
  return it != certificate_.end() && gateway::has_signed(it->second, bytes, signature);
}

void TrustedSignatures::read() {
  const gateway::KeyFolder folder(keys_);
  std::string stamp = folder.stamp();
  if (stamp == stamp_) return;
  certificate_.clear();
  const gateway::KeyFolder::Listing listing = folder.list();
  for (const gateway::Certificate& trusted : listing.trusted)
    if (std::ranges::find(listing.revoked, trusted.pin, &gateway::Certificate::pin) == listing.revoked.end())
      certificate_[trusted.lab] = trusted.pem;
  stamp_ = std::move(stamp);
}

}  // namespace arkmesh::app
