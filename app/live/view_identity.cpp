#include "app/live/view_identity.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "gateway/browser_certificate.hpp"
#include "gateway/key_folder.hpp"
#include "hal/config.hpp"
#include "hal/guarded_file.hpp"

namespace arkmesh::app {
namespace {

gateway::BrowserCertificate kept_certificate(const gateway::KeyFolder::Own& own, const std::string& lab,
                                             const std::vector<std::string>& hosts) {
  const auto make = [&](std::string_view before) {
    return gateway::browser_certificate(own.key_pem, own.certificate.pem, lab, hosts, before);
  };
  const std::filesystem::path folder = hal::user_folder();
  if (folder.empty()) return make({});
  const std::filesystem::path file = folder / fmt::format("page-{}.crt", lab);
  const std::string before = hal::read_guarded(file).value_or("");
  gateway::BrowserCertificate made = make(before);
  if (made.certificate_pem != before) hal::write_guarded(file, made.certificate_pem, hal::readable_mode);
  return made;
}

}  // namespace

view::Identity view_identity(const std::filesystem::path& keys, const std::string& lab,
                             const std::vector<std::string>& hosts) try {
  const auto made = kept_certificate(gateway::KeyFolder(keys).own(lab), lab, hosts);
  spdlog::info("browsers ask whether to trust the page of {}; its certificate has the fingerprint (SHA-256) {}", lab,
               made.fingerprint);
  return {.key_pem = made.key_pem, .certificate_pem = made.certificate_pem};
} catch (const hal::ConfigError& error) {
  throw hal::ConfigError(
      fmt::format("view.address is beyond this machine, where the page is shown over TLS with the lab's key only: {}",
                  error.what()));
}

}  // namespace arkmesh::app
