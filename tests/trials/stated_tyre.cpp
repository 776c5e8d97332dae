#include "stated_tyre.h"

#include <cstdio>

namespace trials {

std::string tir(const StatedTyre& t) {
  constexpr double kPeak = 1.03, kSlope = 0.924;
  const auto& k = t.shape;
  char text[3000];
  std::snprintf(
      text, sizeof text,
      "[MDI_HEADER]\nFILE_TYPE = 'tir'\nFILE_VERSION = 3\nFILE_FORMAT = 'ASCII'\n[UNITS]\nLENGTH = "
      "'meter'\nFORCE = 'newton'\nANGLE = 'radians'\nMASS = 'kg'\nTIME = 'second'\n"
      "[MODEL]\nFITTYP = 62\nTYRESIDE = 'LEFT'\nLONGVL = 30\n[DIMENSION]\nUNLOADED_RADIUS = "
      "%.5f\n[VERTICAL]\nFNOMIN = %.1f\nVERTICAL_STIFFNESS = 240000\n"
      "VERTICAL_DAMPING = 250\nBREFF = 0\nDREFF = 0\nFREFF = 0\n[LONGITUDINAL_COEFFICIENTS]\nPCX1 "
      "= %.4f\nPDX1 = %.4f\nPDX2 = %.4f\nPEX1 = %.4f\nPKX1 = %.3f\nRBX1 = %.3f\nRBX2 = %.3f\nRCX1 "
      "= 0.93\n"
      "[LATERAL_COEFFICIENTS]\nPCY1 = %.4f\nPDY1 = %.4f\nPDY2 = %.4f\nPEY1 = %.4f\nPKY1 = "
      "%.4f\nPKY2 = 3\nPKY4 = 2\nPKY6 = -1\nPTY1 = %.4f\nPTY2 = 3\nRBY1 = %.3f\nRBY2 = %.3f\nRCY1 "
      "= 0.85\n"
      "[ROLLING_COEFFICIENTS]\nQSY1 = 0.0125\n[ALIGNING_COEFFICIENTS]\nQBZ1 = 10\nQCZ1 = 1.1\nQDZ1 "
      "= 0\n",
      t.radius_m, t.load_n, 1.221 * k[0], kPeak * t.grip, -kPeak * t.grip * t.grip_per_load,
      0.28 * k[1], kSlope * t.slip, 15.7 * k[2], 17.9 * k[3], 1.303 * k[4], kPeak * t.grip,
      -kPeak * t.grip * t.grip_per_load, 0.376 * k[5], -kSlope * t.cornering / 0.6,
      t.relaxation_m / (0.6 * t.radius_m), 21.6 * k[6], 17.8 * k[7]);
  return text;
}

}  // namespace trials
