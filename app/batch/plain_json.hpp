// JSON that somebody else may have written: a member of another type than expected counts as one that is not there.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace arkmesh::app {

// Null when the file is no JSON, no regular file, or above 64 MB.
nlohmann::json read_json(const std::filesystem::path& file);
// A text, or `otherwise`.
std::string text_in(const nlohmann::json& object, const char* key, const std::string& otherwise = {});
// An object, or an empty one.
const nlohmann::json& object_in(const nlohmann::json& object, const char* key);

}  // namespace arkmesh::app
