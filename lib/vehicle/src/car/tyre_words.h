// What the words of tyre property files mean: units, models, other names of coefficients.
#pragma once

#include <string>
#include <string_view>

namespace vehicle {

/// Factors from the units of a file to SI.
struct TyreUnits {
  double length = 1.0, force = 1.0, mass = 1.0, time = 1.0, pressure = 1.0;
};

/// A line `quantity` = 'unit' of [UNITS], both in capitals. Throws Error on a unit nobody knows and
/// on angles that are not in radians.
void take_tyre_unit(std::string_view quantity, std::string_view unit, const std::string& where,
                    TyreUnits& units);

/// Factor to SI of the value of `keyword`; 1 for all coefficients without a dimension.
double tyre_unit_of(std::string_view keyword, const TyreUnits& units);

/// The name that the formula's authors use where PAC2002 has another one for the same coefficient.
std::string_view tyre_keyword(std::string_view keyword);

/// 52, 61 or 62 for a FITTYP. Throws Error.
int tyre_version_of(double fit_type, const std::string& where);

/// 52 for a PROPERTY_FILE_FORMAT (in capitals) that is the Magic Formula 5.2, else 0: FITTYP must
/// tell. Throws Error where the name is that of another tyre model.
int tyre_version_of_format(std::string_view format, const std::string& where);

}  // namespace vehicle
