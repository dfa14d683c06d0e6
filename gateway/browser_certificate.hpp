// What a lab shows browsers with: they know no Ed25519, which is the lab's own key, so it is a key for ECDSA (P-256)
// that is made of the lab's. The same lab key gives the same key and certificate, byte for byte, so that people tell
// their browser once that they trust it. Pure.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace arkmesh::gateway {

struct BrowserCertificate {
  std::string key_pem, certificate_pem;
  std::string fingerprint;  // SHA-256 as browsers show it: "AB:CD:..."
};

// Of lab `lab` with that key and certificate (KeyFolder::own), for servers that are reached as `hosts`: names and IP
// addresses. Lasts as long as the lab's certificate. `before`: the certificate of last time, which is given back when
// it is for the same key, names and dates; or anything else. Throws hal::ConfigError when the key is no Ed25519 key.
BrowserCertificate browser_certificate(std::string_view lab_key_pem, std::string_view lab_certificate_pem,
                                       const std::string& lab, const std::vector<std::string>& hosts,
                                       std::string_view before = {});

}  // namespace arkmesh::gateway
