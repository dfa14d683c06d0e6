// Every key of every configuration that this program knows.
#pragma once

#include <vector>

#include "hal/config/config.hpp"

namespace arkmesh::app {

std::vector<hal::KeyRow> all_keys();

}  // namespace arkmesh::app
