#include "hal/bus/channel_names.hpp"

#include <algorithm>

namespace arkmesh::hal {

bool is_lab_name(std::string_view name) {
  const auto allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-'; };
  return !name.empty() && name.size() <= max_lab_name && std::all_of(name.begin(), name.end(), allowed);
}

}  // namespace arkmesh::hal
