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

Lines Look(JoinNews& news, const MapPieces& pieces) { return Describe(news.Look(pieces)); }

}  // namespace

TEST_CASE("a trajectory that begins floats, and is joined when it is") {
  JoinNews news;
  CHECK(Look(news, Pieces({1})).empty());
  CHECK(Look(news, Pieces({1, 2})) == Lines{"floating: not joined to the map yet (trajectory 1)"});
  CHECK(Look(news, Pieces({1, 2})).empty());
  CHECK(Look(news, Pieces({1, 2, 3})) == Lines{"floating: not joined to the map yet (trajectory 2)"});
  CHECK(Look(news, Pieces({1, 2, 1})) == Lines{"joined: trajectory 2 with the map"});
  CHECK(Look(news, Pieces({1, 1, 1})) == Lines{"joined: trajectory 1 with the map"});
  CHECK(Look(news, Pieces({1, 1, 1, 1})) == Lines{"joined: trajectory 3 with the map"});  // at once
}

TEST_CASE("what floats together is a join, and falls apart again") {
  JoinNews news;
  Look(news, Pieces({1, 2, 3}));
  CHECK(Look(news, Pieces({1, 2, 2})) == Lines{"joined: trajectory 2 with trajectory 1, both float"});
  CHECK(Look(news, Pieces({1, 2, 3})) == Lines{"a join was rejected: trajectory 2 is a part of its own again"});
}

TEST_CASE("that another piece is the larger one now is said, and is no join") {
  const std::string other = "another piece is the larger one now and is shown (trajectory 1); the one before floats";
  JoinNews news;
  Look(news, Pieces({1, 2, 3}));
  CHECK(Look(news, Pieces({2, 1, 3})) == Lines{other});
  CHECK(Look(news, Pieces({3, 1, 2})).empty());  // of what is not shown the larger one
  CHECK(Look(news, Pieces({2, 1, 1})) == Lines{"joined: trajectory 2 with the map"});
  CHECK(Look(news, Pieces({2, 3, 1})).size() == 1);  // rejected: a part of what was shown is still shown
  CHECK(Look(news, Pieces({2, 1, 1, 3})).size() == 2);
  CHECK(Look(news, Pieces({1, 1, 1, 2})) == Lines{"joined: trajectory 1 with the map"});
  JoinNews joined;
  Look(joined, Pieces({1, 2, 3}));
  CHECK(Look(joined, Pieces({2, 1, 1})) == Lines{other, "joined: trajectory 2 with the map"});
}

TEST_CASE("whether the map that is shown is the one that the run began with is known without having looked before") {
  CHECK_FALSE(IsFirstElsewhere(Pieces({1})));
  CHECK_FALSE(IsFirstElsewhere(Pieces({1, 2})));
  CHECK(IsFirstElsewhere(Pieces({2, 1, 3})));
}

TEST_CASE("who looks late, at another map, or when an older break is told no more, learns no news") {
  JoinNews news;
  CHECK(Look(news, Pieces({1, 2, 1})).empty());
  CHECK(Look(news, Pieces({1})).empty());  // another map
  CHECK(Look(news, Pieces({1, 2})).size() == 1);
  CHECK(Look(news, Pieces({1, 2, 2})).size() == 1);
  CHECK(Look(news, Pieces({2, 2, 1}, 1)).empty());
  CHECK(Look(news, Pieces({2, 1}, 1)).empty());  // another map
  CHECK(Look(news, Pieces({2, 2, 1}, 1)) ==
        Lines{"another piece is the larger one now and is shown (trajectory 3); the one before floats",
              "joined: trajectory 2 with trajectory 1, both float"});
}

}  // namespace crsm
