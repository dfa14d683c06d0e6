// What a lab shows browsers with: they know no Ed25519, which is the lab's own key, so it is a key of its own, for
// ECDSA (P-256). Whoever keeps it gets the same again, so that people tell their browser once that they trust it. Pure,
// but for chance.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::gateway {

struct BrowserCertificate {
  std::string pem;          // the key and its certificate, which says itself whom it is of
  std::string fingerprint;  // of the certificate, SHA-256 as browsers show it: "AB:CD:..."
};

// Of lab `lab`, for servers that are reached as `hosts`: names and IP addresses. Lasts certificate_life. `before`: the
// pem of last time, or anything else. It is given back when it is for the same lab and names and does not end soon;
// else its key, if it holds one, gets another certificate. Throws std::runtime_error when OpenSSL cannot.
BrowserCertificate browser_certificate(const std::string& lab, const std::vector<std::string>& hosts,
                                       std::string_view before = {});

}  // namespace arkmesh::gateway
