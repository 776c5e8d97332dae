#include <cmath>

#include "base/error.h"
#include "fuzz/target.h"
#include "vehicle/tyre_file.h"

void fuzz::run(std::string_view bytes) {
  const std::string text(bytes);
  try {
    const vehicle::TyreFile tyre = vehicle::parse_tyre(text, "input.tir");
    require(tyre.coefficients.nominal_load_n > 0.0, "a load");
    const vehicle::TyreFile again = vehicle::parse_tyre(
        vehicle::with_tyre_values(text, {{"PDX1", 1.25}, {"LMUY", 0.5}}), "input.tir");
    require(again.coefficients.pdx1 == 1.25 && again.coefficients.lmuy == 0.5,
            "values that were written are read");
  } catch (const base::Error& error) {
    require_refusal(error, "input.tir");
  }
}
