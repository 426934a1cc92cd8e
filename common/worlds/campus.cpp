#include "common/worlds/campus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include "common/math/random.hpp"
#include "common/worlds/world.hpp"

namespace crsm {
namespace {

constexpr int kColumns = 6;
constexpr int kRows = 5;

struct Hall {
  Point middle;
  double half_width_m = 0.0;
  double half_height_m = 0.0;
};

/// From a hall to its neighbour on the right or above.
struct Corridor {
  int from = 0;
  int to = 0;
  double width_m = 0.0;

  bool along_x() const { return to == from + 1; }
};

double Distance(const Point& a, const Point& b) {
  return std::sqrt((b.x_m - a.x_m) * (b.x_m - a.x_m) + (b.y_m - a.y_m) * (b.y_m - a.y_m));
}

class Campus {
 public:
  explicit Campus(std::uint64_t number) : random_(number) {
    AddHalls();
    AddCorridors();
    for (int hall = 0; hall < kColumns * kRows; ++hall) DrawHall(hall);
    for (const Corridor& corridor : corridors_) DrawCorridor(corridor);
  }

  void DriveFor(double length_m);

  const std::string& text() const { return text_; }

 private:
  double Draw(double low, double high) { return random_.Uniform(low, high); }
  bool Toss(double chance) { return Draw(0.0, 1.0) < chance; }

  void AddHalls();
  void AddCorridors();
  void DrawHall(int index);
  void DrawCorridor(const Corridor& corridor);
  void DrawSide(const Point& from, const Point& to, const Point& outwards);
  void DrawWall(const Point& from, const Point& to);

  /// The corridor between two halls; null if there is none.
  const Corridor* Between(int a, int b) const;
  std::vector<int> Neighbours(int hall) const;

  Random random_;
  std::vector<Hall> halls_;
  std::vector<Corridor> corridors_;
  std::string text_ = "laser 180 180 30 5 0.01 dropout 0.01\nspeed 1.0 0.8\n";
};

void Campus::AddHalls() {
  std::array<double, kColumns> xs_m{};
  std::array<double, kRows> ys_m{};
  for (std::size_t i = 1; i < xs_m.size(); ++i) xs_m[i] = xs_m[i - 1] + Draw(28.0, 52.0);
  for (std::size_t i = 1; i < ys_m.size(); ++i) ys_m[i] = ys_m[i - 1] + Draw(25.0, 45.0);
  for (const double y_m : ys_m) {
    for (const double x_m : xs_m) {
      const double half_width_m = Draw(1.8, 4.0);
      const double half_height_m = Draw(1.8, 4.0);
      halls_.push_back({{x_m, y_m}, half_width_m, half_height_m});
    }
  }
}

/// All that a grid has, but for some; each hall keeps two.
void Campus::AddCorridors() {
  for (int hall = 0; hall < kColumns * kRows; ++hall) {
    if (hall % kColumns + 1 < kColumns) corridors_.push_back({hall, hall + 1, Draw(1.8, 2.8)});
    if (hall / kColumns + 1 < kRows) corridors_.push_back({hall, hall + kColumns, Draw(1.8, 2.8)});
  }
  for (auto corridor = corridors_.begin(); corridor != corridors_.end();) {
    const bool is_spare = Neighbours(corridor->from).size() > 2 && Neighbours(corridor->to).size() > 2;
    corridor = Toss(0.25) && is_spare ? corridors_.erase(corridor) : corridor + 1;
  }
}

void Campus::DrawHall(int index) {
  const Hall& hall = halls_[static_cast<std::size_t>(index)];
  // A side with its corridor's mouth in the middle. At: the points of the side, from -1 to 1.
  const auto DrawSideOf = [&](const Corridor* corridor, double half_m, const auto& At) {
    const double mouth = corridor ? 0.5 * corridor->width_m / half_m : 0.0;
    DrawWall(At(-1.0), At(-mouth));
    DrawWall(At(mouth), At(1.0));
  };
  for (const int way : {-1, 1}) {
    DrawSideOf(Between(index, index + way), hall.half_height_m, [&](double at) {
      return Point{hall.middle.x_m + way * hall.half_width_m, hall.middle.y_m + at * hall.half_height_m};
    });
    DrawSideOf(Between(index, index + way * kColumns), hall.half_width_m, [&](double at) {
      return Point{hall.middle.x_m + at * hall.half_width_m, hall.middle.y_m + way * hall.half_height_m};
    });
  }
  constexpr double kRoomForBoxes_m = 2.4;
  if (hall.half_width_m < kRoomForBoxes_m || hall.half_height_m < kRoomForBoxes_m) return;
  for (const double side_x : {-1.0, 1.0}) {
    for (const double side_y : {-1.0, 1.0}) {
      const double width_m = Draw(0.3, 0.6);
      const double height_m = Draw(0.3, 0.6);
      if (Toss(0.5)) continue;
      text_ +=
          fmt::format("box {:.3f} {:.3f} {:.3f} {:.3f}\n", hall.middle.x_m + side_x * (hall.half_width_m - 0.5) - 0.3,
                      hall.middle.y_m + side_y * (hall.half_height_m - 0.5) - 0.3, width_m, height_m);
    }
  }
}

void Campus::DrawCorridor(const Corridor& corridor) {
  const Hall& from = halls_[static_cast<std::size_t>(corridor.from)];
  const Hall& to = halls_[static_cast<std::size_t>(corridor.to)];
  for (const double way : {-1.0, 1.0}) {
    const double beside_m = way * 0.5 * corridor.width_m;
    if (corridor.along_x()) {
      const double y_m = from.middle.y_m + beside_m;
      DrawSide({from.middle.x_m + from.half_width_m, y_m}, {to.middle.x_m - to.half_width_m, y_m}, {0.0, way});
    } else {
      const double x_m = from.middle.x_m + beside_m;
      DrawSide({x_m, from.middle.y_m + from.half_height_m}, {x_m, to.middle.y_m - to.half_height_m}, {way, 0.0});
    }
  }
}

/// A wall with doors, which stand back by some centimetres, and niches. outwards: unit vector.
void Campus::DrawSide(const Point& from, const Point& to, const Point& outwards) {
  const double length_m = Distance(from, to);
  const Point along{(to.x_m - from.x_m) / length_m, (to.y_m - from.y_m) / length_m};
  const auto At = [&](double way_m, double depth_m) {
    return Point{from.x_m + way_m * along.x_m + depth_m * outwards.x_m,
                 from.y_m + way_m * along.y_m + depth_m * outwards.y_m};
  };
  constexpr double kWidest_m = 1.4;
  double end_m = 0.0;  // of the last niche
  double begin_m = Draw(0.5, 4.0);
  while (begin_m + kWidest_m < length_m - 0.1) {
    constexpr std::array<double, 4> kDoorDepths_m{0.1, 0.15, 0.25, 0.4};
    const bool is_door = Toss(0.8);
    const double depth_m = is_door ? kDoorDepths_m[random_.Next() % kDoorDepths_m.size()] : Draw(1.0, 3.0);
    const double next_end_m = begin_m + Draw(0.8, kWidest_m);
    DrawWall(At(end_m, 0.0), At(begin_m, 0.0));
    DrawWall(At(begin_m, 0.0), At(begin_m, depth_m));
    DrawWall(At(begin_m, depth_m), At(next_end_m, depth_m));
    DrawWall(At(next_end_m, depth_m), At(next_end_m, 0.0));
    end_m = next_end_m;
    begin_m = end_m + (Toss(0.5) ? Draw(1.5, 4.0) : Draw(3.0, 9.0));
  }
  DrawWall(At(end_m, 0.0), At(length_m, 0.0));
}

void Campus::DrawWall(const Point& from, const Point& to) {
  text_ += fmt::format("wall {:.3f} {:.3f} {:.3f} {:.3f}\n", from.x_m, from.y_m, to.x_m, to.y_m);
}

void Campus::DriveFor(double length_m) {
  std::vector<int> num_visits(halls_.size(), 0);
  int before = -1;
  int here = 0;
  double driven_m = 0.0;
  Point last;
  for (bool first = true; driven_m < length_m; first = false) {
    const Point& middle = halls_[static_cast<std::size_t>(here)].middle;
    const Point point{middle.x_m + Draw(-0.3, 0.3), middle.y_m + Draw(-0.3, 0.3)};
    text_ += fmt::format("waypoint {:.3f} {:.3f}\n", point.x_m, point.y_m);
    if (!first) driven_m += Distance(last, point);
    last = point;
    ++num_visits[static_cast<std::size_t>(here)];

    std::vector<int> ways = Neighbours(here);
    std::erase(ways, before);  // each hall has another one
    std::vector<double> visits;
    for (const int way : ways) visits.push_back(num_visits[static_cast<std::size_t>(way)] + Draw(0.0, 2.0));
    const auto least = std::min_element(visits.begin(), visits.end()) - visits.begin();
    const auto any = static_cast<std::ptrdiff_t>(random_.Next() % ways.size());
    before = here;
    here = ways[static_cast<std::size_t>(Toss(0.7) ? least : any)];
  }
}

const Corridor* Campus::Between(int a, int b) const {
  const auto found = std::find_if(corridors_.begin(), corridors_.end(), [&](const Corridor& corridor) {
    return corridor.from == std::min(a, b) && corridor.to == std::max(a, b);
  });
  return found == corridors_.end() ? nullptr : &*found;
}

std::vector<int> Campus::Neighbours(int hall) const {
  std::vector<int> neighbours;
  for (const int other : {hall - 1, hall + 1, hall - kColumns, hall + kColumns}) {
    if (Between(hall, other)) neighbours.push_back(other);
  }
  return neighbours;
}

}  // namespace

std::string DrawCampus(double length_m, std::uint64_t number) {
  Campus campus(number);
  campus.DriveFor(length_m);
  return campus.text();
}

}  // namespace crsm
