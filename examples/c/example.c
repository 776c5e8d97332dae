/* Drives along a road and prints what lies under one wheel. Usage: example ROAD.crg */
#include <crg.h>
#include <stdio.h>

int main(int argc, char** argv) {
  char why[256];
  crg_surface* road = crg_open(argc > 1 ? argv[1] : "road.crg", NULL, why, sizeof why);
  if (road == NULL) return fprintf(stderr, "%s\n", why), 1;
  crg_cursor wheel = {0};
  for (double u_m = 1.0; u_m < 5.0; u_m += 1.0) {
    double x_m, y_m;
    crg_sample s;
    crg_xy_of_uv(road, u_m, 0.5, &x_m, &y_m);
    crg_at_xy(road, x_m, y_m, &wheel, &s);
    printf("z %.3f slope %.3f %.3f heading %.3f friction %.2f\n", s.z_m, s.dzdx, s.dzdy,
           s.heading_rad, s.friction);
  }
  crg_close(road);
  return 0;
}
