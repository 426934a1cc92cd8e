#include "common/results/pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>

#include "common/results/map_panel.hpp"
#include "common/results/overview_caption.hpp"
#include "common/results/overview_text.hpp"
#include "common/results/png.hpp"
#include "common/scan/deskew.hpp"
#include "common/scan/hits.hpp"

namespace crsm {

namespace {

std::string EncodePicture(const cv::Mat& picture, PngEncoder& encoder) {
  return encoder.Encode({picture.cols, picture.rows, picture.channels(), picture.data});
}

cv::Point2d PointOf(const Pose2& pose) { return {pose.x_m, pose.y_m}; }

/// Of the path, what is drawn over it.
struct Path {
  PathCounts counts;
  std::optional<cv::Point2d> start_m;
  cv::Point2d end_m;
  std::optional<ScanMatch> last;  ///< the match of the last scan
};

Path DrawPath(const Results& results, MapPanel& panel) {
  Path path;
  PathCounts& counts = path.counts;
  std::map<int, cv::Point2d> ends_m;  // by trajectory: those of several robots come in turn
  int trajectory = 0;
  results.matches.ForEach([&](const ScanMatch& match) {
    counts.scans.Add(match);
    if (match.floating) return;
    if (match.utime == results.last_scan.utime) path.last = match;
    counts.has_lost |= OutcomeOf(match) == ScanOutcome::kLost;
    if (OutcomeOf(match) != ScanOutcome::kOnMap) return;
    path.end_m = PointOf(match.T_map_laser);
    if (!path.start_m) path.start_m = path.end_m;
    const auto end_m = ends_m.find(match.trajectory);
    // How the robot came here is not known.
    if (match.state == MatchState::kFirst || match.trajectory != trajectory) panel.BreakPath();
    if (match.trajectory != trajectory && end_m != ends_m.end()) panel.GoTo(end_m->second);
    trajectory = match.trajectory;
    ends_m[trajectory] = path.end_m;
    panel.GoTo(path.end_m);
  });
  counts.is_drawn = path.start_m.has_value();
  counts.has_last_scan = path.last && !results.last_scan.rays.range_m.empty();
  return path;
}

void DrawScan(const ValidRays& rays, const Pose2& T_map_laser, MapPanel& panel) {
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  for (const auto& hit_m : hits_m.colwise()) {
    panel.DrawHit(PointOf(T_map_laser * Pose2{hit_m.x(), hit_m.y(), 0.0}));
  }
}

std::vector<PointPair> Select(const std::vector<PlacedLoop>& loops, const LoopKind& kind) {
  std::vector<PointPair> pairs;
  for (const PlacedLoop& loop : loops) {
    if (kind.holds(loop)) pairs.push_back({PointOf(loop.T_map_older), PointOf(loop.T_map_newer)});
  }
  return pairs;
}

/// Where the path on this map ends because the robot was lost or nothing was recorded.
void DrawBreaks(const MapPieces& pieces, MapPanel& panel) {
  for (const Break& at : pieces.breaks) {
    if (at.piece_before == 1) panel.DrawCross(PointOf(at.T_map_before), overview_colour::kBreak);
  }
}

/// Which piece goes on where this one ends: its number stands there once, however often it begins.
void LabelBreaks(const MapPieces& pieces, MapPanel& panel) {
  std::set<int> labelled;
  for (const Break& at : pieces.breaks) {
    if (at.piece_before != 1 || at.joined() || !labelled.insert(at.piece).second) continue;
    panel.DrawLabel(PointOf(at.T_map_before), fmt::format("piece {}: place unknown", at.piece),
                    overview_colour::kBreak);
  }
}

/// Places with names, over the walls: each is small, or an outline.
void DrawMarks(const std::vector<PlacedMark>& marks, MapPanel& panel) {
  constexpr double kFarthest_m = 1e5;  // whole pixels count that far
  const auto IsFar = [](const Point& at) { return std::abs(at.x_m) > kFarthest_m || std::abs(at.y_m) > kFarthest_m; };
  for (const PlacedMark& mark : marks) {
    if (mark.floating || std::ranges::any_of(mark.points, IsFar)) continue;
    std::vector<PointPair> sides;
    for (std::size_t i = 0; mark.is_outline() && i < mark.points.size(); ++i) {
      const auto& [from, to] = std::pair(mark.points[i], mark.points[(i + 1) % mark.points.size()]);
      sides.push_back({{from.x_m, from.y_m}, {to.x_m, to.y_m}});
    }
    panel.DrawPairs(sides, {overview_colour::kMark});
    const Point middle = MiddleOf(mark);
    if (!mark.is_outline()) panel.DrawDisc({middle.x_m, middle.y_m}, 5.0, overview_colour::kMark);
    panel.DrawLabel({middle.x_m, middle.y_m}, mark.kind + " " + mark.name, overview_colour::kMark);
  }
}

/// What lies under the walls, so that it hides none.
Path DrawUnderWalls(const Results& results, MapPanel& panel) {
  const Verdict* verdict = FindVerdict(results);
  if (verdict && verdict->off_at && !verdict->doubts.empty()) panel.DrawDoubts(verdict->doubts, *verdict->off_m);
  const Path path = DrawPath(results, panel);
  for (const LoopKind& kind : LoopKinds()) panel.DrawPairs(Select(results.loops, kind), kind.style);
  const auto DrawIfLost = [&](const ScanMatch& match) {
    if (OutcomeOf(match) != ScanOutcome::kLost || match.floating) return;
    panel.DrawDisc(PointOf(match.T_map_laser), 2.5, overview_colour::kLost);
  };
  if (path.counts.has_lost) results.matches.ForEach(DrawIfLost);  // over the whole path
  if (path.last) DrawScan(Deskew(results.last_scan.rays, path.last->twist), path.last->T_map_laser, panel);
  panel.DrawOrigin();
  if (path.start_m) {
    panel.DrawDisc(*path.start_m, 6.0, overview_colour::kStart);
    panel.DrawDisc(path.end_m, 6.0, overview_colour::kEnd);
  }
  DrawBreaks(results.pieces, panel);
  if (verdict && verdict->way_back) {
    const auto& [from, to, then_m] = *verdict->way_back;
    panel.DrawPairs({{{from.x_m, from.y_m}, {to.x_m, to.y_m}}}, kWayBackStyle);
  }
  if (verdict && verdict->off_at) panel.DrawRing({verdict->off_at->x_m, verdict->off_at->y_m});
  return path;
}

}  // namespace

std::string EncodeMap(const DenseGrid& grid, PngEncoder& encoder) {
  // OpenCV takes no const data; the flip copies it.
  const cv::Mat rows(grid.height_cells, grid.width_cells, CV_8UC1, const_cast<std::uint8_t*>(grid.cells.data()));
  cv::Mat picture;
  cv::flip(rows, picture, 0);
  return EncodePicture(picture, encoder);
}

std::string EncodeOverview(const Results& results, PngEncoder& encoder) {
  MapPanel panel(results.grid);
  const Path path = DrawUnderWalls(results, panel);
  panel.DrawWalls();
  if (results.summary && results.summary->changes) {
    for (const MapChange& change : *results.summary->changes) panel.DrawChange(change);
  }
  LabelBreaks(results.pieces, panel);
  DrawMarks(results.marks, panel);
  panel.DrawRulers();
  cv::Mat picture = panel.image();
  picture.push_back(DrawCaption(DescribeRun(results, path.counts), picture.cols, panel.scale()));
  return EncodePicture(picture, encoder);
}

}  // namespace crsm
