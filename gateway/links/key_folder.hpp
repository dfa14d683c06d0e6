// The folder of keys: LAB.key and LAB.crt of the labs of this machine, trusted/NAME.crt of the labs that they let in,
// revoked/NAME-DIGITS.crt of those that they let in no more. `arkmesh keys` changes it, gateways read it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gateway/links/certificate.hpp"

namespace arkmesh::gateway {

class KeyFolder {
 public:
  // Empty: the default folder.
  explicit KeyFolder(std::filesystem::path folder = {});
  // $XDG_CONFIG_HOME/arkmesh/keys, or ~/.config/arkmesh/keys. Throws hal::ConfigError when neither variable is set.
  static std::filesystem::path default_folder();

  const std::filesystem::path& path() const { return folder_; }
  std::filesystem::path certificate_file(const std::string& lab) const { return folder_ / (lab + ".crt"); }

  struct Own {
    std::string key_pem;
    Certificate certificate;
  };
  // Throws hal::ConfigError: there is none; others may read the key; the files are damaged or do not belong together.
  Own own(const std::string& lab) const;

  // By lab name. A file that cannot be read, or holds another lab than its name says, is left out and named in
  // `damaged`.
  struct Listing {
    std::vector<Certificate> own, trusted, revoked;
    std::vector<std::string> damaged;  // a sentence each
  };
  // Throws std::runtime_error when the machine cannot read the folder at the moment.
  Listing list() const;
  // Changes whenever a file of the folder does.
  std::string stamp() const;

  // The following do what `arkmesh keys` offers. They throw hal::ConfigError when it cannot be, std::runtime_error when
  // the disk refuses.
  Certificate init(const std::string& lab) const;
  // A certificate for ten more years from now on; with a new key its fingerprint changes.
  Certificate renew(const std::string& lab, bool new_key) const;
  // `replace`: another one of the same name, and a revoked one, too.
  Certificate trust(const std::filesystem::path& file, bool replace) const;
  Certificate revoke(const std::string& lab) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace arkmesh::gateway
