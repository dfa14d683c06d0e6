#include "app/batch/batch_plots.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "sim_ode/host/programs/subprocess.hpp"

namespace arkmesh::app {

void draw_batch(const std::filesystem::path& directory, const BatchPlot& plot) {
  const std::string script = sim_ode::script_of_arkmesh("plot_batch").string();
  std::vector<std::string> command = {script, directory.string(), "--column", plot.column, "--over", plot.over};
  if (!plot.by.empty()) command.insert(command.end(), {"--by", plot.by});
  if (!plot.kind.empty()) command.insert(command.end(), {"--kind", plot.kind});
  const sim_ode::Finished done = sim_ode::run_to_end(command);
  std::string last = done.output;
  while (last.ends_with('\n')) last.pop_back();
  if (const auto line = last.rfind('\n'); line != std::string::npos) last.erase(0, line + 1);
  if (done.status != 0)
    throw std::runtime_error(last.empty() ? fmt::format("{} cannot be started; it needs /usr/bin/python3", script)
                                          : last);
  fmt::print("{}\n", last);
}

}  // namespace arkmesh::app
