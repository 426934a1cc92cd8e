#include "common/graph/background_map_error.hpp"

#include <thread>

#include "catch.hpp"

namespace crsm {
namespace {

KnownMotions Straight(int num) {
  KeyframeGraph graph;
  for (int i = 0; i < num; ++i) {
    Keyframe keyframe;
    keyframe.utime = (i + 1) * 1'000'000;
    if (i > 0) keyframe.T_previous_this = {0.4, 0.0, 0.0};
    graph.Add(std::move(keyframe));
  }
  KnownMotions motions;
  motions.Add(graph, graph.poses(), {true}, {});
  return motions;
}

}  // namespace

TEST_CASE("how far off a map may be is estimated beside, and asked for anew only after a while") {
  BackgroundMapError beside;
  int num_asked = 0;
  const auto Find = [&] {
    return beside.Find([&] {
      ++num_asked;
      return Straight(500);
    });
  };
  CHECK_FALSE(Find());  // nobody waits for it
  std::optional<MapError> found;
  for (int i = 0; i < 1000 && !found; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    found = Find();
  }
  REQUIRE(found);
  MapError expected = *EstimateMapError(Straight(500), {}, false);
  CHECK(*found == expected);
  CHECK(num_asked == 1);
  for (int i = 0; i < 100; ++i) CHECK(Find() == found);  // it costs a twentieth of a core
  CHECK(num_asked == 1);
}

}  // namespace crsm
