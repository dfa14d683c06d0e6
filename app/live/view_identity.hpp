// What a lab's page shows itself with beyond its machine.
#pragma once

#include <string>
#include <vector>

namespace arkmesh::app {

// view::ServerOptions::identity of lab `lab`, for browsers that reach it as `hosts`. Made once and kept as page-LAB.pem
// in the user's folder, which only the user may read; says its fingerprint in the log. Throws hal::ConfigError when
// others may read the file, std::runtime_error when it cannot be written.
std::string view_identity(const std::string& lab, const std::vector<std::string>& hosts);

}  // namespace arkmesh::app
