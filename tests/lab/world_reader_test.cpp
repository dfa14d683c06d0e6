// One reading of a message for all labs of a process.
#include "lab/exchange/world_reader.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

namespace arkmesh::lab {
namespace {

std::vector<std::byte> bytes_of(const WorldMessage& message) {
  const world_t world = to_message(message);
  std::vector<std::byte> out(static_cast<std::size_t>(world.getEncodedSize()));
  world.encode(out.data(), 0, static_cast<int>(out.size()));
  return out;
}

}  // namespace

TEST_CASE("the same bytes of a lab are read once, others anew, and what was read stays as it is") {
  WorldReader reader;
  std::string_view why;
  const auto one = bytes_of({.lab = "b", .run_id = 2}), other = bytes_of({.lab = "b", .run_id = 3});
  const auto first = reader.read("b", one, why);
  REQUIRE(first);
  CHECK(reader.read("b", one, why) == first);
  CHECK(reader.read("c", one, why) != first);  // the gate refuses it by its name
  const auto second = reader.read("b", other, why);
  CHECK(second != first);
  CHECK(second->run_id == 3);
  CHECK(first->run_id == 2);
}

TEST_CASE("what cannot be read is refused with its reason each time, and takes nobody's place") {
  WorldReader reader;
  std::string_view why;
  const auto good = bytes_of({.lab = "b", .run_id = 2});
  const auto read = reader.read("b", good, why);
  for (int i = 0; i < 2; ++i) {
    CHECK(reader.read("b", std::span(good).first(9), why) == nullptr);
    CHECK_FALSE(why.empty());
  }
  CHECK(reader.read("b", good, why) == read);
  CHECK(why.empty());
}

TEST_CASE("names without end take no memory without end") {
  WorldReader reader;
  std::string_view why;
  const auto bytes = bytes_of({.lab = "b", .run_id = 2});
  const std::weak_ptr<const WorldMessage> first = reader.read("b", bytes, why);
  for (int i = 0; i < 100; ++i) CHECK(reader.read(fmt::format("x{}", i), bytes, why));
  CHECK(first.expired());
}

}  // namespace arkmesh::lab
