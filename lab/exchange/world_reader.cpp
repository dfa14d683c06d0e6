#include "lab/exchange/world_reader.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "hal/participants.hpp"

namespace arkmesh::lab {

std::shared_ptr<const WorldMessage> WorldReader::read(std::string_view origin, std::span<const std::byte> bytes,
                                                      std::string_view& why) {
  why = {};
  auto known = std::ranges::find(newest_, origin, &Read::origin);
  if (known != newest_.end() && known->bytes.size() == bytes.size() &&
      std::memcmp(known->bytes.data(), bytes.data(), bytes.size()) == 0)
    return known->message;
  auto message = std::make_shared<WorldMessage>();
  if (why = decode_world(bytes, *message); !why.empty()) return nullptr;
  if (known == newest_.end()) {
    if (newest_.size() < hal::max_labs) {
      known = newest_.emplace(newest_.end());
    } else {  // others choose the names that come in
      replaced_ = (replaced_ + 1) % newest_.size();
      known = newest_.begin() + static_cast<std::ptrdiff_t>(replaced_);
    }
    known->origin = origin;
  }
  known->bytes.assign(bytes.begin(), bytes.end());
  known->message = std::move(message);
  return known->message;
}

}  // namespace arkmesh::lab
