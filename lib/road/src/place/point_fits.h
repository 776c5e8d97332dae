// Motions fitted to pairs of points by least squares. Private to the alignment.
#pragma once

#include <cstddef>
#include <vector>

#include "road/align.h"

namespace road {

/// Control points nearer to each other than this fix no rotation.
inline constexpr double kSmallestSpread_m = 3.0;

using Indices = std::vector<std::size_t>;

/// 0, 1 ... count - 1.
Indices all_of(std::size_t count);

/// Rotation about z and translation by least squares: the angle that turns the summed dot and cross
/// products of the centred points into one another (the plane case of Umeyama 1991).
RotoTranslation fit(const std::vector<ControlPoint>& points, const Indices& used,
                    double mirror = 1.0);

/// With `mirror` = -1 the points of the mesh are mirrored first.
double residual(const RotoTranslation& T, const ControlPoint& point, double mirror = 1.0);
double residual(const Similarity& T, const ControlPoint& point);
double rms(const RotoTranslation& T, const std::vector<ControlPoint>& points, const Indices& used,
           double mirror = 1.0);
double rms(const Similarity& T, const std::vector<ControlPoint>& points, const Indices& used);

/// Least squares over the points used, as the options want it. A refusal of a degenerate set.
base::Answer<Similarity> fit_as(const AlignOptions& options,
                                const std::vector<ControlPoint>& points, const Indices& used);

}  // namespace road
