#include "hal/config/without_secrets.hpp"

#include <algorithm>

namespace arkmesh::hal {

std::string without_secrets(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find_first_of(" \t\n\"',"));
    const std::size_t scheme = word.find("://");
    const bool is_url = scheme != std::string_view::npos;
    const std::size_t begin = is_url ? scheme + 3 : word.rfind('=', word.find(':')) + 1;
    std::string_view rest = word.substr(begin);
    // a server's password may hold what ends another URL's host
    const bool is_server = !is_url || word.substr(0, scheme).ends_with("nats");
    const std::size_t at = rest.substr(0, is_server ? rest.size() : rest.find_first_of("/?#")).rfind('@');
    if (at != std::string_view::npos && (is_url || rest.substr(0, at).find(':') != std::string_view::npos))
      rest.remove_prefix(at + 1);
    // that of a bus holds none
    const bool has_query = is_url && !word.substr(0, scheme).ends_with("udpm");
    const std::size_t query = has_query ? rest.find('?') : std::string_view::npos;
    out.append(word.substr(0, begin)).append(rest.substr(0, query));
    if (query != std::string_view::npos) out += "?...";
    text.remove_prefix(word.size());
    out += text.substr(0, 1);  // what parts the words
    text.remove_prefix(std::min<std::size_t>(1, text.size()));
  }
  return out;
}

}  // namespace arkmesh::hal
