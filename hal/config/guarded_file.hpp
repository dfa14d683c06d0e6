// Small files of the user: keys, which nobody else may read or change, and certificates. Written beside their place and
// moved there, so that nobody ever reads half of one.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace arkmesh::hal {

inline constexpr mode_t secret_mode = 0600, readable_mode = 0644;

// $XDG_CONFIG_HOME/arkmesh or ~/.config/arkmesh; empty when neither variable is set.
std::filesystem::path user_folder();

// Longer files are not read.
inline constexpr std::size_t max_guarded_bytes = 16'384;
// Nothing when there is no such file. Throws ConfigError when it is too long or cannot be read, and std::runtime_error
// when the machine cannot at the moment. `is_secret`: only its owner, who is us, may be able to.
std::optional<std::string> read_guarded(const std::filesystem::path& file, bool is_secret = false);
// Makes its folder, too. Throws std::runtime_error.
void write_guarded(const std::filesystem::path& file, const std::string& text, mode_t mode);

}  // namespace arkmesh::hal
