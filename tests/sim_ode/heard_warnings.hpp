// What is warned of during a test.
#pragma once

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <sstream>
#include <string>

namespace arkmesh::sim_ode {

class Heard {
 public:
  Heard() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("", std::make_shared<spdlog::sinks::ostream_sink_st>(said_)));
  }
  ~Heard() { spdlog::set_default_logger(before_); }
  bool says(const std::string& words) const { return said_.str().find(words) != std::string::npos; }
  std::string text() const { return said_.str(); }

 private:
  std::ostringstream said_;
  std::shared_ptr<spdlog::logger> before_;
};

}  // namespace arkmesh::sim_ode
