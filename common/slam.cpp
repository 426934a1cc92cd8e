#include "common/slam.hpp"

#include <algorithm>

#include "common/graph/default_loop_closer.hpp"
#include "common/graph/draw_scans.hpp"

namespace crsm {

Slam::Slam(const Parameters& parameters, const Parts& parts, const Constants& constants)
    : drawing_{parameters.update, constants.drawing, constants.paper_drawing},
      matching_{parameters.loops.loops, constants.match},
      selector_(parameters.scan, parts.select ? parts.select : DefaultSelection(parameters, constants.selection),
                constants.selection.valid_rays),
      matcher_((parts.make_matcher ? parts.make_matcher
                                   : DefaultMatcher(parameters, constants.match, constants.paper_match))(
          parameters.update.cell_size_m)),
      mapper_(drawing_, parameters.loops, constants.graph, constants.match),
      loop_closer_(std::make_unique<BackgroundLoopCloser>((
          parts.make_loop_closer ? parts.make_loop_closer
                                 : DefaultLoopCloser(parameters.loops, drawing_, constants.graph, constants.match))())),
      tracking_(constants.match) {}

Slam::Step Slam::Process(const LaserScan& scan, const std::optional<Pose2>& T_odom_robot) {
  DrawRestored();
  Step step;
  step.scan = selector_.Select(scan);
  step.match = MatchScan(*matcher_, step.scan, tracking_, T_odom_robot, matching_);
  step.match.map_version = map_version();
  step.drawn = Take(mapper_.Integrate(&step.scan, step.match), step.match);
  step.updates = AcceptFound(std::max(0, mapper_.lag() - 1));  // before they would be taken up with the next keyframe
  return step;
}

void Slam::DrawRestored() { matcher_->Apply(mapper_.DrawPutOff()); }

/// What has become of a scan is remembered. Whether it was drawn.
bool Slam::Take(const Mapper::Step& step, const ScanMatch& match) {
  matcher_->Apply(step.delta.tiles);
  tracking_.Add(match, step.after);
  return step.delta.drawn;
}

/// Has loops searched at the keyframes that are new to the loop closer, up to one of them, but for what an earlier
/// session has found. update: of the last of them, by that session.
void Slam::SearchUpTo(std::optional<KeyframeId> last, const GraphUpdate* update,
                      const BackgroundLoopCloser::GiveUp& give_up) {
  const KeyframeGraph& graph = mapper_.graph();
  while (given_ < last) {
    const KeyframeId next = given_ ? *graph.After(*given_) : KeyframeId{};
    auto earlier = mapper_.FindSearch(next);
    if (earlier && update && next == last) earlier->update = std::make_shared<const GraphUpdate>(*update);
    if (!loop_closer_->Add(graph.keyframe(next), earlier, give_up)) return;
    if (!earlier) ++num_searched_;
    given_ = next;
  }
}

/// Tells the mapper what was found by all keyframes but the newest ones. Returns what it did not know.
std::vector<GraphUpdate> Slam::AcceptFound(int num_left, const BackgroundLoopCloser::GiveUp& give_up) {
  SearchUpTo(mapper_.graph().newest(), nullptr, give_up);
  num_left = loop_closer_->Await(num_left, give_up);
  std::vector<GraphUpdate> found = loop_closer_->Take(num_left);
  std::erase_if(found, [&](const GraphUpdate& update) { return !mapper_.Accept(update); });
  auto searched = std::min(given_, mapper_.graph().newest());
  for (int i = 0; i < num_left && searched; ++i) searched = mapper_.graph().Before(*searched);
  if (searched) mapper_.NoteSearched(*searched);
  return found;
}

bool Slam::Restore(const CriticalRays* scan, const ScanMatch& match) {
  if (map_version() == 0) mapper_.PutOffDrawing();
  return Take(mapper_.Restore(scan, match), match);
}

bool Slam::Restore(const GraphUpdate& update) {
  if (!mapper_.Accept(update)) return false;
  if (update.ChangesGraph()) SearchUpTo(update.keyframe, &update);  // which need not be solved once more
  return true;
}

bool Slam::RestoreSearched(KeyframeId keyframe) { return mapper_.NoteSearched(keyframe); }

std::vector<GraphUpdate> Slam::AwaitLoops(const BackgroundLoopCloser::GiveUp& give_up) {
  DrawRestored();
  return AcceptFound(0, give_up);
}

void Slam::Resume(const std::optional<Pose2>& T_map_laser) {
  T_map_laser ? tracking_.BeginSessionNear(*T_map_laser) : tracking_.BeginSession(Onset::kResumed);
}

void Slam::BeginDrive() {
  if (tracking_.on_finished_map()) {
    tracking_ = TrackingState::OnFinishedMap(matching_.constants);
  } else {
    tracking_.BeginSession(Onset::kAnywhere);
  }
}

void Slam::FinishMap(const BackgroundLoopCloser::GiveUp& give_up) {
  if (mapper_.searched() < mapper_.graph().newest()) AwaitLoops(give_up);
  matcher_->Apply(mapper_.Finish());
  tracking_ = TrackingState::OnFinishedMap(matching_.constants);
}

Slam::Outcome Slam::Finalize(std::span<ScanMatch> matches) {
  AwaitLoops();
  std::int64_t scan = 0;
  for (ScanMatch& match : matches) match = mapper_.BestMatch(scan++, match);
  return {DrawPiece(1), mapper_.MakeBestGraph(), mapper_.PlaceLoops()};
}

ByteMap Slam::DrawPiece(int number) const {
  const KeyframeGraph& graph = mapper_.graph();
  const int component = mapper_.FindComponent(number);
  std::vector<PlacedScan> scans;
  for (const KeyframeId id : graph.ids()) {
    if (!mapper_.IsKeyframeOf(component, id)) continue;
    scans.push_back({graph.keyframe(id).rays, At(mapper_.best_poses(), id)});
  }
  return DrawScans(drawing_, scans);
}

}  // namespace crsm
