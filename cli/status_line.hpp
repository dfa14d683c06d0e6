// How far long work is, on stderr: in place on a terminal, else a line each two seconds, and each thirty while it says
// the same.
#pragma once

#include <chrono>
#include <string>

namespace arkmesh::cli {

class StatusLine {
 public:
  // `what` stands before every text; nothing by default.
  explicit StatusLine(std::string what = {});
  ~StatusLine() { done(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;
  // Call it as often as you like.
  void show(const std::string& text);
  // Takes the line away from a terminal, so that something else can be said.
  void done();

 private:
  using Moment = std::chrono::steady_clock::time_point;
  std::string what_, text_;
  bool terminal_, open_ = false;
  Moment due_{}, same_due_{};
};

}  // namespace arkmesh::cli
