// Options of the commands that draw figures: `plot` and `batch`. What they mean is drawing/figure_style.py's business.
#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "cli/commands.hpp"

namespace arkmesh::cli {

std::vector<CLI::Option*> add_looks(CLI::App* command, std::map<std::string, std::string>& looks) {
  return {command
              ->add_option("--width", looks["width"],
                           "Width of a journal's column (3.5 inches) or page (7.16 inches, the default)")
              ->check(CLI::IsMember({"column", "page"})),
          command->add_option("--xlabel", looks["xlabel"], "Label of the horizontal axis; default: the key's name"),
          command->add_option("--ylabel", looks["ylabel"], "Label of the vertical axis; default: the column's name"),
          command->add_option("--title", looks["title"], "A title above the figure")};
}

}  // namespace arkmesh::cli
