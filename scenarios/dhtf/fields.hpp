// What labs of DHTF tell each other, as the table of the README says it.
#pragma once

#include <string>

#include "lab/lab.hpp"
#include "scenarios/dhtf/settings.hpp"

namespace arkmesh::scenarios::dhtf {

// The field of the types of a lab's tasks.
std::string hard_field(const std::string& lab);
// In begin() of whoever takes part.
void declare_fields(lab::Lab& lab, const Settings& settings);

}  // namespace arkmesh::scenarios::dhtf
