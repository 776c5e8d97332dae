// Layers of a surface along a guide, and which of them is the road.
#pragma once

#include <vector>

#include "guide_rows.h"

namespace road {

inline constexpr double kBeside =
    0.25;  ///< of the reach: how far the guide may lie beside the road

/// A height at which the surface lies, and what speaks against it.
struct Layer {
  double z_m = 0.0, cost = 0.0;
};

/// Layers of the surface near one row, each with what speaks against it.
std::vector<Layer> layers_at(const GuideRow& row, const GuideRows& all, double scale,
                             const RaySurface& surface, const LooksLikeRoad& looks_like_road);

/// Lets the guide's heights speak, which may begin elsewhere: where there is only one layer they
/// tell from where.
void weigh_heights(const GuideRows& all, double scale, std::vector<std::vector<Layer>>& layers);

/// The cheapest way through the layers of all rows; NaN where it is best to have none.
std::vector<double> best_layers(const std::vector<std::vector<Layer>>& layers, double step_m,
                                double scale);

}  // namespace road
