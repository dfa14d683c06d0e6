// Types as data: they are those that lcm-gen made, and messages come apart by them as by generated code, damaged ones
// too.
#include <doctest/doctest.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "arkmesh/arena_info_t.hpp"
#include "arkmesh/from_robots_t.hpp"
#include "arkmesh/lab_status_t.hpp"
#include "arkmesh/operator_command_t.hpp"
#include "arkmesh/overlay_t.hpp"
#include "arkmesh/peers_t.hpp"
#include "arkmesh/pose_frame_t.hpp"
#include "arkmesh/shared_view_t.hpp"
#include "arkmesh/to_robots_t.hpp"
#include "arkmesh/world_t.hpp"
#include "hal/layout/message.hpp"
#include "hal/layout/types.hpp"

using namespace arkmesh;
using namespace arkmesh::hal::layout;

namespace {

template <class Message>
std::uint64_t hash_of() {
  return static_cast<std::uint64_t>(Message::getHash());
}

template <class Message>
std::vector<std::byte> encoded(const Message& message) {
  std::vector<std::byte> out(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(out.data(), 0, static_cast<int>(out.size()));
  return out;
}

// What a visitor is shown, as text.
class Listing : public Visitor {
 public:
  void value(const Field& field, const Value& value) override {
    text += field.name + "=";
    if (value.kind == Kind::text)
      text += value.text;
    else if (value.kind == Kind::float32 || value.kind == Kind::float64)
      text += std::to_string(value.real);
    else
      text += std::to_string(value.integer);
    text += " ";
  }
  void bytes(const Field& field, std::span<const std::byte> bytes) override {
    text += field.name + "=" + std::to_string(bytes.size()) + "B ";
  }
  void begin_list(const Field& field, std::size_t count) override {
    text += field.name + "[" + std::to_string(count) + "] ";
  }
  void end_list(const Field&) override {}
  void begin_record(const Field&, std::size_t place) override { text += std::to_string(place) + "{ "; }
  void end_record(const Field&) override { text += "} "; }

  std::string text;
};

pose_frame_t two_robots() {
  pose_frame_t frame{};
  frame.stamp_us = 1'500'000;
  frame.number = 15;
  frame.parts = 1;
  frame.n_robots = 2;
  frame.robots.resize(2);
  frame.robots[0].robot = 3;
  frame.robots[0].x_m = -0.25;
  frame.robots[1].robot = 1022;
  frame.robots[1].led = 7;
  frame.robots[1].confidence = 0.5F;
  frame.robots[1].age_us = -1;
  return frame;
}

}  // namespace

TEST_CASE("types have the fingerprints that generated code has") {
  const auto is = [](const char* name) {
    const Type* type = types().find(name);
    REQUIRE(type);
    return type->fingerprint;
  };
  CHECK(is("pose_frame_t") == hash_of<pose_frame_t>());
  CHECK(is("world_t") == hash_of<world_t>());
  CHECK(is("shared_view_t") == hash_of<shared_view_t>());
  CHECK(is("overlay_t") == hash_of<overlay_t>());
  CHECK(is("peers_t") == hash_of<peers_t>());
  CHECK(is("operator_command_t") == hash_of<operator_command_t>());
  CHECK(is("lab_status_t") == hash_of<lab_status_t>());
  CHECK(is("arena_info_t") == hash_of<arena_info_t>());
  CHECK(is("from_robots_t") == hash_of<from_robots_t>());
  CHECK(is("to_robots_t") == hash_of<to_robots_t>());
}

TEST_CASE("channels have their types, those of other labs too") {
  REQUIRE(types().of_channel("poses"));
  CHECK(types().of_channel("poses")->name == "pose_frame_t");
  CHECK(types().of_channel("shark/world")->name == "world_t");
  CHECK(types().of_channel("nothing") == nullptr);
}

TEST_CASE("a field tells its unit and what the .lcm file says of it") {
  const Type* type = types().find("robot_pose_t");
  REQUIRE(type);
  CHECK(type->fields[1].name == "x_m");
  CHECK(type->fields[1].unit == "m");
  CHECK(type->fields[1].comment.starts_with("arena frame"));
  CHECK(type->is_fixed);
  CHECK(type->least_bytes == 4 + 3 * 8 + 1 + 4 + 4);
}

TEST_CASE("a message comes apart into what was put in") {
  const auto bytes = encoded(two_robots());
  const Type* type = type_of(bytes, types());
  REQUIRE(type);
  CHECK(type->name == "pose_frame_t");
  CHECK(check(*type, bytes) == "");
  Listing listing;
  visit(*type, bytes, listing);
  CHECK(listing.text ==
        "stamp_us=1500000 number=15 part=0 parts=1 n_objects=0 n_robots=2 objects[0] robots[2] "
        "0{ robot=3 x_m=-0.250000 y_m=0.000000 heading_rad=0.000000 led=0 confidence=0.000000 age_us=0 } "
        "1{ robot=1022 x_m=0.000000 y_m=0.000000 heading_rad=0.000000 led=7 confidence=0.500000 age_us=-1 } ");
}

TEST_CASE("texts, nested lists and bytes come apart") {
  world_t world{};
  world.lab = "shark";
  world.n_states = 1;
  world.window.resize(1);
  world.window[0].n_fields = 1;
  world.window[0].fields.resize(1);
  world.window[0].fields[0].name = "team";
  world.window[0].fields[0].n = 2;
  world.window[0].fields[0].values = {5, -7};
  Listing listing;
  const auto bytes = encoded(world);
  CHECK(check(*types().find("world_t"), bytes) == "");
  visit(*types().find("world_t"), bytes, listing);
  CHECK(listing.text.find("lab=shark") == 0);
  CHECK(listing.text.find("fields[1] 0{ name=team n=2 values[2] values=5 values=-7 }") != std::string::npos);

  Listing command;
  visit(*types().find("operator_command_t"), encoded(operator_command_t{}), command);
  CHECK(command.text.find("proof=64B") != std::string::npos);
}

TEST_CASE("a message that is cut, grown or forged is refused with the reason") {
  const auto whole = encoded(two_robots());
  const Type& type = *types().find("pose_frame_t");
  for (std::size_t size = 0; size < whole.size(); ++size) CHECK(check(type, std::span(whole).first(size)) != "");
  auto bytes = whole;
  bytes.push_back(std::byte{0});
  CHECK(check(type, bytes) == "trailing");
  bytes = whole;
  bytes[0] ^= std::byte{1};
  CHECK(check(type, bytes) == "fingerprint");
  CHECK(type_of(bytes, types()) == nullptr);
  bytes = whole;
  for (int i = 0; i < 4; ++i) bytes[8 + 8 + 4 * 4 + static_cast<std::size_t>(i)] = std::byte{0xff};  // n_robots = -1
  CHECK(check(type, bytes) == "count");
  bytes[8 + 8 + 4 * 4] = std::byte{0x7f};  // 2^31 - 1 robots
  CHECK(check(type, bytes) == "count");
}

TEST_CASE("a text may be as long as the reader allows, its final zero included") {
  world_t world{};
  world.lab = "shark";
  const auto bytes = encoded(world);
  CHECK(check(type_for<world_t>(), bytes, 6) == "");
  CHECK(check(type_for<world_t>(), bytes, 5) == "text");
}
