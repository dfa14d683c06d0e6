// Counts as people read them: the same as in the page (tests/view/modules_test.mjs).
#include "app/count_words.hpp"

#include <doctest/doctest.h>

using arkmesh::app::count_words;

TEST_CASE("a count's name gives its unit") {
  CHECK(count_words("flying.south_ppm", 975'000) == "flying south 97.5 %");
  CHECK(count_words("consensus.ms", 58'000) == "consensus 58.0 s");
  CHECK(count_words("ground.followed_ms", 190'060) == "ground followed 190.1 s");
  CHECK(count_words("sent_bytes", 1500) == "sent 1.5 kB");
  CHECK(count_words("harvested.south", 1200) == "harvested south 1200");
  CHECK(count_words("ms", 3) == "ms 3");
  CHECK(count_words("", 3) == " 3");
}
