#include "common/plan/walls.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace crsm {
namespace {

using Counts = std::vector<int>;

/// How many stretches that face one side of a line cover each of its bins.
Counts CountCover(const WallLine& line, const std::vector<WallStretch>& stretches, double side, double bin_m) {
  const auto num = static_cast<std::size_t>((line.to_m - line.from_m) / bin_m) + 2;
  Counts counts(num + 1);
  const auto BinOf = [&](double at_m) {
    return std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(std::lround((at_m - line.from_m) / bin_m)), 0,
                                      static_cast<std::ptrdiff_t>(num));
  };
  for (const int i : line.stretches) {
    const WallStretch& stretch = stretches[static_cast<std::size_t>(i)];
    if (side * stretch.normal.dot(line.normal) < 0.0) continue;
    const auto [from, to] = std::minmax({line.Along(stretch.from_m), line.Along(stretch.to_m)});
    ++counts[static_cast<std::size_t>(BinOf(from))];
    --counts[static_cast<std::size_t>(BinOf(to))];
  }
  std::partial_sum(counts.begin(), counts.end(), counts.begin());
  return counts;
}

/// Takes out what is a second sight of a wall that other scans saw better, at a wrong pose.
void RemoveDoubles(const std::vector<WallLine>& lines, std::vector<Counts>& cover, const PlanConstants& constants) {
  const std::vector<Counts> before = cover;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t j = 0; j < lines.size(); ++j) {
      if (i == j || std::abs(Cross(lines[i].normal, lines[j].normal)) > 2.0 * constants.line.yaw_max_rad) continue;
      if (!lines[i].two_faced && !lines[j].two_faced && lines[i].normal.dot(lines[j].normal) < 0.0) continue;
      const double ends = std::min(std::abs(lines[j].Across(lines[i].At(lines[i].from_m))),
                                   std::abs(lines[j].Across(lines[i].At(lines[i].to_m))));
      const double middle = std::abs(lines[j].Across(lines[i].At(0.5 * (lines[i].from_m + lines[i].to_m))));
      if (std::min(ends, middle) > constants.line.double_m) continue;
      for (std::size_t bin = 0; bin < cover[i].size(); ++bin) {
        const Eigen::Vector2d at =
            lines[i].At(lines[i].from_m + (static_cast<double>(bin) + 0.5) * constants.wall.bin_m);
        if (std::abs(lines[j].Across(at)) > constants.line.double_m) continue;
        const double other = (lines[j].Along(at) - lines[j].from_m) / constants.wall.bin_m;
        if (other < 0.0 || other >= static_cast<double>(before[j].size())) continue;
        if (before[i][bin] < constants.line.double_share * before[j][static_cast<std::size_t>(other)])
          cover[i][bin] = 0;
      }
    }
  }
}

class WallFinder {
 public:
  WallFinder(const std::vector<WallLine>& lines, const SeenSpace& space, const PlanConstants& constants)
      : lines_(lines), space_(space), constants_(constants) {}

  /// By lines: what was seen of each, and of that what was seen from its front, and from its back.
  Walls Find(const std::vector<Counts>& cover, const std::vector<Counts>& front, const std::vector<Counts>& back) {
    for (std::size_t i = 0; i < lines_.size(); ++i) AddPieces(static_cast<int>(i), cover[i]);
    FindHidden(front, 1.0);
    FindHidden(back, -1.0);
    EndAtCorners();
    EndInHiddenCorners();
    RemoveFurniture();
    FindDoorways();
    KeepWalls();
    FindDoorways();
    KeepStructures();
    FindDoorways();
    return {std::move(pieces_), std::move(doorways_)};
  }

 private:
  const WallLine& LineOf(const WallPiece& piece) const { return lines_[static_cast<std::size_t>(piece.line)]; }
  Eigen::Vector2d FromOf(const WallPiece& piece) const { return LineOf(piece).At(piece.from_m); }
  Eigen::Vector2d ToOf(const WallPiece& piece) const { return LineOf(piece).At(piece.to_m); }

  /// Whether scans looked through a place of a line, and more of them than saw something stand there.
  bool IsPierced(const WallLine& line, double at_m, int num_saw) const {
    int least = std::numeric_limits<int>::max();
    for (const double off_m : {-space_.cell_m(), 0.0, space_.cell_m()}) {
      least = std::min(least, space_.NumBeyond(line.At(at_m) + off_m * line.normal));
    }
    return least >= constants_.wall.pierced_scans && least >= constants_.wall.pierced_share * num_saw;
  }

  /// Whether a hole between two pieces is one only because nobody could see the wall there, or beams missed it.
  bool IsNoGap(const WallLine& line, double from_m, double to_m) const {
    if (to_m - from_m > constants_.wall.hidden_m) return false;
    const double free = space_.FreeShare(line.At(from_m), line.At(to_m), 0.0);
    return free < (to_m - from_m <= constants_.wall.hole_m ? constants_.door.free_share : constants_.wall.free_share);
  }

  void AddPieces(int number, const Counts& cover) {
    const WallLine& line = lines_[static_cast<std::size_t>(number)];
    const double bin_m = constants_.wall.bin_m;
    std::vector<WallPiece> found;
    for (std::size_t bin = 0; bin < cover.size(); ++bin) {
      const double at_m = line.from_m + static_cast<double>(bin) * bin_m;
      if (cover[bin] < constants_.line.least_scans || IsPierced(line, at_m + 0.5 * bin_m, cover[bin])) continue;
      if (!found.empty() && at_m - found.back().to_m < 0.5 * bin_m) {
        found.back().to_m = at_m + bin_m;
      } else {
        found.push_back({number, at_m, at_m + bin_m, bin_m, bin_m});
      }
    }
    for (const WallPiece& piece : found) {
      const bool goes_on =
          !pieces_.empty() && pieces_.back().line == number && IsNoGap(line, pieces_.back().to_m, piece.from_m);
      if (goes_on) {
        pieces_.back().to_m = piece.to_m;
      } else {
        pieces_.push_back(piece);
      }
    }
  }

  /// Notes that something hides a wall there, from one of its sides or from each that was seen.
  void Hide(int line, double from_m, double to_m, std::optional<double> side = std::nullopt) {
    if (to_m - from_m <= constants_.wall.hole_m || to_m - from_m > constants_.wall.hidden_m) return;
    if (side || !lines_[static_cast<std::size_t>(line)].two_faced) {
      hidden_.push_back({line, from_m, to_m, side.value_or(1.0)});
    } else {
      for (const double each : {1.0, -1.0}) hidden_.push_back({line, from_m, to_m, each});
    }
  }

  /// Where walls stand that were not seen from a side from which others of their line were.
  void FindHidden(const std::vector<Counts>& cover, double side) {
    const double bin_m = constants_.wall.bin_m;
    for (const WallPiece& piece : pieces_) {
      const WallLine& line = LineOf(piece);
      if (side < 0.0 && !line.two_faced) continue;
      const Counts& counts = cover[static_cast<std::size_t>(piece.line)];
      std::size_t num_hidden = 0;  // bins before this one
      for (std::size_t bin = 0; bin <= counts.size(); ++bin) {
        const double at_m = line.from_m + static_cast<double>(bin) * bin_m;
        const bool is_in_piece = at_m >= piece.from_m && at_m < piece.to_m && bin < counts.size();
        if (is_in_piece && counts[bin] < constants_.line.least_scans) {
          ++num_hidden;
        } else {
          Hide(piece.line, at_m - static_cast<double>(num_hidden) * bin_m, at_m, side);
          num_hidden = 0;
        }
      }
    }
  }

  /// How far along a piece's line another piece crosses it, if it does near a place.
  std::optional<double> FindCrossing(const WallPiece& piece, double at_m, const WallPiece& other,
                                     double reach_m) const {
    const WallLine& line = LineOf(piece);
    const WallLine& across = LineOf(other);
    const double sine = Cross(line.along, across.along);
    constexpr double kLeastSine = 0.35;  // 20 degrees
    if (std::abs(sine) < kLeastSine) return std::nullopt;
    const double crossing_m = Cross(across.origin_m - line.origin_m, across.along) / sine;
    if (std::abs(crossing_m - at_m) > reach_m) return std::nullopt;
    const double there_m = across.Along(line.At(crossing_m));
    if (there_m < other.from_m - reach_m || there_m > other.to_m + reach_m) return std::nullopt;
    return crossing_m;
  }

  /// An end near another wall ends at it.
  void EndAtCorners() {
    const std::vector<WallPiece> before = pieces_;
    for (WallPiece& piece : pieces_) {
      for (const bool is_end : {false, true}) {
        const double old_m = is_end ? piece.to_m : piece.from_m;
        double best_m = constants_.wall.corner_m;
        for (const WallPiece& other : before) {
          if (other.line == piece.line || other.length_m() < constants_.wall.corner_m) continue;
          const auto crossing_m = FindCrossing(piece, old_m, other, constants_.wall.corner_m);
          if (!crossing_m || std::abs(*crossing_m - old_m) > best_m) continue;
          best_m = std::abs(*crossing_m - old_m);
          MoveEnd(piece, is_end, *crossing_m, other);
        }
      }
    }
    std::erase_if(pieces_, [](const WallPiece& piece) { return piece.length_m() <= 0.0; });
  }

  /// Where something hides a corner of a room, both walls are taken to meet in it.
  void EndInHiddenCorners() {
    const std::vector<WallPiece> before = pieces_;
    const double reach_m = constants_.wall.hidden_m;
    for (WallPiece& piece : pieces_) {
      for (const bool is_end : {false, true}) {
        const double old_m = is_end ? piece.to_m : piece.from_m;
        const bool was_corner = is_end ? piece.to_corner : piece.from_corner;
        double best_m = reach_m;
        for (const WallPiece& other : before) {
          if (other.line == piece.line || other.length_m() < reach_m) continue;  // furniture is no corner
          const auto crossing_m = FindCrossing(piece, old_m, other, reach_m);
          if (!crossing_m || (*crossing_m > old_m) != is_end) continue;
          const double there_m = LineOf(other).Along(LineOf(piece).At(*crossing_m));
          const double end_m = std::clamp(there_m, other.from_m, other.to_m);
          const auto [depth_m, width_m] = std::minmax({std::abs(*crossing_m - old_m), std::abs(there_m - end_m)});
          if (std::abs(*crossing_m - old_m) > best_m || width_m < constants_.wall.corner_m) continue;
          if (was_corner && (piece.length_m() < reach_m || depth_m > constants_.wall.corner_depth_m)) continue;
          if (IsSeenThrough(LineOf(piece), old_m, *crossing_m) || IsSeenThrough(LineOf(other), end_m, there_m))
            continue;
          best_m = std::abs(*crossing_m - old_m);
          MoveEnd(piece, is_end, *crossing_m, other);
        }
        const double new_m = is_end ? piece.to_m : piece.from_m;
        Hide(piece.line, std::min(old_m, new_m), std::max(old_m, new_m));
      }
    }
  }

  void MoveEnd(WallPiece& piece, bool is_end, double to_m, const WallPiece& other) {
    const double sine = std::abs(Cross(LineOf(piece).along, LineOf(other).along));
    (is_end ? piece.to_m : piece.from_m) = to_m;
    (is_end ? piece.sigma_to_m : piece.sigma_from_m) = LineOf(other).sigma_offset_m / sine;
    (is_end ? piece.to_corner : piece.from_corner) = true;
  }

  bool IsSeenThrough(const WallLine& line, double from_m, double to_m) const {
    return std::abs(to_m - from_m) > constants_.wall.corner_m &&
           space_.FreeShare(line.At(from_m), line.At(to_m), 0.0) > constants_.wall.free_share;
  }

  /// What stands before a wall that is hidden is what hides it.
  void RemoveFurniture() {
    std::erase_if(pieces_, [&](const WallPiece& piece) {
      if (piece.length_m() > constants_.wall.hidden_m) return false;
      return std::ranges::any_of(hidden_, [&](const Hidden& hidden) {
        const WallLine& line = lines_[static_cast<std::size_t>(hidden.line)];
        return hidden.line != piece.line &&
               std::ranges::all_of(std::array{FromOf(piece), ToOf(piece)}, [&](const Eigen::Vector2d& end_m) {
                 const double along_m = line.Along(end_m);
                 const double across_m = hidden.side * line.Across(end_m);
                 return along_m >= hidden.from_m - constants_.wall.beside_m &&
                        along_m <= hidden.to_m + constants_.wall.beside_m && across_m <= constants_.wall.before_m &&
                        across_m >= -constants_.line.one_face_m;
               });
      });
    });
  }

  void FindDoorways() {
    doorways_.clear();
    for (std::size_t i = 1; i < pieces_.size(); ++i) {
      const WallPiece& a = pieces_[i - 1];
      const WallPiece& b = pieces_[i];
      const double width_m = b.from_m - a.to_m;
      if (a.line != b.line || width_m < constants_.door.least_m || width_m > constants_.door.most_m) continue;
      const double jamb_m = 0.1 * width_m;
      const WallLine& line = LineOf(a);
      const double free =
          space_.FreeShare(line.At(a.to_m + jamb_m), line.At(b.from_m - jamb_m), constants_.door.through_m);
      if (free >= constants_.door.free_share) doorways_.push_back({a.line, a.to_m, b.from_m});
    }
  }

  bool IsBesideDoorway(const WallPiece& piece) const {
    return std::ranges::any_of(doorways_, [&](const Doorway& door) {
      return door.line == piece.line && (door.from_m == piece.to_m || door.to_m == piece.from_m);
    });
  }

  /// Whether a piece goes on a long wall of its line.
  bool IsInLine(const WallPiece& piece) const {
    return std::ranges::any_of(pieces_, [&](const WallPiece& other) {
      return other.line == piece.line && other.length_m() >= constants_.wall.least_m &&
             std::max(other.from_m - piece.to_m, piece.from_m - other.to_m) <= constants_.wall.hidden_m;
    });
  }

  void KeepWalls() {
    std::vector<WallPiece> kept;
    for (const WallPiece& piece : pieces_) {
      const bool may_be_short = (piece.from_corner && piece.to_corner) || IsBesideDoorway(piece);
      if (piece.length_m() >= constants_.wall.least_m || (piece.length_m() >= constants_.wall.jamb_m && may_be_short) ||
          (piece.length_m() >= constants_.wall.in_line_m && IsInLine(piece))) {
        kept.push_back(piece);
      }
    }
    pieces_ = std::move(kept);
  }

  bool Touch(const WallPiece& a, const WallPiece& b) const {
    const double near_m = constants_.wall.corner_m;
    const auto IsAt = [&](const Eigen::Vector2d& end_m, const WallPiece& piece) {
      const double along_m = LineOf(piece).Along(end_m);
      return std::abs(LineOf(piece).Across(end_m)) <= near_m && along_m >= piece.from_m - near_m &&
             along_m <= piece.to_m + near_m;
    };
    return IsAt(FromOf(a), b) || IsAt(ToOf(a), b) || IsAt(FromOf(b), a) || IsAt(ToOf(b), a);
  }

  /// Takes out what stands alone and is small.
  void KeepStructures() {
    std::vector<std::size_t> root(pieces_.size());
    std::iota(root.begin(), root.end(), 0);
    const auto RootOf = [&](std::size_t i) {
      while (root[i] != i) i = root[i] = root[root[i]];
      return i;
    };
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (RootOf(i) != RootOf(j) && Touch(pieces_[i], pieces_[j])) root[RootOf(i)] = RootOf(j);
      }
      if (i == 0 || pieces_[i].line != pieces_[i - 1].line) continue;
      if (pieces_[i].from_m - pieces_[i - 1].to_m <= constants_.wall.hidden_m) root[RootOf(i)] = RootOf(i - 1);
    }
    std::vector<Eigen::AlignedBox2d> boxes(pieces_.size());
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      boxes[RootOf(i)].extend(FromOf(pieces_[i]));
      boxes[RootOf(i)].extend(ToOf(pieces_[i]));
    }
    std::vector<WallPiece> kept;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (boxes[RootOf(i)].diagonal().norm() >= constants_.wall.structure_m) kept.push_back(pieces_[i]);
    }
    pieces_ = std::move(kept);
  }

  struct Hidden {
    int line;
    double from_m;
    double to_m;
    double side;  ///< 1: the one that the line faces, -1: the other one
  };

  const std::vector<WallLine>& lines_;
  const SeenSpace& space_;
  const PlanConstants& constants_;
  std::vector<WallPiece> pieces_;
  std::vector<Hidden> hidden_;
  std::vector<Doorway> doorways_;
};

}  // namespace

Walls FindWalls(const std::vector<WallLine>& lines, const std::vector<WallStretch>& stretches, const SeenSpace& space,
                const PlanConstants& constants) {
  std::vector<Counts> front;
  std::vector<Counts> back;
  for (const WallLine& line : lines) {
    front.push_back(CountCover(line, stretches, 1.0, constants.wall.bin_m));
    back.push_back(CountCover(line, stretches, -1.0, constants.wall.bin_m));
  }
  std::vector<Counts> cover = front;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t bin = 0; bin < cover[i].size(); ++bin) cover[i][bin] += back[i][bin];
  }
  RemoveDoubles(lines, cover, constants);
  return WallFinder(lines, space, constants).Find(cover, front, back);
}

}  // namespace crsm
