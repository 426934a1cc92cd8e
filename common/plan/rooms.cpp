#include "common/plan/rooms.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace crsm {
namespace {

constexpr std::int32_t kUnseen = 0;
constexpr std::int32_t kBarrier = -1;
constexpr std::int32_t kFree = -2;  // of no room yet; rooms are 1 and more

/// A grid along the walls of the building, in which rooms are filled.
class RoomGrid {
 public:
  RoomGrid(const SeenSpace& space, double direction_rad, const PlanConstants::Room& constants) : constants_(constants) {
    const auto [sin, cos] = ComputeSinCos(direction_rad);
    rotation_ << cos, sin, -sin, cos;
    Eigen::AlignedBox2d box;
    space.ForEachFree([&](const Eigen::Vector2d& at_m) { box.extend(Eigen::Vector2d(rotation_ * at_m)); });
    if (box.isEmpty()) return;
    const double margin_m = 2.0 * space.cell_m();
    const Eigen::Vector2d size = box.sizes() + Eigen::Vector2d::Constant(2.0 * margin_m);
    cell_m_ = std::max(constants.cell_m, std::sqrt(size.prod() / constants.most_cells));
    origin_m_ = box.min() - Eigen::Vector2d::Constant(margin_m);
    columns_ = static_cast<int>(size.x() / cell_m_) + 1;
    rows_ = static_cast<int>(size.y() / cell_m_) + 1;
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        if (space.IsFree(MiddleOf(column, row))) At(column, row) = kFree;
      }
    }
  }

  /// Cells that touch at corners, at least: nothing is filled through it.
  void Close(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m) {
    const Eigen::Vector2d from = ToCells(from_m);
    const Eigen::Vector2d way = ToCells(to_m) - from;
    const int num = static_cast<int>(std::ceil(way.cwiseAbs().maxCoeff())) + 1;
    for (int i = 0; i <= num; ++i) {
      const Eigen::Vector2d at = from + way * (static_cast<double>(i) / num);
      const int column = static_cast<int>(std::floor(at.x()));
      const int row = static_cast<int>(std::floor(at.y()));
      if (IsInside(column, row)) At(column, row) = kBarrier;
    }
  }

  void Fill() {
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        if (At(column, row) != kFree) continue;
        double num = 0.0;
        FillFrom(column, row, kFree, num_rooms_ + 1, [&num](int, int) { num += 1.0; });
        if (num * cell_m_ * cell_m_ >= constants_.least_m2) {
          ++num_rooms_;
        } else {  // of another room, behind a table say, or of none
          FillFrom(column, row, num_rooms_ + 1, kUnseen);
        }
      }
    }
    AddUnseen();
  }

  std::int32_t RoomAt(const Eigen::Vector2d& at_m) const {
    const Eigen::Vector2d at = ToCells(at_m);
    const int column = static_cast<int>(std::floor(at.x()));
    const int row = static_cast<int>(std::floor(at.y()));
    return IsInside(column, row) ? std::max(At(column, row), 0) : 0;
  }

  struct Room {
    double area_m2 = 0.0;
    double closed = 0.0;                                 ///< share of the contour
    int deepest = -1;                                    ///< cells from the contour, ...
    Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();  ///< ... of this place
  };

  /// By their numbers, from 1.
  std::vector<Room> Measure() const {
    std::vector<double> num(static_cast<std::size_t>(num_rooms_) + 1);
    std::vector<double> num_closed(num.size());
    std::vector<double> num_open(num.size());
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        const std::int32_t room = At(column, row);
        if (room <= 0) continue;
        num[static_cast<std::size_t>(room)] += 1.0;
        ForEachNeighbour(column, row, [&](std::int32_t other) {
          if (other == room) return;
          (other == kBarrier ? num_closed : num_open)[static_cast<std::size_t>(room)] += 1.0;
        });
      }
    }
    std::vector<Room> rooms(num.size());
    for (std::size_t i = 1; i < num.size(); ++i) {
      // A wall runs through the middle of its cells, on the average: half of them are of the room.
      rooms[i].area_m2 = (num[i] + 0.5 * num_closed[i]) * cell_m_ * cell_m_;
      rooms[i].closed = num_closed[i] / std::max(1.0, num_closed[i] + num_open[i]);
    }
    FindMiddles(rooms);
    return rooms;
  }

 private:
  std::int32_t& At(int column, int row) { return cells_[IndexOf(column, row)]; }
  std::int32_t At(int column, int row) const { return cells_[IndexOf(column, row)]; }
  std::size_t IndexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }
  bool IsInside(int column, int row) const { return column >= 0 && row >= 0 && column < columns_ && row < rows_; }
  Eigen::Vector2d ToCells(const Eigen::Vector2d& at_m) const { return (rotation_ * at_m - origin_m_) / cell_m_; }
  Eigen::Vector2d MiddleOf(int column, int row) const {
    return rotation_.transpose() * (origin_m_ + cell_m_ * Eigen::Vector2d(column + 0.5, row + 0.5));
  }

  /// Calls visit with the cells on the four sides; beyond the grid nothing was seen.
  template <class Visit>
  void ForEachNeighbour(int column, int row, Visit&& visit) const {
    constexpr std::array<std::array<int, 2>, 4> kSides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
    for (const auto& [x, y] : kSides) visit(IsInside(column + x, row + y) ? At(column + x, row + y) : kUnseen);
  }

  /// Gives all cells of a kind that hang together with one another number. Calls visit with each of them.
  template <class Visit>
  void FillFrom(int column, int row, std::int32_t kind, std::int32_t number, Visit&& visit) {
    std::vector<std::array<int, 2>> left{{column, row}};
    At(column, row) = number;
    while (!left.empty()) {
      const auto [x, y] = left.back();
      left.pop_back();
      visit(x, y);
      for (const auto& [next_x, next_y] :
           std::array<std::array<int, 2>, 4>{{{x + 1, y}, {x - 1, y}, {x, y + 1}, {x, y - 1}}}) {
        if (!IsInside(next_x, next_y) || At(next_x, next_y) != kind) continue;
        At(next_x, next_y) = number;
        left.push_back({next_x, next_y});
      }
    }
  }
  void FillFrom(int column, int row, std::int32_t kind, std::int32_t number) {
    FillFrom(column, row, kind, number, [](int, int) {});
  }

  /// What lies in a room and nobody saw, below a table say, is of the room.
  void AddUnseen() {
    constexpr std::int32_t kLooked = std::numeric_limits<std::int32_t>::min();
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        if (At(column, row) != kUnseen) continue;
        bool is_outside = false;
        std::int32_t room = 0;
        bool has_others = false;
        double num_of_room = 0.0;
        double num_barriers = 0.0;
        FillFrom(column, row, kUnseen, kLooked, [&](int x, int y) {
          is_outside = is_outside || x == 0 || y == 0 || x + 1 == columns_ || y + 1 == rows_;
          ForEachNeighbour(x, y, [&](std::int32_t other) {
            num_barriers += other == kBarrier;
            if (other <= 0) return;
            has_others = has_others || (room != 0 && room != other);
            room = other;
            num_of_room += 1.0;
          });
        });
        const bool is_of_room = !is_outside && !has_others && room != 0 &&
                                num_of_room >= constants_.own_share * (num_of_room + num_barriers);
        FillFrom(column, row, kLooked, is_of_room ? room : kLooked + 1);
      }
    }
  }

  /// By city blocks to the contour, there and back over the grid.
  void FindMiddles(std::vector<Room>& rooms) const {
    std::vector<int> depth(cells_.size());
    const auto DepthAt = [&](int column, int row) { return IsInside(column, row) ? depth[IndexOf(column, row)] : 0; };
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        if (At(column, row) <= 0) continue;
        depth[IndexOf(column, row)] = 1 + std::min(DepthAt(column - 1, row), DepthAt(column, row - 1));
      }
    }
    for (int row = rows_; row-- > 0;) {
      for (int column = columns_; column-- > 0;) {
        const std::int32_t number = At(column, row);
        if (number <= 0) continue;
        int& here = depth[IndexOf(column, row)];
        here = std::min(here, 1 + std::min(DepthAt(column + 1, row), DepthAt(column, row + 1)));
        Room& room = rooms[static_cast<std::size_t>(number)];
        if (here <= room.deepest) continue;
        room.deepest = here;
        room.middle_m = MiddleOf(column, row);
      }
    }
  }

  PlanConstants::Room constants_;
  Eigen::Matrix2d rotation_;  ///< from the map's frame
  double cell_m_ = 1.0;
  Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::int32_t> cells_;
  std::int32_t num_rooms_ = 0;
};

/// Closes small gaps between walls: in line, and from the end of one to another one.
void CloseGaps(const std::vector<WallLine>& lines, const Walls& walls, const PlanConstants::Room& constants,
               RoomGrid& grid) {
  const auto LineOf = [&](const WallPiece& piece) -> const WallLine& {
    return lines[static_cast<std::size_t>(piece.line)];
  };
  for (std::size_t i = 0; i < walls.pieces.size(); ++i) {
    const WallPiece& piece = walls.pieces[i];
    if (i > 0 && walls.pieces[i - 1].line == piece.line && piece.from_m - walls.pieces[i - 1].to_m < constants.gap_m) {
      grid.Close(LineOf(piece).At(walls.pieces[i - 1].to_m), LineOf(piece).At(piece.from_m));
    }
    for (const double end_m : {piece.from_m, piece.to_m}) {
      const Eigen::Vector2d end = LineOf(piece).At(end_m);
      for (const WallPiece& other : walls.pieces) {
        if (other.line == piece.line) continue;
        const WallLine& line = LineOf(other);
        const Eigen::Vector2d nearest = line.At(std::clamp(line.Along(end), other.from_m, other.to_m));
        if ((nearest - end).norm() <= constants.touch_m) grid.Close(end, nearest);
      }
    }
  }
}

}  // namespace

std::vector<PlanRoom> FindRooms(const std::vector<WallLine>& lines, const Walls& walls, const SeenSpace& space,
                                const std::vector<NamedPlace>& names, double main_direction_rad,
                                const PlanConstants& constants) {
  RoomGrid grid(space, main_direction_rad, constants.room);
  CloseGaps(lines, walls, constants.room, grid);
  for (const WallPiece& piece : walls.pieces) {
    const WallLine& line = lines[static_cast<std::size_t>(piece.line)];
    grid.Close(line.At(piece.from_m), line.At(piece.to_m));
  }
  for (const Doorway& door : walls.doorways) {
    const WallLine& line = lines[static_cast<std::size_t>(door.line)];
    grid.Close(line.At(door.from_m), line.At(door.to_m));
  }
  grid.Fill();
  const std::vector<RoomGrid::Room> found = grid.Measure();
  std::vector<PlanRoom> rooms;
  for (std::size_t i = 1; i < found.size(); ++i) {
    if (found[i].area_m2 < constants.room.least_m2 || found[i].closed < constants.room.closed_share) continue;
    PlanRoom room{"", {found[i].middle_m.x(), found[i].middle_m.y()}, found[i].area_m2};
    for (const NamedPlace& place : names) {
      if (grid.RoomAt({place.at.x_m, place.at.y_m}) == static_cast<std::int32_t>(i)) room.name = place.name;
    }
    rooms.push_back(room);
  }
  std::ranges::stable_sort(rooms, std::ranges::greater(), &PlanRoom::area_m2);
  return rooms;
}

}  // namespace crsm
