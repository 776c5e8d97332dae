// The steps of explain_files(), in their order.
#pragma once

#include <string>
#include <vector>

#include "explain/explain_files.h"
#include "explain/read_inputs.h"
#include "explain/simulate.h"
#include "explain/write_back.h"
#include "stages.h"

namespace explain {

/// Nothing that is read may lie where a corrected input will be written. Throws vehicle::Error.
void refuse_to_overwrite(const std::vector<std::string>& inputs, const std::string& folder);

/// Corrected inputs that lie beside a finished set and are none of its files go: of a run whose
/// manifest another command has replaced.
void remove_corrected_of_others(const std::string& folder);

/// Writes the corrected inputs into a folder where none lies.
CorrectedFiles write_corrected(const ExplainRequest& request, const std::string& folder,
                               const StatedRoad& road, const vehicle::Vehicle& car,
                               const Recordings& recordings, const Findings& findings);

/// vehicle.yaml comes last: whoever finds it finds what it names.
void write_car(const CorrectedCar& car, const std::string& folder);

/// Drives the whole simulated car with the stated and with the corrected inputs, writes those with
/// which it is better on laps left out, says of every other finding why it is not used, and adds
/// what came out of driving. The refitted car replaces the corrected one: what was driven is what
/// is handed out.
CorrectedFiles use_what_helps(const ExplainRequest& request, const StatedRoad& road,
                              const vehicle::Vehicle& car, const Recordings& recordings,
                              const Stages& stages, const base::Progress& progress,
                              Findings& findings);

/// How the corrected inputs are simulated with, and looked at again; where none are written, why.
std::vector<NextStep> next_steps(const ExplainRequest& request, const ExplainedFiles& result);

}  // namespace explain
