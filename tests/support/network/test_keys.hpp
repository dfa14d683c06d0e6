// Folders of keys for labs of a test, as `arkmesh keys` makes them, one for each lab.
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "gateway/links/key_folder.hpp"
#include "gateway/links/tls_keys.hpp"
#include "tests/support/processes/temporary_directory.hpp"

namespace arkmesh::tests {

class TestKeys {
 public:
  gateway::KeyFolder of(const std::string& lab) const {
    gateway::KeyFolder keys(folder_.path() / lab);
    if (!std::filesystem::exists(keys.certificate_file(lab))) keys.init(lab);
    return keys;
  }
  void trust(const std::string& lab, const std::string& other, bool replace = false) const {
    of(lab).trust(of(other).certificate_file(other), replace);
  }
  void join(const std::string& one, const std::string& other) const {
    trust(one, other);
    trust(other, one);
  }
  std::shared_ptr<gateway::TlsKeys> tls(const std::string& lab) const {
    return std::make_shared<gateway::TlsKeys>(of(lab), lab);
  }
  // A certificate of the lab's key that was made then.
  void date(const std::string& lab, std::chrono::system_clock::time_point made) const {
    const gateway::KeyFolder keys = of(lab);
    const std::string pem = gateway::make_certificate(keys.own(lab).key_pem, lab, made);
    std::ofstream(keys.certificate_file(lab)) << pem;
  }

 private:
  TemporaryDirectory folder_;
};

}  // namespace arkmesh::tests
