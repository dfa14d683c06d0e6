#include "app/live/view_identity.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "gateway/links/browser_certificate.hpp"
#include "hal/config/guarded_file.hpp"

namespace arkmesh::app {

std::string view_identity(const std::string& lab, const std::vector<std::string>& hosts) {
  const std::filesystem::path folder = hal::user_folder(), file = folder / fmt::format("page-{}.pem", lab);
  const std::string before = folder.empty() ? "" : hal::read_guarded(file, true).value_or("");
  const auto made = gateway::browser_certificate(lab, hosts, before);
  if (!folder.empty() && made.pem != before) hal::write_guarded(file, made.pem, hal::secret_mode);
  spdlog::info("browsers ask whether to trust the page of {}; its certificate has the fingerprint (SHA-256) {}", lab,
               made.fingerprint);
  return made.pem;
}

}  // namespace arkmesh::app
