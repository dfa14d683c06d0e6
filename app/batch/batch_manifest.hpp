// manifest.json of a batch: which program ran what, from which files, and all that its runs can be repeated from. A
// folder that was begun with another manifest is not gone on with.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "app/batch/batch_file.hpp"
#include "app/lab_check.hpp"

namespace arkmesh::app {

// `checked`: the labs of each setting, in their order. For comparison alone, some settings are enough.
nlohmann::json make_manifest(const BatchFile& batch, const std::vector<std::vector<CheckedLab>>& checked);

// What keeps a batch from going on in a folder that was begun with manifest `begun`, in one sentence that names it;
// empty when nothing does. Looks at the files that it was begun with. `only_plan`: who looks at what there is needs the
// same runs, whatever has become of program and files since.
std::string difference(const nlohmann::json& begun, const nlohmann::json& now, bool only_plan = false);

}  // namespace arkmesh::app
