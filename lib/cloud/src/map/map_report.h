#pragma once

#include "base/output_set.h"
#include "cloud/map.h"
#include "crg/file.h"
#include "inspect/input_file.h"

namespace cloud {

/// report.json and report.html in `outputs`, where refined.crg and base.crg are staged already: the
/// validation report of the refined road with sections about coverage, drift and kerbs. `facts`:
/// those of `result` with all remarks; `inputs` are listed. Throws as road::make_report.
void write_map_report(const base::OutputSet& outputs, const crg::Crg& base, const crg::Crg& refined,
                      const MapResult& result, const MapReport& facts,
                      const std::vector<road::InputFile>& inputs, unsigned threads);

}  // namespace cloud
