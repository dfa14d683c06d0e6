// Why a camera's URL gives no pictures, in one sentence that says what to do. Asks the machine there once, by itself.
#pragma once

#include <string>

namespace arkmesh::tracker {

// For URLs that could not be opened as a video: looks how far one gets with a plain connection. Takes some seconds at
// most, and as long as the system's resolver takes for a name.
std::string url_trouble(const std::string& url);

}  // namespace arkmesh::tracker
