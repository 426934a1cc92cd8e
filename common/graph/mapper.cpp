#include "common/graph/mapper.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <tuple>
#include <utility>

#include "common/graph/loop_search.hpp"
#include "common/scan/deskew.hpp"

namespace crsm {
namespace {

constexpr double kSurelyFarther_m = 1e-6;  // whatever the last bits say

/// Keyframes for the local map, oldest first.
struct LocalKeyframes {
  std::vector<KeyframeId> wanted;
  std::vector<KeyframeId> bearable;  ///< those, and others that need not be taken out of it yet
};

/// Wanted is what lies within some way along the graph. A keyframe beyond it that is far away as the crow flies, too,
/// saw few of the walls here, and does no harm.
LocalKeyframes FindLocal(const KeyframeGraph& graph, double local_map_m, const GraphConstants::LocalMap& constants) {
  const KeyframeId newest = *graph.newest();
  LocalKeyframes found;
  for (const auto& [id, way_m] : graph.FindWithin(newest, constants.bearable_reach * local_map_m)) {
    const bool wanted = way_m <= local_map_m;
    const double away_m = Length(Inverse(graph.pose(id)) * graph.pose(newest));
    if (wanted) found.wanted.push_back(id);
    if (wanted || away_m >= constants.far_away * local_map_m) found.bearable.push_back(id);
  }
  return found;
}

}  // namespace

Mapper::Mapper(const DrawingRules& drawing, const LoopParameters& loops, const GraphConstants& constants,
               const MatchConstants& match)
    : rules_(drawing),
      loops_(loops),
      constants_(constants),
      local_(drawing),
      moving_objects_(drawing.constants),
      graph_(constants.edges),
      trajectories_(match.breaks),
      uncertainty_(match.uncertainty) {}

Mapper::Step Mapper::Integrate(const CriticalRays* scan, const ScanMatch& match) {
  return Restore(IsOnKnownGround(match) ? nullptr : scan, match);
}

/// What may be drawn of a scan.
CriticalRays Mapper::WithoutMoving(const CriticalRays& scan, const Pose2& T_map_laser) const {
  if (rules_.parameters.algorithm == Algorithm::kPaper) return scan;
  return {scan.utime, moving_objects_.Filter(scan.rays, T_map_laser), {}};
}

Mapper::Step Mapper::Restore(const CriticalRays* scan, const ScanMatch& match) {
  std::optional<CriticalRays> deskewed;
  if (scan && !scan->rays.time_s.empty()) scan = &deskewed.emplace(Deskew(*scan, match.twist));
  const bool begins = loops_.loops && scan && match.state == MatchState::kFirst && graph_.size() > 0 &&
                      scan->rays.size() > 0 && local_.InLimits(scan->rays, match.T_map_laser);
  if (begins) moving_objects_.Clear();
  const CriticalRays* whole = scan;
  std::optional<CriticalRays> still;
  const bool may_be_drawn = scan && (begins || local_.MovedEnough(match.T_map_laser));
  if (may_be_drawn) scan = &still.emplace(WithoutMoving(*scan, match.T_map_laser));
  Step step{scan && !begins ? local_.Update(*scan, match) : local_.UpdateWithoutScan()};
  if (step.delta.drawn || begins) moving_objects_.Add(whole->rays, match.T_map_laser);
  if (!loops_.loops) return step;
  step.delta.drawn = step.delta.drawn || begins;
  if (match.state == MatchState::kLost) lost_since_ = true;
  if (by_wheels_) by_wheels_ = match.by_wheels ? std::optional(*by_wheels_ * *match.by_wheels) : std::nullopt;
  if (step.delta.drawn) AddKeyframe(scan->rays, match, begins);
  if (step.delta.drawn && !begins && put_off_) put_off_->push_back({false, {{*graph_.newest(), match.T_map_laser}}});
  trajectories_.Add(match, graph_.num_trajectories());
  AnchorScan(step.delta.version - 1);
  step.after.trajectory = std::max(0, graph_.num_trajectories() - 1);
  step.after.floating = floats_;
  if (!step.delta.drawn) return step;
  const KeyframeId newest = *graph_.newest();
  step.keyframe = &graph_.keyframe(newest);
  const Pose2 before = MatchedPose(newest);
  const std::vector<TileChange> tiles = FollowGraph(begins);
  step.delta.tiles.insert(step.delta.tiles.end(), tiles.begin(), tiles.end());
  if (!coming_) {  // all that was taken up has taken effect
    applied_update_ = taken_up_;
    floats_ = Floats();
  }
  if (MatchedPose(newest) != before) {
    step.after.T_new_old = MatchedPose(newest) * Inverse(before);
    moving_objects_.Move(*step.after.T_new_old);
  }
  step.after.floating = floats_;
  return step;
}

/// After a keyframe: what has become due is taken up, and what was drawn beside takes effect. What that changes of the
/// local map.
std::vector<TileChange> Mapper::FollowGraph(bool begins) {
  const KeyframeId newest = *graph_.newest();
  if (coming_ && !begins) return TakeDueDrawing();
  std::optional<KeyframePoses> poses_before;
  if (IsDue(constants_.lag)) poses_before = graph_.poses();
  const bool corrected = ApplyDue(constants_.lag);
  const bool looks = corrected || begins || graph_.path_m(newest) - looked_at_m_ >= constants_.local_map.period_m;
  if (!looks) return DrawMissing();
  looked_at_m_ = graph_.path_m(newest);
  const auto [local, bearable] = FindLocal(graph_, loops_.local_map_m, constants_.local_map);
  const std::vector<KeyframeId> needed = ThinOut(local);
  if (begins) {  // few, and nothing that came before is matched any more
    coming_.reset();
    return Redraw(needed);
  }
  if (corrected || !std::ranges::includes(bearable, drawn_)) {
    BeginDrawing(needed, poses_before ? *std::move(poses_before) : graph_.poses());
    return TakeDueDrawing();
  }
  missing_.clear();
  std::ranges::set_difference(needed, drawn_, std::back_inserter(missing_));
  return DrawMissing();
}

void Mapper::PutOffDrawing() {
  if (!loops_.loops || put_off_) return;
  put_off_.emplace();
  local_.PutOffDrawing();
}

std::vector<TileChange> Mapper::DrawPutOff() {
  if (!put_off_) return {};
  const auto put_off = *std::exchange(put_off_, std::nullopt);
  auto first = put_off.begin();
  if (local_.HasRoomForPutOff()) {
    first = std::find_if(put_off.rbegin(), put_off.rend(), [](const PutOff& one) { return one.anew; }).base();
    if (first != put_off.begin()) --first;
  }
  std::vector<ScanBatch> batches;
  for (; first != put_off.end(); ++first) {
    batches.push_back({first->anew, {}});
    batches.back().scans = ScansOf(first->scans);
  }
  if (coming_) drawing().Begin(ScansOf(coming_->drawn));
  return local_.DrawPutOff(batches);
}

bool Mapper::Accept(const GraphUpdate& update) {
  if (update.previous != last_update_ || !graph_.Fits(update)) return false;
  last_update_ = update.keyframe;
  NoteSearched(update.keyframe);
  if (update.finding) findings_.emplace(update.keyframe, *update.finding);
  if (!update.ChangesGraph()) return true;
  ++num_layouts_;
  loops_closed_.insert(loops_closed_.end(), update.closed.begin(), update.closed.end());
  for (const Loop& loop : update.closed) std::erase(loops_rejected_, loop);
  for (const Loop& loop : update.rejected) std::erase(loops_closed_, loop);
  loops_rejected_.insert(loops_rejected_.end(), update.rejected.begin(), update.rejected.end());
  graph_.Correct(update, best_poses_);
  CountComponents();
  pending_.push_back(update);
  return true;
}

bool Mapper::NoteSearched(KeyframeId keyframe) {
  if (!graph_.Has(keyframe)) return false;
  searched_ = std::max(searched_, std::optional(keyframe));
  return true;
}

std::optional<EarlierSearch> Mapper::FindSearch(KeyframeId keyframe) const {
  if (!(keyframe <= searched_)) return std::nullopt;
  const auto found = findings_.find(keyframe);
  return EarlierSearch{found == findings_.end() ? std::nullopt : std::optional(found->second)};
}

std::vector<TileChange> Mapper::Finish() {
  ApplyDue(0);
  coming_.reset();
  std::vector<KeyframeId> all = graph_.ids();
  std::erase_if(all, [&](KeyframeId id) { return !IsKeyframeOnMap(id); });
  std::vector<TileChange> tiles = DrawPutOff();
  if (loops_.loops) std::ranges::copy(Redraw(all), std::back_inserter(tiles));
  local_.Finish();
  loops_.loops = false;  // what comes is only localised
  return tiles;
}

KeyframeGraph Mapper::MakeBestGraph() const {
  KeyframeGraph graph = graph_;
  for (const GraphUpdate& update : pending_) graph.Apply(update);
  return graph;
}

Pose2 Mapper::BestPose(std::int64_t scan, const Pose2& T_map_laser) const {
  const Anchor* anchor = FindAnchor(scan);
  if (!anchor) return T_map_laser;
  return At(best_poses_, anchor->keyframe) * (Inverse(anchor->T_map_keyframe) * T_map_laser);
}

std::optional<KeyframeId> Mapper::FindKeyframe(std::int64_t scan) const {
  const Anchor* anchor = loops_.loops ? FindAnchor(scan) : nullptr;
  return anchor ? std::optional(anchor->keyframe) : std::nullopt;
}

bool Mapper::IsKeyframeOnMap(KeyframeId keyframe) const { return IsKeyframeOf(largest_, keyframe); }

bool Mapper::IsKeyframeOf(int component, KeyframeId keyframe) const {
  return best_components_[static_cast<std::size_t>(keyframe.trajectory)] == component;
}

bool Mapper::IsScanOnMap(std::int64_t scan) const {
  const Anchor* anchor = FindAnchor(scan);
  return !anchor || IsKeyframeOnMap(anchor->keyframe);
}

ScanMatch Mapper::BestMatch(std::int64_t scan, ScanMatch match) const {
  match.T_map_laser = BestPose(scan, match.T_map_laser);
  match.floating = !IsScanOnMap(scan);
  return match;
}

/// On which a scan hangs; nullptr if no keyframe came before it.
const Mapper::Anchor* Mapper::FindAnchor(std::int64_t scan) const {
  const auto after = std::upper_bound(anchors_.begin(), anchors_.end(), scan,
                                      [](std::int64_t at, const Anchor& anchor) { return at < anchor.first_scan; });
  return after == anchors_.begin() ? nullptr : &*std::prev(after);
}

/// Counts the keyframes of all components. Other trajectories hang together by now.
void Mapper::CountComponents() {
  best_components_ = graph_.FindPieces(loops_closed_);
  component_sizes_ = graph_.CountKeyframes(best_components_);
  largest_ = static_cast<int>(std::max_element(component_sizes_.begin(), component_sizes_.end()) -
                              component_sizes_.begin());  // of several the oldest
}

/// The newest keyframe, too.
void Mapper::CountNewest(bool begins) {
  if (begins) {
    const int trajectory = static_cast<int>(best_components_.size());
    best_components_.push_back(graph_.IsBridged(trajectory) ? best_components_.back() : trajectory);
    component_sizes_.push_back(0);
  }
  const int component = best_components_.back();
  const int size = ++component_sizes_[static_cast<std::size_t>(component)];
  const int largest_size = component_sizes_[static_cast<std::size_t>(largest_)];
  if (component == largest_ || size < largest_size || (size == largest_size && component > largest_)) return;
  largest_ = component;
  ++num_layouts_;
}

/// Of the loops that hold, those which first led from one trajectory to another, by their place in the list.
std::set<int> Mapper::FindJoins() const {
  std::set<int> joins;
  std::vector<Loop> loops;
  std::vector<int> components = graph_.FindComponents({});
  for (int i = 0; i < static_cast<int>(loops_closed_.size()); ++i) {
    const Loop& loop = loops_closed_[static_cast<std::size_t>(i)];
    const auto Component = [&](KeyframeId at) { return components[static_cast<std::size_t>(at.trajectory)]; };
    if (Component(loop.older) == Component(loop.newer)) continue;
    joins.insert(i);
    loops.push_back(loop);
    components = graph_.FindComponents(loops);
  }
  return joins;
}

std::vector<PlacedLoop> Mapper::PlaceLoops() const {
  const std::set<int> joins = FindJoins();
  std::vector<PlacedLoop> placed;
  const auto Place = [&](const std::vector<Loop>& loops, bool rejected) {
    std::size_t num = 0;
    const std::size_t before = placed.size();
    for (std::size_t i = loops.size(); i > 0 && num < kMostPlacedLoops / 2; --i) {
      const Loop& loop = loops[i - 1];
      if (!IsKeyframeOnMap(loop.older) || !IsKeyframeOnMap(loop.newer)) continue;
      const bool joins_pieces = !rejected && joins.contains(static_cast<int>(i) - 1);
      placed.push_back({At(best_poses_, loop.older), At(best_poses_, loop.newer), rejected, joins_pieces});
      ++num;
    }
    std::reverse(placed.begin() + static_cast<std::ptrdiff_t>(before), placed.end());
  };
  Place(loops_closed_, false);
  Place(loops_rejected_, true);
  return placed;
}

/// All of them by their numbers: the map that is shown, then by size, of several the oldest first.
std::vector<int> Mapper::SortComponents() const {
  std::vector<int> sorted;
  for (std::size_t i = 0; i < component_sizes_.size(); ++i) {
    if (component_sizes_[i] > 0) sorted.push_back(static_cast<int>(i));
  }
  const auto Size = [&](int component) { return component_sizes_[static_cast<std::size_t>(component)]; };
  std::stable_sort(sorted.begin(), sorted.end(), [&](int a, int b) {
    if (a == largest_ || b == largest_) return a == largest_ && b != largest_;
    return Size(a) > Size(b);
  });
  return sorted;
}

int Mapper::FindComponent(int piece) const {
  const std::vector<int> sorted = SortComponents();
  return piece >= 1 && piece <= std::ssize(sorted) ? sorted[static_cast<std::size_t>(piece) - 1] : -1;
}

std::vector<int> Mapper::FindPieceNumbers() const {
  std::vector<int> of_component(best_components_.size());
  int number = 0;
  for (const int component : SortComponents()) of_component[static_cast<std::size_t>(component)] = ++number;
  std::vector<int> numbers;
  for (const int component : best_components_) numbers.push_back(of_component[static_cast<std::size_t>(component)]);
  return numbers;
}

std::vector<Mapper::ScanRun> Mapper::FindScans(int component) const {
  std::vector<ScanRun> runs;
  for (int i = 0; i < trajectories_.size(); ++i) {
    if (best_components_[static_cast<std::size_t>(i)] != component) continue;
    runs.push_back({trajectories_.at(i).start.scan, trajectories_.EndOf(i)});
  }
  return runs;
}

std::int64_t Mapper::CountScans(int component) const {
  std::int64_t num = 0;
  for (const ScanRun& run : FindScans(component)) num += run.end - run.first;
  return num;
}

/// The trajectories of the map that is shown.
std::vector<bool> Mapper::FindShown() const {
  std::vector<bool> is_shown;
  for (const int component : best_components_) is_shown.push_back(component == largest_);
  return is_shown;
}

KnownMotions Mapper::CollectMotions() const {
  KnownMotions motions;
  const auto Collect = [&](const KeyframeGraph& best) {
    motions.Add(best, best_poses_, FindShown(), constants_.edges);
  };
  pending_.empty() ? Collect(graph_) : Collect(MakeBestGraph());
  return motions;
}

MapPieces Mapper::FindPiecesAndSlip() const {
  MapPieces pieces = FindPieces();
  pieces.slip = FindSlip(graph_, best_poses_, FindShown(), constants_.map_error.slip_m);
  return pieces;
}

MapPieces Mapper::FindPiecesAndError() const {
  MapPieces pieces = FindPiecesAndSlip();
  pieces.error = EstimateMapError(CollectMotions(), constants_);
  return pieces;
}

MapPieces Mapper::FindPieces() const {
  const std::vector<int> numbers = FindPieceNumbers();
  const std::vector<int> components = graph_.FindComponents(loops_closed_);
  std::vector<MapPiece> pieces(SortComponents().size());
  MapPieces found;
  found.num_keyframes = graph_.size();
  found.num_closed = std::ssize(loops_closed_);
  found.num_rejected = std::ssize(loops_rejected_);
  const auto OnPiece = [&](int trajectory) { return numbers[static_cast<std::size_t>(trajectory)]; };
  for (int i = 0; i < trajectories_.size(); ++i) {
    MapPiece& piece = pieces[static_cast<std::size_t>(OnPiece(i)) - 1];
    piece.keyframes += graph_.size(i);
    piece.scans += trajectories_.at(i).num_matched;
    found.num_matched += trajectories_.at(i).num_matched;
    piece.way_m += graph_.path_m(graph_.LastOf(i));
    if (i == 0) continue;
    Break at = trajectories_.at(i).start;
    const TrajectoryLog::Trajectory& before = trajectories_.at(i - 1);
    at.T_map_before = BestPose(before.last_matched, before.T_map_last);
    at.piece_before = OnPiece(i - 1);
    at.piece = OnPiece(i);
    const bool by_loops = components[static_cast<std::size_t>(i) - 1] == components[static_cast<std::size_t>(i)];
    if (at.joined() && !by_loops) ++found.num_bridged;
    found.breaks.push_back(at);
  }
  found.num_pieces = std::ssize(pieces);
  found.num_breaks = std::ssize(found.breaks);
  pieces.resize(std::min(pieces.size(), MapPieces::kMostPieces));
  found.pieces = std::move(pieces);
  const std::size_t num_old = found.breaks.size() - std::min(found.breaks.size(), MapPieces::kMostBreaks);
  found.breaks.erase(found.breaks.begin(), found.breaks.begin() + static_cast<std::ptrdiff_t>(num_old));
  return found;
}

Mapper::PlaceOnMap Mapper::PlaceOf(const Pose2& T_map_laser) const {
  const auto& [place_m, direction_rad] = std::tie(constants_.local_map.place_m, constants_.local_map.direction_rad);
  const auto Round = [](double value, double step) { return static_cast<int>(std::floor(value / step)); };
  return {graph_.component(*graph_.newest()), Round(T_map_laser.x_m, place_m), Round(T_map_laser.y_m, place_m),
          Round(WrapAngle(T_map_laser.yaw_rad), direction_rad)};
}

/// Whether a scan need not be drawn.
bool Mapper::IsOnKnownGround(const ScanMatch& match) const {
  const GraphConstants::KnownGround& known = constants_.known_ground;
  const bool is_matched = match.state == MatchState::kOk || match.state == MatchState::kDegenerate;
  if (!is_matched || !loops_.loops || lost_since_ || graph_.size() == 0 || match.fitness < known.least_fitness)
    return false;
  if (Distance(MatchedPose(*graph_.newest()), match.T_map_laser) >= known.every_m) return false;
  const auto found = num_keyframes_at_.find(PlaceOf(match.T_map_laser));
  return found != num_keyframes_at_.end() && found->second >= known.keyframes;
}

void Mapper::AddKeyframe(const ValidRays& rays, const ScanMatch& match, bool begins) {
  Keyframe keyframe;
  keyframe.utime = match.utime;
  keyframe.rays = rays;
  keyframe.after_lost = std::exchange(lost_since_, false);
  const auto before = graph_.newest();
  keyframe.begins = begins || !before;
  keyframe.begins_anywhere = begins && match.covariance[0] >= kUnknownVariance;
  keyframe.as_of = applied_update_;
  keyframe.walls = FindWallSigma(match, uncertainty_, local_.geometry().cell_size_m());
  if (before) keyframe.by_wheels = by_wheels_;
  by_wheels_.emplace();
  if (before) {
    keyframe.T_previous_this = Inverse(MatchedPose(*before)) * match.T_map_laser;
    if (!begins) keyframe.constraint = FindConstraint(match.T_map_laser);
  }
  if (match.state == MatchState::kDegenerate) {
    const auto [sin, cos] = ComputeSinCos(match.T_map_laser.yaw_rad);
    const auto& [x, y] = match.degenerate_axis;
    keyframe.degenerate_axis = {cos * x + sin * y, cos * y - sin * x};
  }
  const Pose2 best_pose = before ? At(best_poses_, *before) * keyframe.T_previous_this : Pose2{};
  const bool begins_trajectory = keyframe.begins;
  if (begins_trajectory) best_poses_.emplace_back();
  best_poses_.back().push_back(best_pose);
  drawn_.push_back(graph_.Add(std::move(keyframe)));
  if (coming_) Follow(*before, drawn_.back());
  ++num_keyframes_at_[PlaceOf(match.T_map_laser)];
  CountNewest(begins_trajectory);
}

/// The newest keyframe belongs to what is being drawn, too.
void Mapper::Follow(KeyframeId before, KeyframeId newest) {
  KeyframePoses& poses = coming_->poses_before;
  const Pose2 pose = At(poses, before) * graph_.keyframe(newest).T_previous_this;
  if (newest.number == 0) poses.emplace_back();
  poses.back().push_back(pose);
  coming_->drawn.emplace_back(newest, graph_.pose(newest));
  if (!put_off_) drawing().Add({graph_.keyframe(newest).rays, graph_.pose(newest)});
}

/// Scans come by the thousand between two keyframes: kept is only where another anchor begins.
void Mapper::AnchorScan(std::int64_t scan) {
  if (graph_.size() == 0) return;
  const KeyframeId keyframe = *graph_.newest();
  const Pose2& T_map_keyframe = MatchedPose(keyframe);
  if (!anchors_.empty() && anchors_.back().keyframe == keyframe && anchors_.back().T_map_keyframe == T_map_keyframe) {
    return;
  }
  anchors_.push_back({scan, keyframe, T_map_keyframe});
}

/// Those with so many newer keyframes are taken up by the graph. Whether there were any.
bool Mapper::ApplyDue(int lag) {
  bool any = false;
  for (; IsDue(lag); pending_.pop_front()) {
    graph_.Apply(pending_.front());
    taken_up_ = pending_.front().keyframe;
    any = true;
  }
  return any;
}

/// Whether the newest keyframe is of another component than the one with the most keyframes, of several the oldest: by
/// what has taken effect.
bool Mapper::Floats() const {
  const std::vector<int> sizes = graph_.CountKeyframes(graph_.pieces());
  return graph_.pieces().back() != std::ranges::max_element(sizes) - sizes.begin();
}

/// The nearest keyframe of long ago that is in the local map.
std::optional<ProximityConstraint> Mapper::FindConstraint(const Pose2& T_map_laser) const {
  double nearest_m = constants_.local_map.constraint_m;
  std::optional<ProximityConstraint> constraint;
  for (const KeyframeId id : drawn_) {
    if (!IsLongAgo(graph_, id, constants_.submaps.long_ago_m)) break;
    if (Distance(MatchedPose(id), T_map_laser) > nearest_m + kSurelyFarther_m) continue;  // spares most of the sines
    const Pose2 T_keyframe_laser = Inverse(MatchedPose(id)) * T_map_laser;
    const double distance_m = Length(T_keyframe_laser);
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    constraint = ProximityConstraint{id, T_keyframe_laser};
  }
  return constraint;
}

/// Those of the local map that are needed in it: of long ago the newest of each place and direction. So drawing it
/// costs the same however often the robot has passed there.
std::vector<KeyframeId> Mapper::ThinOut(const std::vector<KeyframeId>& local) const {
  std::set<PlaceOnMap> taken;
  std::vector<KeyframeId> needed;
  for (auto id = local.rbegin(); id != local.rend(); ++id) {
    const bool is_long_ago = IsLongAgo(graph_, *id, constants_.submaps.long_ago_m);
    if (!is_long_ago || taken.insert(PlaceOf(graph_.pose(*id))).second) needed.push_back(*id);
  }
  std::reverse(needed.begin(), needed.end());
  return needed;
}

std::vector<Mapper::PlacedKeyframe> Mapper::Place(const std::vector<KeyframeId>& keyframes) const {
  std::vector<PlacedKeyframe> placed;
  for (const KeyframeId id : keyframes) placed.emplace_back(id, graph_.pose(id));
  return placed;
}

std::vector<PlacedScan> Mapper::ScansOf(const std::vector<PlacedKeyframe>& keyframes) const {
  std::vector<PlacedScan> scans;
  for (const auto& [id, T_map_laser] : keyframes) scans.push_back({graph_.keyframe(id).rays, T_map_laser});
  return scans;
}

BackgroundDrawing& Mapper::drawing() {
  if (!drawing_) drawing_ = std::make_unique<BackgroundDrawing>(rules_);
  return *drawing_;
}

/// poses_before: of all keyframes, on the map that is matched.
void Mapper::BeginDrawing(const std::vector<KeyframeId>& keyframes, KeyframePoses poses_before) {
  missing_.clear();
  coming_ = Coming{*graph_.newest(), Place(keyframes), std::move(poses_before)};
  if (!put_off_) drawing().Begin(ScansOf(coming_->drawn));
}

/// What was drawn beside is the local map from now on, if it is time for that.
std::vector<TileChange> Mapper::TakeDueDrawing() {
  if (graph_.CountAfter(coming_->begun_at) < constants_.drawing_lag) return {};
  const Coming taken = *std::exchange(coming_, std::nullopt);
  drawn_.clear();
  for (const auto& [id, T_map_laser] : taken.drawn) drawn_.push_back(id);
  if (!put_off_) return local_.Replace(drawing().Take(), taken.drawn.back().second);
  put_off_->push_back({true, taken.drawn});
  return local_.Redraw(ScansOf(taken.drawn));
}

std::vector<TileChange> Mapper::Redraw(const std::vector<KeyframeId>& keyframes) {
  drawn_ = keyframes;
  missing_.clear();
  if (put_off_) put_off_->push_back({true, Place(keyframes)});
  return local_.Redraw(ScansOf(Place(keyframes)));
}

/// Some of those that are missing: so few that no scan waits long for it.
std::vector<TileChange> Mapper::DrawMissing() {
  std::vector<KeyframeId> next;
  for (; std::ssize(next) < constants_.local_map.missing_at_once && !missing_.empty(); missing_.pop_front()) {
    next.push_back(missing_.front());
    drawn_.insert(std::ranges::lower_bound(drawn_, next.back()), next.back());
  }
  if (next.empty()) return {};
  if (put_off_) put_off_->push_back({false, Place(next)});
  return local_.DrawMore(ScansOf(Place(next)));
}

}  // namespace crsm
