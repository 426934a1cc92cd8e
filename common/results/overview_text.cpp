#include "common/results/overview_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "common/math/format_number.hpp"

namespace crsm {
namespace {

using Sign = LegendItem::Sign;

void AddVerdict(const Verdict* verdict, OverviewCaption& caption) {
  if (!verdict) {
    caption.badge = "NO VERDICT";
    caption.badge_colour = overview_colour::kRuler;
    return;
  }
  switch (verdict->trust) {
    case Trust::kGood:
      caption.badge = "GOOD";
      caption.badge_colour = overview_colour::kGood;
      break;
    case Trust::kDoubtful:
      caption.badge = "DOUBTFUL";
      caption.badge_colour = overview_colour::kDoubtful;
      break;
    case Trust::kBad:
      caption.badge = "NOT TO BE TRUSTED";
      caption.badge_colour = overview_colour::kBad;
      break;
  }
  std::vector<std::string> lines = FormatVerdict(*verdict);
  caption.headline = lines[1];  // it says what the badge says, and of what
  lines.erase(lines.begin() + 1);
  for (const std::string& line : lines)
    (line.starts_with("warning: ") ? caption.warnings : caption.lines).push_back(line);
}

std::string DescribeSize(const Results& results) {
  const DenseGrid& grid = results.grid;
  const double area_m2 = results.summary ? results.summary->explored_area_m2 : ComputeExploredArea(grid);
  std::string text = fmt::format("map of {:.0f} m2 within {:.0f} x {:.0f} m", area_m2,
                                 grid.width_cells * grid.cell_size_m, grid.height_cells * grid.cell_size_m);
  if (results.summary) text += fmt::format(", way of {:.0f} m", results.summary->values.path_m);
  return text;
}

/// Nothing where nobody knows. Two runs of one log say the same: not when they were.
std::string DescribeOrigin(const Summary& summary) {
  if (summary.origin.made_from.empty()) return "";
  const std::string recorded = FormatUtc(summary.values.first_utime).substr(0, 10);  // the day
  return fmt::format("made from {}{}, by version {}", summary.origin.made_from,
                     recorded.empty() ? "" : ", recorded on " + recorded, summary.version);
}

std::string DescribeLoops(const Results& results) {
  const auto num_rejected = std::ranges::count(results.loops, true, &PlacedLoop::rejected);
  // Of many loops only the newest come here, and none of another piece.
  const auto all_rejected = std::max<std::int64_t>(num_rejected, results.pieces.num_rejected);
  const auto all_closed = std::max<std::int64_t>(std::ssize(results.loops) - num_rejected, results.pieces.num_closed);
  if (all_closed + all_rejected == 0) return "";
  std::string text = fmt::format(", {} closed, {} rejected", FormatCount(all_closed, "loop"), all_rejected);
  if (all_closed + all_rejected > std::ssize(results.loops))
    text += fmt::format(" ({} of them drawn)", results.loops.size());
  return text;
}

void AddPieces(const Results& results, OverviewCaption& caption) {
  const MapPieces& pieces = results.pieces;
  if (pieces.num_breaks == 0) return;
  std::string text = fmt::format("the path breaks {} times, ", pieces.num_breaks);
  if (pieces.num_breaks == 1) text = "the path breaks once, ";
  text += pieces.num_pieces <= 1 ? "all joined: map in one piece"
                                 : fmt::format(
                                       "map in {} pieces: this is the largest, and the others float: where "
                                       "they lie beside this one is not known",
                                       pieces.num_pieces);
  caption.lines.push_back(text);
}

std::vector<LegendItem> MakeLegend(const Results& results, const PathCounts& path) {
  using namespace overview_colour;
  std::vector<LegendItem> legend{
      {Sign::kSquare, kFree, "free"}, {Sign::kSquare, kUnexplored, "unexplored"}, {Sign::kSquare, kWall, "wall"}};
  const auto AddIf = [&legend](bool is_drawn, Sign sign, const cv::Scalar& colour, const char* text) {
    if (is_drawn) legend.push_back({sign, colour, text});
  };
  AddIf(path.is_drawn, Sign::kLine, kPath, "path");
  AddIf(path.is_drawn, Sign::kDisc, kStart, "start");
  AddIf(path.is_drawn, Sign::kDisc, kEnd, "end");
  AddIf(path.has_last_scan, Sign::kDisc, kHit, "last scan");
  AddIf(path.has_lost, Sign::kDisc, kLost, "lost scan");
  for (const LoopKind& kind : LoopKinds())
    AddIf(std::ranges::any_of(results.loops, kind.holds), kind.sign, kind.style.colour, kind.name);
  AddIf(results.pieces.num_breaks > 0, Sign::kCross, kBreak, "break");
  const auto HasChange = [&results](ChangeKind kind) {
    return results.summary && results.summary->changes &&
           std::ranges::count(*results.summary->changes, kind, &MapChange::kind) > 0;
  };
  AddIf(HasChange(ChangeKind::kNew), Sign::kSquare, kNew, "new since the map was made");
  AddIf(HasChange(ChangeKind::kGone), Sign::kSquare, kGone, "gone since then");
  const Verdict* verdict = FindVerdict(results);
  AddIf(verdict && verdict->off_at && !verdict->doubts.empty(), Sign::kSquare, kDoubt, "the deeper, the further off");
  AddIf(verdict && verdict->way_back, Sign::kDashes, kWayBackStyle.colour, "a drive that would tell");
  AddIf(verdict && verdict->off_at, Sign::kRing, kDoubt, "past here it is most likely off");
  return legend;
}

}  // namespace

const std::vector<LoopKind>& LoopKinds() {
  using namespace overview_colour;
  static const std::vector<LoopKind> kinds{
      {"loop closed", {kLoop, 0.6}, Sign::kPair, [](const PlacedLoop& loop) { return !loop.rejected && !loop.joins; }},
      {"loop rejected",
       {kRejected, 0.8, 2.5, true},
       Sign::kDashes,
       [](const PlacedLoop& loop) { return loop.rejected; }},
      {"loop that joined pieces", {kJoin, 0.9, 5.0}, Sign::kPair, [](const PlacedLoop& loop) {
         return !loop.rejected && loop.joins;
       }}};
  return kinds;
}

const Verdict* FindVerdict(const Results& results) {
  return results.summary && results.summary->verdict ? &*results.summary->verdict : nullptr;
}

OverviewCaption DescribeRun(const Results& results, const PathCounts& path) {
  OverviewCaption caption;
  caption.title = results.name;
  const Verdict* verdict = FindVerdict(results);
  AddVerdict(verdict, caption);
  if (verdict && !results.summary->ended) caption.badge += " SO FAR";
  std::string text = DescribeSize(results) + DescribeLoops(results);
  if (!verdict) text = fmt::format("{}, {} lost, ", FormatCount(path.scans.scans(), "scan"), path.scans.lost) + text;
  caption.lines.push_back(text);
  AddPieces(results, caption);
  const std::string origin = results.summary ? DescribeOrigin(*results.summary) : "";
  if (!origin.empty()) caption.lines.push_back(origin);
  caption.legend = MakeLegend(results, path);
  return caption;
}

}  // namespace crsm
