#include "gateway/links/key_folder.hpp"

#include <fmt/format.h>
#include <openssl/x509.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "hal/arenas/messages.hpp"
#include "hal/config/config.hpp"
#include "hal/config/guarded_file.hpp"

namespace arkmesh::gateway {
namespace fs = std::filesystem;
namespace {

std::optional<Certificate> read_certificate_file(const fs::path& file) {
  const auto text = hal::read_guarded(file);
  if (!text) return {};
  try {
    return read_certificate(*text);
  } catch (const hal::ConfigError& error) {
    throw hal::ConfigError(fmt::format("{} {}", file.string(), error.what()));
  }
}

std::vector<fs::path> certificate_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->path().extension() == ".crt") files.push_back(entry->path());
  if (error && error != std::errc::no_such_file_or_directory)
    throw std::runtime_error(fmt::format("{} cannot be read now: {}", folder.string(), error.message()));
  std::ranges::sort(files);
  return files;
}

fs::path key_file(const fs::path& folder, const std::string& lab) {
  return folder / (lab + ".key");
}
fs::path trusted_file(const fs::path& folder, const std::string& lab) {
  return folder / "trusted" / (lab + ".crt");
}
// Of one lab several may have been revoked.
fs::path revoked_file(const fs::path& folder, const Certificate& certificate) {
  std::string digits = fingerprint(certificate.pin);
  std::erase(digits, ' ');
  return folder / "revoked" / fmt::format("{}-{}.crt", certificate.lab, digits);
}

void require_lab_name(const std::string& lab) {
  if (!hal::is_lab_name(lab))
    throw hal::ConfigError(
        fmt::format("'{}' is not a lab name; use 1 to {} of a-z, 0-9, '_' and '-'", lab, hal::max_lab_name));
}

}  // namespace

KeyFolder::KeyFolder(fs::path folder) : folder_(folder.empty() ? default_folder() : std::move(folder)) {}

fs::path KeyFolder::default_folder() {
  const fs::path user = hal::user_folder();
  if (user.empty())
    throw hal::ConfigError("no folder for keys: the variable HOME is not set; name one in gateway.keys or with --keys");
  return user / "keys";
}

KeyFolder::Own KeyFolder::own(const std::string& lab) const {
  auto certificate = read_certificate_file(certificate_file(lab));
  auto key_pem = hal::read_guarded(key_file(folder_, lab), true);
  if (!certificate || !key_pem)
    throw hal::ConfigError(fmt::format(
        "lab {} has no key and certificate in {}; create them with: arkmesh keys init {}", lab, folder_.string(), lab));
  const KeyPointer key = parse_key(*key_pem);
  const X509Pointer parsed = parse_certificate(certificate->pem);
  if (!key) throw hal::ConfigError(fmt::format("{} is not a private key", key_file(folder_, lab).string()));
  if (certificate->lab != lab || X509_check_private_key(parsed.get(), key.get()) != 1)
    throw hal::ConfigError(
        fmt::format("{} and {} do not match", key_file(folder_, lab).string(), certificate_file(lab).string()));
  return {std::move(*key_pem), std::move(*certificate)};
}

KeyFolder::Listing KeyFolder::list() const {
  Listing listing;
  const auto read_all = [&](const fs::path& folder, bool named_after_lab, std::vector<Certificate>& into) {
    for (const fs::path& file : certificate_files(folder)) try {
        auto certificate = read_certificate_file(file);
        if (!certificate) continue;
        if (named_after_lab && file.stem() != certificate->lab)
          throw hal::ConfigError(fmt::format("{} belongs to lab {}; it is ignored", file.string(), certificate->lab));
        into.push_back(std::move(*certificate));
      } catch (const hal::ConfigError& error) {
        listing.damaged.emplace_back(error.what());
      }
  };
  read_all(folder_, true, listing.own);
  read_all(folder_ / "trusted", true, listing.trusted);
  read_all(folder_ / "revoked", false, listing.revoked);
  return listing;
}

std::string KeyFolder::stamp() const {
  std::string stamp;
  for (const fs::path& folder : {folder_, folder_ / "trusted", folder_ / "revoked"}) {
    std::error_code error;
    std::set<std::string> lines;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
      struct stat facts {};
      if (::stat(entry->path().c_str(), &facts) == 0 && S_ISREG(facts.st_mode))
        lines.insert(fmt::format("{} {} {} {}.{}\n", entry->path().string(), facts.st_ino, facts.st_size,
                                 facts.st_mtim.tv_sec, facts.st_mtim.tv_nsec));
    }
    for (const std::string& line : lines) stamp += line;
  }
  return stamp;
}

Certificate KeyFolder::init(const std::string& lab) const {
  require_lab_name(lab);
  if (fs::exists(key_file(folder_, lab)) || fs::exists(certificate_file(lab)))
    throw hal::ConfigError(fmt::format("lab {} already has a key in {}; arkmesh keys renew {} extends its certificate",
                                       lab, folder_.string(), lab));
  // What a gateway of another user need not see.
  std::error_code error;
  if (fs::create_directories(folder_, error)) fs::permissions(folder_, fs::perms::owner_all, error);
  const std::string key = make_key();
  hal::write_guarded(key_file(folder_, lab), key, hal::secret_mode);
  hal::write_guarded(certificate_file(lab), make_certificate(key, lab), hal::readable_mode);
  return own(lab).certificate;
}

Certificate KeyFolder::renew(const std::string& lab, bool new_key) const {
  require_lab_name(lab);
  Own before = own(lab);
  if (new_key) {
    before.key_pem = make_key();
    hal::write_guarded(key_file(folder_, lab), before.key_pem, hal::secret_mode);
  }
  hal::write_guarded(certificate_file(lab), make_certificate(before.key_pem, lab), hal::readable_mode);
  return own(lab).certificate;
}

Certificate KeyFolder::trust(const fs::path& file, bool replace) const {
  const auto certificate = read_certificate_file(file);
  if (!certificate) throw hal::ConfigError(fmt::format("there is no file {}", file.string()));
  const Listing known = list();
  for (const Certificate& other : known.trusted) {
    if (other.pin == certificate->pin && other.lab != certificate->lab)
      throw hal::ConfigError(fmt::format("{} has the key of lab {}, which is trusted already; each lab has its own",
                                         file.string(), other.lab));
    if (other.lab == certificate->lab && other.pin != certificate->pin && !replace)
      throw hal::ConfigError(
          fmt::format("another certificate of lab {} is already trusted ({}, not {}); if the lab confirms that it has "
                      "a new one, accept it with --replace",
                      other.lab, fingerprint(other.pin), fingerprint(certificate->pin)));
  }
  if (std::ranges::find(known.revoked, certificate->pin, &Certificate::pin) != known.revoked.end()) {
    if (!replace)
      throw hal::ConfigError(fmt::format("this certificate of lab {} ({}) was revoked; only --replace trusts it again",
                                         certificate->lab, fingerprint(certificate->pin)));
    std::error_code error;
    fs::remove(revoked_file(folder_, *certificate), error);
  }
  hal::write_guarded(trusted_file(folder_, certificate->lab), certificate->pem, hal::readable_mode);
  return *certificate;
}

Certificate KeyFolder::revoke(const std::string& lab) const {
  require_lab_name(lab);
  const fs::path file = trusted_file(folder_, lab);
  auto certificate = read_certificate_file(file);
  if (!certificate)
    throw hal::ConfigError(
        fmt::format("lab {} is not trusted, so there is nothing to revoke; arkmesh keys list shows who is", lab));
  hal::write_guarded(revoked_file(folder_, *certificate), certificate->pem, hal::readable_mode);
  if (::unlink(file.c_str()) != 0)
    throw std::runtime_error(fmt::format("{} cannot be removed: {}", file.string(), std::strerror(errno)));
  return *certificate;
}

}  // namespace arkmesh::gateway
