#pragma once

#include "common/scan/surface_constants.hpp"

namespace crsm {

/// What the drawing of scans takes for granted. Source: chosen on aces, intel and simulated buildings, and checked on
/// fr079, killian and other seeds.
struct DrawingConstants {
  double occupied_density = 6.0;  ///< Dens_occu: how many times stronger an occupied cell is updated than a free one
  double intensity_min = 0.04;    ///< of the update: it follows the scan's mean sparseness within these
  double intensity_max = 0.2;
  double intensity_limit = 0.95;  ///< asymptotic: no cell is ever certain
  double first_intensity = 0.85;  ///< of a cell's first update, at least
  double erase_behind_m = 0.1;    ///< where hits are, behind them: what was drawn there fades
  double hit_spread = 2.5;        ///< how much of the cells around it a hit occupies, times its bilinear weight
  double join_max_m = 2.0;        ///< hits further apart than this are never joined
  double near_hits_cells = 2.0;   ///< hits this close are neighbours in the map whatever they lie on
  double step_cells = 0.25;       ///< along a surface: no cell on the way gets less than 3/4 of its share
  SurfaceConstants surface = {};

  /// What may be somebody who walks with the robot. Source: the size of people; checked on simulated companions.
  struct Moving {
    double reach_m = 2.5;     ///< from the laser: who walks with it is no further away
    double broadest_m = 1.0;  ///< from end to end
    double apart_m = 0.2;     ///< from one object to another
    double way_m = 0.75;      ///< driven since an object was seen at its place: somebody has left it since
    double near_m = 0.25;     ///< what is that near was seen at the same place: half of that way
    double every_m = 0.1;     ///< driven between scans that are remembered
  };
  Moving moving = {};
};

/// What the text of the paper leaves open. Source: section 6.
struct PaperDrawingConstants {
  double occupied_density = 2.0;  ///< Dens_occu > 1: the paper gives no number
  double intensity_min = 0.0;     ///< "proportionate to the mean sparseness"
  double intensity_max = 1.0;
  double intensity_limit = 0.95;  ///< asymptotic: no cell is ever certain
};

}  // namespace crsm
