#include "app/batch/batch_plots.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "hal/files/own_files.hpp"

namespace arkmesh::app {

void draw_batch(const std::filesystem::path& directory, const BatchPlot& plot) {
  std::vector<std::string> words = {directory.string(), "--column", plot.column, "--over", plot.over};
  if (!plot.by.empty()) words.insert(words.end(), {"--by", plot.by});
  if (!plot.kind.empty()) words.insert(words.end(), {"--kind", plot.kind});
  for (const auto& [look, value] : plot.looks)
    if (!value.empty()) words.insert(words.end(), {"--" + look, value});
  fmt::print("{}\n", hal::run_script("plot_batch", words));
}

}  // namespace arkmesh::app
