// Tyre property files (.tir) as data: the coefficients of the Magic Formula 5.2, 6.1 and 6.2.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace vehicle {

/// Load over deflection of a standing tyre, from (0, 0) on, both growing; straight between the
/// points and beyond the last.
struct LoadCurve {
  static constexpr std::size_t kMostPoints = 100;
  std::size_t points = 0;  ///< 0: none, the load follows from the coefficients
  std::array<double, kMostPoints> deflection_m{}, load_n{};
};

/// Coefficients of one tyre, SI units, as in the file. Members are documented by their
/// keyword in tyre_coefficients.def; a keyword the file does not have keeps its default.
struct TyreCoefficients {
#define VEHICLE_TYRE_COEFFICIENT(member, keyword, fallback) double member = fallback;
#include "vehicle/tyre_coefficients.def"
#undef VEHICLE_TYRE_COEFFICIENT
  int version = 62;                    ///< 52, 61 or 62
  bool states_rolling_radius = false;  ///< BREFF, DREFF or FREFF is in the file
  double deflection_share =
      1.0 / 3;             ///< of the deflection that shortens the rolling radius, if not
  bool left_side = false;  ///< TYRESIDE = 'LEFT': the side the coefficients were measured for
  bool friction_ellipse = false;  ///< FE_METHOD = 'YES': combined slip without the weights RBX, RBY
  LoadCurve load_curve;           ///< [DEFLECTION_LOAD_CURVE]
};

/// What read_tyre found beside the coefficients.
struct TyreFile {
  TyreCoefficients coefficients;
  std::vector<std::string> defaulted;  ///< keywords of the formula that the file does not have
  std::vector<std::string> unused;     ///< numeric keywords of the file that nothing uses
  std::vector<std::string> remarks;    ///< what was taken for granted, a sentence each
};

/// Reads a .tir file. FITTYP 5, 6, 21, 51, 52 (all 5.2), 60, 61, 62, or PROPERTY_FILE_FORMAT of 5.2
/// (PAC2002, MF_05) without one; any units of length, force, mass, time and pressure that [UNITS]
/// names, angles in radians, axes ISO-W (a positive slip angle gives a negative side force). Throws
/// Error with file:line on anything that is not such a file, on values that are not finite or
/// physically impossible, and on two different values for one keyword that the formula has.
TyreFile read_tyre(const std::string& path);

/// No tyre file is read that is longer.
inline constexpr std::size_t kLargestTyreBytes = std::size_t{4} << 20;

/// The same from text; `name` stands for the path in errors.
TyreFile parse_tyre(const std::string& text, const std::string& name);

/// The text of a .tir file with other values: where a keyword has one outside [UNITS], in its
/// place; else in a section of its own at the end. Everything else stays to the byte, remarks
/// behind a value excepted. Keywords in capitals, values in SI units. Precondition: parse_tyre()
/// takes the text.
std::string with_tyre_values(const std::string& text, const std::map<std::string, double>& values);

}  // namespace vehicle
