// What waits for a viewer, how much of it, and in which order it goes.
#include "view/viewer_outbox.hpp"

#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <vector>

namespace arkmesh::tests {
namespace {

view::Parcel parcel(std::string text) {
  return {std::make_shared<const std::string>(std::move(text)), true};
}
std::string all_of(view::ViewerOutbox& out) {
  std::string text;
  while (const auto next = out.take()) text += *next->bytes + " ";
  return text;
}

TEST_CASE("words go first, then answers, events, and the newest of each channel, the longest waiting first") {
  view::ViewerOutbox out;
  out.newest(3, parcel("three"));
  out.newest(1, parcel("one"));
  out.newest(3, parcel("newer three"));
  out.event(parcel("event"));
  CHECK(out.answer("answer", true));
  CHECK(out.say("word"));
  CHECK_FALSE(out.empty());
  CHECK(all_of(out) == "word answer event newer three one ");
  CHECK(out.empty());
  CHECK(out.replaced() == 1);
  out.newest(3, parcel("again"));
  CHECK(all_of(out) == "again ");
  CHECK(out.replaced() == 1);
}

TEST_CASE("binary messages that wait go as one bundle, texts and long ones alone") {
  view::ViewerOutbox out;
  const auto binary = [](std::string bytes) {
    return view::Parcel{std::make_shared<const std::string>(std::move(bytes))};
  };
  out.newest(0, binary("ab"));
  CHECK(*out.take()->bytes == "ab");
  out.newest(0, binary("ab"));
  out.newest(1, binary("c"));
  out.newest(2, parcel("text"));
  out.newest(3, binary(std::string(300'000, 'x')));
  out.newest(4, binary("d"));
  CHECK(*out.take()->bytes == std::string("\3\0\0\0\2\0\0\0ab\1\0\0\0c", 15));
  CHECK(*out.take()->bytes == "text");
  CHECK(out.take()->bytes->size() == 300'000);
  CHECK(*out.take()->bytes == "d");
  CHECK(out.empty());
  // A bundle joins another one as what is in it.
  out.newest(0, binary("ab"));
  out.newest(1, binary(view::bundle(std::vector<std::string>{"c", "d"})));
  CHECK(*out.take()->bytes == std::string("\3\0\0\0\2\0\0\0ab\1\0\0\0c\1\0\0\0d", 20));
  CHECK(out.empty());
}

TEST_CASE("what waits is bounded: words and answers are refused, the oldest events give way") {
  view::ViewerOutbox out;
  std::size_t words = 0;
  while (out.say("word")) ++words;
  CHECK(words == view::ViewerOutbox::max_words);
  const std::string mebibyte(1 << 20, 'x');
  std::size_t answers = 0;
  while (out.answer(mebibyte, false)) ++answers;
  CHECK(answers == view::ViewerOutbox::max_answer_bytes >> 20);
  CHECK(out.busy());
  for (std::size_t i = 0; i < view::ViewerOutbox::max_events + 10; ++i) out.event(parcel(std::to_string(i)));
  CHECK(out.replaced() == 10);
  for (std::size_t i = 0; i < words + answers; ++i) out.take();
  CHECK_FALSE(out.busy());
  CHECK(*out.take()->bytes == "10");
  CHECK(out.answer(mebibyte, false));  // there is room again
}

TEST_CASE("a frame is as the protocol says, byte for byte") {
  const std::string data = "data";
  const std::string bytes = view::frame(view::Kind::picture, 2, 0x01020304, -2, "cam", std::as_bytes(std::span(data)));
  CHECK(bytes == std::string("\x02\x02\x03\x00\x04\x03\x02\x01\xfe\xff\xff\xff\xff\xff\xff\xff"
                             "camdata",
                             23));
}

}  // namespace
}  // namespace arkmesh::tests
