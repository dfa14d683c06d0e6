// What labs of CRE tell each other, as the table of the README says it.
#pragma once

#include "lab/lab.hpp"
#include "scenarios/cre/settings.hpp"

namespace arkmesh::scenarios::cre {

// In begin() of whoever takes part.
void declare_fields(lab::Lab& lab, const Settings& settings);

}  // namespace arkmesh::scenarios::cre
