// Reads `world` messages once for all labs of a process that hear the same one. What labs share is immutable.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "hal/text_map.hpp"
#include "lab/exchange/world_message.hpp"

namespace arkmesh::lab {

class WorldReader {
 public:
  // Null when the message is refused: then `why` is the reason in one word, as of decode_world().
  std::shared_ptr<const WorldMessage> read(std::string_view origin, std::span<const std::byte> bytes,
                                           std::string_view& why);

 private:
  struct Read {
    std::vector<std::byte> bytes;
    std::shared_ptr<const WorldMessage> message;
  };
  hal::TextMap<Read> newest_;  // by origin; as many as there may be labs
};

}  // namespace arkmesh::lab
