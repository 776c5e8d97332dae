// Places where somebody says what is kerb and what is not, whatever the mesh calls it.
#pragma once

#include <string>
#include <vector>

#include "road/road_mesh.h"

namespace road {

/// A rectangle in u and v. u_begin_m > u_end_m goes over the start of a closed road.
struct KerbZone {
  double u_begin_m = 0.0, u_end_m = 0.0, v_begin_m = 0.0, v_end_m = 0.0;
  bool kerb = false;  ///< true: what has a height there is kerb; false: nothing is
};

/// CSV with the columns u_begin_m,u_end_m,v_begin_m,v_end_m,kerb; kerb is 1 or 0, later rows lie
/// over earlier ones. Throws Error with file:line on a missing number, v_begin_m > v_end_m, or a
/// kerb that is neither.
std::vector<KerbZone> read_kerb_zones(const std::string& path);

/// The class at (u, v) that was `found` on the mesh there: kerb where a zone says so, road where
/// one says that it is no kerb.
SurfaceClass zoned(SurfaceClass found, double u_m, double v_m, const std::vector<KerbZone>& zones);

}  // namespace road
