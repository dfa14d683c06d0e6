// `arkmesh publish`: a run or a batch as an RO-Crate, with a page that replays it. Made by drawing/publish.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "hal/files/own_files.hpp"

namespace arkmesh::cli {
namespace {

struct PublishOptions {
  std::string place, licence, name, out;
  std::vector<std::string> authors;
};

void publish(const PublishOptions& options) {
  std::vector<std::string> words = {options.place};
  for (const std::string& author : options.authors) words.insert(words.end(), {"--author", author});
  for (const auto& [option, value] :
       {std::pair{"--licence", options.licence}, {"--name", options.name}, {"--out", options.out}})
    if (!value.empty()) words.insert(words.end(), {option, value});
  fmt::print("{}\n", hal::run_script("publish", words));
}

}  // namespace

void add_publish_command(CLI::App* command) {
  const auto options = std::make_shared<PublishOptions>();
  command->add_option("place", options->place, "The folder of a run or a batch")
      ->required()
      ->check(CLI::ExistingDirectory);
  command->add_option("--author", options->authors, "NAME, or \"NAME, ORCID\"; repeat it for each author, in order")
      ->allow_extra_args(false);
  command->add_option("--licence", options->licence, "An SPDX identifier, such as CC-BY-4.0, or a URL");
  command->add_option("--name", options->name, "Name of the data set (default: the name of the folder)");
  command->add_option("--out", options->out,
                      "The folder to create; the zip is written beside it. Default: PLACE-crate");
  command->footer(
      "Examples:\n  arkmesh publish runs/demo --author \"Ada Lovelace, 0000-0002-1825-0097\" --licence CC-BY-4.0\n"
      "The folder and zip hold RO-Crate metadata, the inputs of each run, tables, trajectories as CSV and HDF5, and "
      "replay.html, which replays a run in any browser without arkmesh. Host names, addresses and folders are left "
      "out.");
  command->callback([options] { publish(*options); });
}

}  // namespace arkmesh::cli
