#include "common/math/nearest_name.hpp"

#include "catch.hpp"

namespace crsm {

TEST_CASE("a letter that is inserted, removed, replaced or swapped is one change") {
  CHECK(EditDistance("sick", "sick") == 0);
  CHECK(EditDistance("sicck", "sick") == 1);
  CHECK(EditDistance("sik", "sick") == 1);
  CHECK(EditDistance("sock", "sick") == 1);
  CHECK(EditDistance("preste", "preset") == 1);
  CHECK(EditDistance("", "sick") == 4);
  CHECK(EditDistance("sick", "") == 4);
  CHECK(EditDistance("kitten", "sitting") == 3);  // the usual example
  CHECK(EditDistance("ca", "abc") == 3);          // 2 if swapped letters might be changed again
}

TEST_CASE("capital and small letters are the same") {
  CHECK(EditDistance("LASER", "laser") == 0);
  CHECK(FindNearestName("laser", {"POSE", "LASER"}) == "LASER");
}

TEST_CASE("the nearest name is found, if no more than a third of the letters differ") {
  const std::vector<std::string> names{"paper", "rplidar-a1", "sick", "urg-04lx", "utm-30lx"};
  CHECK(FindNearestName("sik", names) == "sick");
  CHECK(FindNearestName("rplidr-a", names) == "rplidar-a1");
  CHECK(FindNearestName("utm-30", names) == "utm-30lx");  // 2 of 6
  CHECK(FindNearestName("utm-3", names).empty());         // 3 of 5
  CHECK(FindNearestName("best", names).empty());
  CHECK(FindNearestName("si", {"sik"}).empty());  // of two letters, none may differ
}

TEST_CASE("of names that are equally near the first is taken, and without any there is none") {
  CHECK(FindNearestName("env5", {"env1", "env2"}) == "env1");
  CHECK(FindNearestName("env1", {}).empty());
  CHECK(FindNearestName("", {"a"}).empty());
  CHECK(FindNearestName(std::string(101, 'a'), {std::string(101, 'a')}).empty());
}

TEST_CASE("a suggestion ends a line, and is left out if no name is near") {
  CHECK(SuggestName("corridr", {"corridor", "demo"}, "sim:") == "; did you mean sim:corridor?");
  CHECK(SuggestName("sik", {"sick"}) == "; did you mean sick?");
  CHECK(SuggestName("best", {"sick"}).empty());
}

}  // namespace crsm
