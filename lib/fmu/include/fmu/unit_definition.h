// What a unit is made of, for UnitDefinitions.
#pragma once

#include <string>
#include <string_view>

namespace fmu {

/// factor * kg^kg * m^m * s^s * K^K * rad^rad.
struct UnitDefinition {
  int kg = 0, m = 0, s = 0, K = 0, rad = 0;
  double factor = 1.0;
};

/// Takes a unit apart: symbols kg m s K rad N Pa J W MJ 1 with whole exponents ("m2"), products
/// with a blank or a point, at most one "/" after which brackets may stand ("J/(K m)"). Throws
/// base::Error on anything else: a parameter with a new unit must not go out without definition.
UnitDefinition define_unit(std::string_view unit);

}  // namespace fmu
