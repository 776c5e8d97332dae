// The stated car of a blind trial: what the simulation is told, and how wrong that is.
#pragma once

#include <string>
#include <vector>

#include "blind_effects.h"
#include "stated.h"

namespace trials {

/// A parameter of the stated car.
struct Parameter {
  const char *id, *name;
  bool commanded;                   ///< can be seen only where the log has commands
  void (*scale)(Variant&, double);  ///< multiplies it
};
extern const std::vector<Parameter> kParameters;

/// Truth over stated, less one, per parameter.
struct Deviations {
  std::vector<double> share;
  std::string compensated;  ///< id of the parameter that was tuned to hide the effect, if any
};
/// A few per cent everywhere, further in what the trial is about.
Deviations deviate(const Question& question, const std::vector<Effect>& effects, Random& dice);

/// The truth with one parameter as stated.
Variant with_stated(Variant nominal, std::size_t parameter, const Deviations& deviations);

/// Its files, without the terms that `effects` are about; what has no parameter is a few per cent
/// off too.
StatedCar stated_car(const Variant& nominal, const Deviations& deviations,
                     const std::vector<Effect>& effects, Random& dice);

}  // namespace trials
