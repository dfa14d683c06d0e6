// Who goes with whom when everybody may stay alone: the assignment of greatest total gain, exact, over the few pairs
// that are possible at all. Successive shortest paths (the sparse form of Jonker and Volgenant), so 1000 robots with a
// handful of candidates each cost about as much as the candidates' number. The result depends on the candidates only,
// not on their order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace arkmesh::tracker {

// A possible pair and what it gains over leaving both alone. Pairs that gain nothing (<= 0) are never made.
struct Pairing {
  std::uint32_t row = 0, column = 0;
  double gain = 0;
};

inline constexpr std::int32_t alone = -1;

// For each row its column, or `alone`. Each (row, column) at most once; rows and columns below the two numbers.
std::vector<std::int32_t> assign(std::uint32_t rows, std::uint32_t columns, std::span<const Pairing> possible);

}  // namespace arkmesh::tracker
