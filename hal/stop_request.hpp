// A wish that work ends in good order: commands pass what the operator wishes down to whatever takes long.
#pragma once

namespace arkmesh::hal {

class StopRequest {
 public:
  virtual ~StopRequest() = default;
  // True from the moment on when somebody has wished it. Quick: loops ask in each turn.
  virtual bool stopped() = 0;
  // Why it is no operator's wish but a failure elsewhere, one sentence; null: an operator wishes it.
  virtual const char* failure() { return nullptr; }
};

// For work that nobody can stop. Lives as long as the process.
inline StopRequest& nobody_stops() {
  class Nobody final : public StopRequest {
    bool stopped() override { return false; }
  };
  static Nobody nobody;
  return nobody;
}

}  // namespace arkmesh::hal
