// The newest of each channel: messages that stand alone, and frames that come as several.
#include "view/channels.hpp"

#include <doctest/doctest.h>

#include <string>

#include "view/viewer_outbox.hpp"

namespace arkmesh::tests {
namespace {

struct Bench {
  view::Channels channels;
  void note(const std::string& data, view::Part part = {}) {
    channels.note(view::Kind::message, 0, 5, "poses", std::as_bytes(std::span(data)), part);
  }
  // The bytes of what viewers get next; empty: nothing new.
  std::string fresh() {
    const auto all = channels.take_fresh();
    return all.empty() ? std::string() : *all.front().parcel.bytes;
  }
  std::uint64_t missing() const { return channels.counters()["view.skipped.part_missing"]; }
};

std::string framed(const std::string& data) {
  return view::frame(view::Kind::message, 0, 0, 5, "poses", std::as_bytes(std::span(data)));
}
std::string bundled(const std::vector<std::string>& frames) {
  return view::bundle(frames);
}

TEST_CASE("viewers get a frame of several parts when it is whole, as one bundle, and late ones the same") {
  Bench bench;
  bench.note("a", {1, 0, 3});
  bench.note("b", {1, 1, 3});
  CHECK(bench.fresh().empty());
  CHECK(bench.channels.all().empty());
  bench.note("c", {1, 2, 3});
  const std::string whole = bundled({framed("a"), framed("b"), framed("c")});
  CHECK(bench.fresh() == whole);
  bench.note("d", {2, 0, 3});
  CHECK(bench.fresh().empty());  // the former one stays until this is whole
  CHECK(*bench.channels.all().front().parcel.bytes == whole);
  bench.note("e", {2, 1, 3});
  bench.note("f", {2, 2, 3});
  CHECK(bench.fresh() == bundled({framed("d"), framed("e"), framed("f")}));
  bench.note("alone", {3, 0, 1});
  CHECK(bench.fresh() == framed("alone"));
  CHECK(bench.missing() == 0);
}

TEST_CASE("a frame of which a part is missing is counted once, and the next whole one is shown") {
  Bench bench;
  const auto whole = [&](std::int32_t frame) {
    for (int part = 0; part < 3; ++part) bench.note(std::to_string(part), {frame, part, 3});
    return bench.fresh() == bundled({framed("0"), framed("1"), framed("2")});
  };
  SUBCASE("the first one") {
    bench.note("1", {1, 1, 3});
    bench.note("2", {1, 2, 3});
  }
  SUBCASE("one in the middle") {
    bench.note("0", {1, 0, 3});
    bench.note("2", {1, 2, 3});
  }
  SUBCASE("the last one") {
    bench.note("0", {1, 0, 3});
    bench.note("1", {1, 1, 3});
  }
  SUBCASE("all after the first, and the lab begins anew with the same number") {
    bench.note("0", {2, 0, 3});
  }
  CHECK(bench.fresh().empty());
  CHECK(whole(2));
  CHECK(bench.missing() == 1);
  CHECK(whole(3));
  CHECK(bench.missing() == 1);
}

TEST_CASE("parts that never make a whole take no more room than a frame, and the room is given back") {
  Bench bench;
  const std::string part(view::Channels::max_bytes / 4, 'x');
  for (int frame = 0; frame < 20; ++frame)
    for (int i = 0; i < 2; ++i) bench.note(part, {frame, i, 3});
  CHECK(bench.missing() == 19);
  CHECK(bench.channels.counters()["view.skipped.too_many_bytes"] == 0);
  bench.note("x", {20, 0, 1});
  CHECK(bench.fresh() == framed("x"));
  // Now there is room for four more.
  for (int i = 0; i < 4; ++i) bench.note(part.substr(1), {21, i, 5});
  CHECK(bench.channels.counters()["view.skipped.too_many_bytes"] == 0);
}

}  // namespace
}  // namespace arkmesh::tests
