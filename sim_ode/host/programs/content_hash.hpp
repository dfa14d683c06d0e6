// A name for bytes: 160 bits that no two contents share by chance. For files of our own; keeps no secrets.
#pragma once

#include <fmt/format.h>

#include <array>
#include <boost/uuid/detail/sha1.hpp>
#include <string>
#include <string_view>

namespace arkmesh::sim_ode {

class ContentHash {
 public:
  static constexpr std::size_t digits = 40;

  // Ends of parts count: "ab", "c" is not "a", "bc".
  void add(std::string_view part) {
    const std::uint64_t size = part.size();
    sha1_.process_bytes(&size, sizeof size);
    sha1_.process_bytes(part.data(), part.size());
  }
  // In hexadecimal, `digits` of them. Ends the hash's use.
  std::string name() {
    boost::uuids::detail::sha1::digest_type words;
    sha1_.get_digest(words);
    std::string out;
    for (const unsigned word : words) out += fmt::format("{:08x}", word);
    return out;
  }

 private:
  boost::uuids::detail::sha1 sha1_;
};

}  // namespace arkmesh::sim_ode
