// Files that are never half written, also when the power fails: written beside their place, to the disk, and moved
// there.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace arkmesh::hal {

// Where a file is written until it is whole: beside its place, and apart from what another process writes there.
std::filesystem::path part_of(const std::filesystem::path& file);
// Puts a file that is whole, and closed or flushed, in another one's place, with what the disk must hold of it. Returns
// errno, 0 when that is done; else both are as they were.
int put_in_place(const std::filesystem::path& part, const std::filesystem::path& file);

// Makes `text` the file's whole content. `mode`: its rights whatever the umask is; else those of any new file. Returns
// errno, 0 when that is done; else the file is as it was.
int replace_file(const std::filesystem::path& file, std::string_view text, std::optional<mode_t> mode = {});
// The same; throws std::runtime_error with one sentence.
void must_replace_file(const std::filesystem::path& file, std::string_view text, std::optional<mode_t> mode = {});

}  // namespace arkmesh::hal
