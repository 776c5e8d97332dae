// Drives along a road and prints what lies under one wheel. Usage: example ROAD.crg
#include <cstdio>

#include "crg/error.h"
#include "crg/surface.h"

int main(int argc, char** argv) try {
  const crg::Surface road(crg::read(argc > 1 ? argv[1] : "road.crg"));
  crg::Cursor wheel;
  for (double u_m = 1.0; u_m < 5.0; u_m += 1.0) {
    const crg::Point2 at = road.xy_of_uv(u_m, 0.5);
    const crg::Sample s = road.at_xy(at.x_m, at.y_m, wheel);
    std::printf("z %.3f slope %.3f %.3f heading %.3f friction %.2f\n", s.z_m, s.dzdx, s.dzdy,
                s.heading_rad, s.friction);
  }
} catch (const crg::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
