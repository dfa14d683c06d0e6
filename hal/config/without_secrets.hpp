// What people, logs, files and the system's list of processes may see of a text that may hold addresses.
#pragma once

#include <string>
#include <string_view>

namespace arkmesh::hal {

// Each address (SCHEME://..., and in lists USER:PASSWORD@HOST) without user and password; "?..." in place of its query.
std::string without_secrets(std::string_view text);

}  // namespace arkmesh::hal
