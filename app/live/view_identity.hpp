// What a lab's page shows itself with beyond its machine.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "view/server.hpp"

namespace arkmesh::app {

// Of lab `lab`, whose key lies in `keys` (empty: the default folder), for browsers that reach it as `hosts`. Keeps the
// certificate as page-LAB.crt in the user's folder, and says its fingerprint in the log. Throws hal::ConfigError when
// there is no key.
view::Identity view_identity(const std::filesystem::path& keys, const std::string& lab,
                             const std::vector<std::string>& hosts);

}  // namespace arkmesh::app
