#include "services/map_viewer/join_news.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

using Lines = std::vector<std::string>;

/// Of trajectories on pieces of these numbers, the first of all before all others. num_untold: older breaks.
MapPieces Pieces(const std::vector<int>& numbers, std::int64_t num_untold = 0) {
  MapPieces pieces;
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    Break at;
    at.piece_before = numbers[i - 1];
    at.piece = numbers[i];
    pieces.breaks.push_back(at);
  }
  pieces.num_breaks = std::ssize(pieces.breaks) + num_untold;
  return pieces;
}

}  // namespace

TEST_CASE("a trajectory that begins floats, and is joined when it is") {
  JoinNews news;
  CHECK(news.Look(Pieces({1})).empty());
  CHECK(news.Look(Pieces({1, 2})) == Lines{"floating: not joined to the map yet (trajectory 1)"});
  CHECK(news.Look(Pieces({1, 2})).empty());
  CHECK(news.Look(Pieces({1, 2, 3})) == Lines{"floating: not joined to the map yet (trajectory 2)"});
  CHECK(news.Look(Pieces({1, 2, 1})) == Lines{"joined: trajectory 2 with the map"});
  CHECK(news.Look(Pieces({1, 1, 1})) == Lines{"joined: trajectory 1 with the map"});
  CHECK(news.Look(Pieces({1, 1, 1, 1})) == Lines{"joined: trajectory 3 with the map"});  // at once
}

TEST_CASE("that another piece is the largest by now is no join; what floats together is one, and falls apart again") {
  JoinNews news;
  news.Look(Pieces({1, 2, 3}));
  CHECK(news.Look(Pieces({2, 1, 3})).empty());
  CHECK(news.Look(Pieces({1, 2, 2})) == Lines{"joined: trajectory 2 with trajectory 1, both float"});
  CHECK(news.Look(Pieces({2, 1, 1})).empty());
  CHECK(news.Look(Pieces({1, 2, 3})) == Lines{"a join was rejected: trajectory 2 is a part of its own again"});
}

TEST_CASE("who looks late, at another map, or when an older break is told no more, learns no news") {
  JoinNews news;
  CHECK(news.Look(Pieces({1, 2, 1})).empty());
  CHECK(news.Look(Pieces({1})).empty());  // another map
  CHECK(news.Look(Pieces({1, 2})).size() == 1);
  CHECK(news.Look(Pieces({1, 2, 2})).size() == 1);
  CHECK(news.Look(Pieces({2, 2, 1}, 1)).empty());
  CHECK(news.Look(Pieces({2, 1}, 1)).empty());  // another map
  CHECK(news.Look(Pieces({2, 2, 1}, 1)) == Lines{"joined: trajectory 2 with trajectory 1, both float"});
}

}  // namespace crsm
