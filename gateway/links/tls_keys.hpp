// What a gateway proves itself with over TLS, and whom it lets in. Follows the folder of keys while it runs: who is
// trusted or revoked there is so here at the next refresh(), on connections that are open, too.
#pragma once

#include <boost/asio/ssl/context.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gateway/federation/seals.hpp"
#include "gateway/links/certificate.hpp"
#include "gateway/links/key_folder.hpp"

struct ssl_st;

namespace arkmesh::gateway {

class TlsKeys {
 public:
  // Throws hal::ConfigError when the lab has no key there that can be used.
  TlsKeys(KeyFolder folder, std::string lab);
  TlsKeys(const TlsKeys&) = delete;

  // Whose key it is. Dates do not count.
  struct Verdict {
    enum { unknown, revoked, trusted } standing = unknown;
    std::string lab;  // unless unknown
  };
  Verdict judge(const Pin& pin) const;

  // TLS 1.3, both sides with a certificate that judge() trusts. For connections that begin now; they keep it alive.
  boost::asio::ssl::context& context() const { return *context_; }
  // The same keys for packets. What it points to is valid until the next refresh().
  const Seals& seals() const { return seals_; }
  // Where the certificate goes that the other end of a connection shows, trusted or not.
  static void keep_shown(ssl_st* connection, X509Pointer& into);

  // Reads the folder again when it has changed; what cannot be read at the moment stays as it was.
  void refresh();
  // A certificate of that key was shown that counts until then.
  void saw(const Pin& pin, std::chrono::system_clock::time_point until);
  // Days until the certificate of a lab, this one or a trusted one, ends, when that is soon; negative: it has ended.
  std::optional<long> days_left(const std::string& lab) const;
  // What is wrong with the folder, in sentences.
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  void read();

  const KeyFolder folder_;
  const std::string lab_;
  std::string stamp_;
  std::unique_ptr<boost::asio::ssl::context> context_;
  Certificate own_;
  Seals seals_;
  std::map<Pin, Certificate> trusted_, revoked_;
  std::map<Pin, std::chrono::system_clock::time_point> seen_;  // of trusted keys
  std::vector<std::string> errors_;
};

}  // namespace arkmesh::gateway
