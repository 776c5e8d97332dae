#include "stated_tyre.h"

#include <cmath>
#include <cstdio>

namespace trials {

std::string tir(const StatedTyre& t) {
  const TyreFit& f = *t.fit;
  const double across = std::sin(2 * std::atan(1 / f.load_y));  // of the stiffness at FNOMIN
  const auto& k = t.shape;
  char text[3000];
  std::snprintf(
      text, sizeof text,
      "[MDI_HEADER]\nFILE_TYPE = 'tir'\nFILE_VERSION = 3\nFILE_FORMAT = 'ASCII'\n[UNITS]\nLENGTH = "
      "'meter'\nFORCE = 'newton'\nANGLE = 'radians'\nMASS = 'kg'\nTIME = 'second'\n"
      "[MODEL]\nFITTYP = 62\nTYRESIDE = 'LEFT'\nLONGVL = 30\n[DIMENSION]\nUNLOADED_RADIUS = "
      "%.5f\n[VERTICAL]\nFNOMIN = %.1f\nVERTICAL_STIFFNESS = 240000\n"
      "VERTICAL_DAMPING = 250\nBREFF = 0\nDREFF = 0\nFREFF = 0\n[LONGITUDINAL_COEFFICIENTS]\nPCX1 "
      "= %.4f\nPDX1 = %.4f\nPDX2 = %.4f\nPEX1 = %.4f\nPKX1 = %.3f\nPKX2 = %.4f\nRBX1 = %.3f\nRBX2 "
      "= %.3f\nRCX1 "
      "= %.3f\n"
      "[LATERAL_COEFFICIENTS]\nPCY1 = %.4f\nPDY1 = %.4f\nPDY2 = %.4f\nPEY1 = %.4f\nPKY1 = "
      "%.4f\nPKY2 = %.3f\nPKY4 = 2\nPKY6 = -1\nPTY1 = %.4f\nPTY2 = 3\nRBY1 = %.3f\nRBY2 = "
      "%.3f\nRCY1 "
      "= %.3f\n"
      "[ROLLING_COEFFICIENTS]\nQSY1 = 0.0125\n[ALIGNING_COEFFICIENTS]\nQBZ1 = 10\nQCZ1 = 1.1\nQDZ1 "
      "= 0\n",
      t.radius_m, t.load_n, f.curve_x * k[0], f.peak_x * t.grip,
      -f.peak_x * t.grip * t.grip_per_load * f.loss, f.bend_x * k[1], f.slope_x * t.slip,
      f.slope_x_load * t.slip, f.rbx1 * k[2], f.rbx2 * k[3], f.rcx1, f.curve_y * k[4],
      f.peak_y * t.grip, -f.peak_y * t.grip * t.grip_per_load * f.loss, f.bend_y * k[5],
      -f.slope_y * t.cornering / across, f.load_y, t.relaxation_m / (0.6 * t.radius_m),
      f.rby1 * k[6], f.rby2 * k[7], f.rcy1);
  return text;
}

}  // namespace trials
