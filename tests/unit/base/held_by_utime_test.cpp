#include "services/base/held_by_utime.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

struct Item {
  std::int64_t utime = 0;
  int number = 0;
};

}  // namespace

TEST_CASE("an item is found by its utime, and one that comes again is the same item") {
  HeldByUtime<Item, 3> items;
  CHECK(items.Find(5) == nullptr);
  items.Hold({5, 50});
  items.Hold({3, 30});
  items.Hold({5, 51});
  REQUIRE(items.Find(5));
  CHECK(items.Find(5)->number == 50);
  REQUIRE(items.Find(3));
  CHECK(items.Find(3)->number == 30);
  CHECK(items.Find(4) == nullptr);
}

TEST_CASE("the item that came first gives way to one too many") {
  HeldByUtime<Item, 3> items;
  for (const int utime : {9, 2, 7, 4}) items.Hold({utime});
  CHECK_FALSE(items.Find(9));
  for (const int utime : {2, 7, 4}) CHECK(items.Find(utime));
}

TEST_CASE("an item is dropped with all that came before it") {
  HeldByUtime<Item, 5> items;
  for (const int utime : {9, 2, 7, 4}) items.Hold({utime});
  items.DropThrough(8);
  CHECK(items.Find(9));
  items.DropThrough(2);
  CHECK_FALSE(items.Find(9));
  CHECK_FALSE(items.Find(2));
  CHECK(items.Find(7));
  items.DropThrough(4);
  for (const int utime : {7, 4}) CHECK_FALSE(items.Find(utime));
  items.DropThrough(4);
  for (const int number : {41, 42}) items.Hold({4, number});  // it may come again, also as the newest of all
  REQUIRE(items.Find(4));
  CHECK(items.Find(4)->number == 41);
}

}  // namespace crsm
