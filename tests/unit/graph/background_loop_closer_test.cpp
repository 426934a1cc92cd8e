#include "common/graph/background_loop_closer.hpp"

#include <atomic>
#include <cmath>
#include <stdexcept>

#include "catch.hpp"
#include "common/graph/default_loop_closer.hpp"
#include "graph/block.hpp"

namespace crsm {
namespace {

const LoopParameters kLoops;

std::vector<Keyframe> MakeRound() {
  return MakeKeyframes(MakeBlock(7), DriveRoundBlock(5.0, 5.0 + 1.2 * kRoundBlock_m), {0.0, 0.001, 0.0008}, 7);
}

std::unique_ptr<LoopCloser> MakeCloser() { return DefaultLoopCloser(kLoops, UpdateParameters{})(); }

/// The updates of a LoopCloser, without a thread.
std::vector<GraphUpdate> FindAll(const std::vector<Keyframe>& keyframes) {
  const auto closer = MakeCloser();
  std::vector<GraphUpdate> updates;
  for (const Keyframe& keyframe : keyframes) {
    if (const auto update = closer->Add(keyframe, {})) updates.push_back(*update);
  }
  return updates;
}

}  // namespace

TEST_CASE("in the background the same is found, and given when as many keyframes have followed as are left out") {
  constexpr int kLeft = 9;
  const std::vector<Keyframe> keyframes = MakeRound();
  const std::vector<GraphUpdate> expected = FindAll(keyframes);
  REQUIRE(expected.size() >= 2);
  BackgroundLoopCloser closer(MakeCloser());
  std::vector<GraphUpdate> taken;
  for (int i = 0; i < static_cast<int>(keyframes.size()); ++i) {
    closer.Add(keyframes[static_cast<std::size_t>(i)], {});
    for (const GraphUpdate& update : closer.Take(kLeft)) {
      CHECK(update.keyframe == KeyframeId{0, i - kLeft});
      taken.push_back(update);
    }
    CHECK(closer.Take(kLeft).empty());
  }
  for (const GraphUpdate& update : closer.Take(0)) taken.push_back(update);
  CHECK(taken == expected);
  BackgroundLoopCloser never_asked(MakeCloser());  // searches all the same
  for (const Keyframe& keyframe : keyframes) never_asked.Add(keyframe, {});
  CHECK(never_asked.Take(0) == expected);
}

TEST_CASE("who waits for a search may give up, and what was found until then is there") {
  /// Searches the keyframe of a number until it is told to go on.
  class Slow : public LoopCloser {
   public:
    explicit Slow(std::atomic<bool>& may_go_on) : may_go_on_(may_go_on) {}
    std::optional<GraphUpdate> Add(Keyframe, const std::optional<EarlierSearch>&) override {
      if (++num_ > 3) may_go_on_.wait(false);
      GraphUpdate update;
      update.keyframe = {0, num_ - 1};
      return update;
    }
    const KeyframeGraph& graph() const override { return graph_; }

   private:
    std::atomic<bool>& may_go_on_;
    int num_ = 0;
    KeyframeGraph graph_;
  };
  const std::vector<Keyframe> keyframes = MakeRound();
  std::atomic<bool> may_go_on = false;
  BackgroundLoopCloser closer(std::make_unique<Slow>(may_go_on));
  int num_added = 0;
  int num_asked = 0;
  const auto GiveUp = [&] { return ++num_asked == 2; };
  while (num_asked == 0 && closer.Add(keyframes[0], {}, GiveUp)) ++num_added;  // until very many wait
  CHECK(num_added > 100);
  num_asked = 0;
  CHECK(closer.Await(0, GiveUp) == num_added - 3);
  CHECK(closer.Take(num_added - 3).size() == 3);
  may_go_on = true;
  may_go_on.notify_all();
  CHECK(closer.Await(0) == 0);
  CHECK(closer.Take(0).size() == static_cast<std::size_t>(num_added - 3));
}

TEST_CASE("what a search throws, who takes its updates gets") {
  std::vector<Keyframe> keyframes = MakeRound();
  keyframes[50].constraint = ProximityConstraint{{0, 0}, {NAN, 0.0, 0.0}};
  BackgroundLoopCloser closer(MakeCloser());
  for (const Keyframe& keyframe : keyframes) closer.Add(keyframe, {});
  CHECK_THROWS_AS(closer.Take(0), std::invalid_argument);
  CHECK_THROWS_AS(closer.Take(0), std::invalid_argument);
}

TEST_CASE("a loop closer ends while keyframes wait") {
  const std::vector<Keyframe> keyframes = MakeRound();
  BackgroundLoopCloser closer(MakeCloser());
  for (std::size_t i = 0; i < 90; ++i) closer.Add(keyframes[i], {});
  BackgroundLoopCloser idle(MakeCloser());
  CHECK(idle.Take(0).empty());
}

}  // namespace crsm
