// Names from a log, which may be anything, as names of files and of datasets.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace arkmesh::recording {

// A name as a part of a path: what is no letter, digit, '.', '-' or '_' becomes '_'; a name of dots too. At most 100
// characters.
std::string safe_name(std::string_view name);

// Names of one folder or group and of what lies below: each once, and none is both a file and a folder.
class Names {
 public:
  // `folders` are taken from the beginning on.
  explicit Names(std::set<std::string, std::less<>> folders = {}) : folders_(std::move(folders)) {}
  // The name, safe in each of its parts that '/' joins; with a number behind it where it is taken.
  std::string of(std::string_view name);

 private:
  std::set<std::string, std::less<>> files_, folders_;
};

}  // namespace arkmesh::recording
