// A reduced car as files: YAML to read, a C header to build in, tables to draw.
#pragma once

#include <string>

#include "identify/reduce.h"

namespace identify {

/// What may be left of the full car before a model is refused.
struct ReduceBounds {
  double lap_share = 0.02;     ///< root mean square of ay on the lap, over the largest
  double limit_share = 0.015;  ///< root mean square of the steady-state limit
};

/// In words why a model must not be used; empty: it may.
std::string why_refused(const Reduction& reduction, const LapError& lap, const ReduceBounds& bounds,
                        bool two_tracks);

/// Formulas, parameters, validity and errors. `source` names the vehicle and the road of the lap,
/// one line without quotes. A refused model has its reason in place of its parameters.
std::string control_yaml(const Reduction& reduction, const LapError& lap,
                         const ReduceBounds& bounds, const std::string& source);

/// C99, all functions static inline, no dependencies but math.h. A refused model has no function.
std::string control_header(const Reduction& reduction, const LapError& lap,
                           const ReduceBounds& bounds, const std::string& source);

/// Side force of the effective axles over slip angle, load and longitudinal force.
std::string axles_csv(const Reduction& reduction);

/// The border: full car and reduced cars at the same longitudinal forces.
std::string border_csv(const Reduction& reduction);

}  // namespace identify
