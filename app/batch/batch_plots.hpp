// Pictures of a batch's table, made by drawing/plot_batch.
#pragma once

#include <filesystem>

#include "app/batch/batch_plan.hpp"

namespace arkmesh::app {

// Draws into the batch's folder, says where, and throws std::runtime_error with the script's sentence when it cannot.
void draw_batch(const std::filesystem::path& directory, const BatchPlot& plot);

}  // namespace arkmesh::app
