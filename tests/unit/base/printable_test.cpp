#include "services/base/printable.hpp"

#include "catch.hpp"

using namespace crsm;

TEST_CASE("what makes a terminal do something becomes a question mark, and letters of all languages stay") {
  CHECK(WithoutControls("a\x1b[2J\nb\x07\x7f") == "a?[2J?b??");
  CHECK(WithoutControls("a\xc2\x9b"
                        "2J") == "a??2J");
  CHECK(WithoutControls("a\x9b"
                        "2J") == "a?2J");
  for (const char* text : {"Grüße, ÀÉ", "地図 – “map”", "", "plain"}) CHECK(WithoutControls(text) == text);
}
