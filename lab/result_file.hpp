// result.json as a file: replaced as a whole, so that a reader and a crash find the old one or the new one, and asked
// whether the process that wrote it still runs.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace arkmesh::lab {

// Returns errno, 0 when the file is replaced.
int replace_json(const std::filesystem::path& file, const nlohmann::json& json);
// Of a run that has begun: what is known of it, and that it is running.
void save_running(const std::filesystem::path& file, nlohmann::json facts);
// What cannot be written goes to the standard output.
void save_json(const std::filesystem::path& file, const nlohmann::json& json);

// Who runs in this process: the facts by which others find out whether it still does.
nlohmann::json own_process();
// "the run of shark (process 12), which still goes on", from the folder's result.json; empty when there is none.
std::string running_in(const std::filesystem::path& directory);
// In `directory` and the folders beside it: a result.json that says "running" of a process of this machine that is gone
// says "killed" from now on.
void mark_killed_beside(const std::filesystem::path& directory);

}  // namespace arkmesh::lab
