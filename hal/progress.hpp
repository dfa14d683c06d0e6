// How far long work is, for whoever watches it. Whoever implements it decides how often something is shown, so each may
// be called as often as you like.
#pragma once

#include <cstdint>
#include <string>

namespace arkmesh::hal {

class Progress {
 public:
  virtual ~Progress() = default;
  // Where the work stands, in words.
  virtual void show(const std::string& text) = 0;
  // Work that is counted: `done` of `all` units, each of which stands for `unit_s` seconds of lab time. `state` begins
  // with "running" or "waiting".
  virtual void show(std::uint32_t done, std::uint32_t all, double unit_s, const std::string& state = "running") = 0;
  // Takes away what is shown in place, so that something else can be said.
  virtual void done() = 0;
  // A line that stays.
  virtual void say(const std::string& line) = 0;
};

}  // namespace arkmesh::hal
