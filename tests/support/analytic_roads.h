// Small roads whose heights and lines are one-line formulas, as meshes. Written without the
// library's own circuit code, so that tests of either can use them as a ruler.
#pragma once

#include <functional>
#include <string>

#include "crg/reference_line.h"
#include "mesh/mesh.h"

namespace support {

/// Vertices lie on z(u, v) exactly; between them the mesh is flat facets. u runs along the middle
/// of the road, v to its left.
struct AnalyticRoad {
  std::string name;
  road::Mesh mesh;  ///< object "road" with material "asphalt" first; "kerb" where there is one
  bool closed = false;
  double length_m = 0.0;
  double half_width_m = 0.0;
  std::function<double(double u_m, double v_m)> z_m;
  std::function<crg::Point2(double u_m, double v_m)> position_m;
  double facet_error_m =
      0.0;  ///< largest distance in z of the facets from z_m, by calculus (figure_eight: measured)
};

/// Along +x from the origin, z = height_m.
AnalyticRoad flat_straight(double length_m = 200.0, double half_width_m = 5.0,
                           double height_m = 0.0);

/// Circle about the origin, counter-clockwise from (radius, 0); z rises by `banking` m/m to the
/// left, that is inwards: a cone. Facets `facet_m` long.
AnalyticRoad banked_circle(double radius_m = 100.0, double half_width_m = 6.0,
                           double banking = -0.1, double facet_m = 1.0);

/// Along +x, z = amplitude * sin(2 pi u / wavelength).
AnalyticRoad wavy_straight(double length_m = 300.0, double half_width_m = 5.0,
                           double amplitude_m = 0.5, double wavelength_m = 60.0,
                           double facet_m = 0.5);

/// Two straights of `straight_m` along x, joined by half circles, counter-clockwise, flat; u = 0 at
/// the beginning of the lower straight, (0, -radius). On its left from u = 40 to 80 m lies a kerb 1
/// m wide that rises to `kerb_height_m` over 0.9 m and falls over 0.1 m, without tapers; its z is
/// in z_m, v up to half_width + 1.
AnalyticRoad stadium_with_kerb(double straight_m = 200.0, double radius_m = 50.0,
                               double half_width_m = 5.0, double kerb_height_m = 0.06);

/// A closed figure of eight, x = 200 sin t, y = 100 sin 2t, z = height / 2 * (1 + cos t): at the
/// origin the leg of t = 0 passes `height_m` above that of t = pi, at right angles. u is the
/// parameter t scaled to the length, not arc length; position and z are exact in it.
AnalyticRoad figure_eight(double height_m = 8.8, double half_width_m = 5.0, double facet_m = 1.0);

}  // namespace support
