#pragma once

#include "cloud/map.h"
#include "crg/file.h"
#include "files/output_set.h"

namespace lidar2mesh {

/// report.json and report.html in `outputs`, where refined.crg and base.crg are staged already: the
/// validation report of the refined road with sections about coverage, drift and kerbs. `source`:
/// NodeSource per node. Throws as road::make_report.
void write_map_report(const files::OutputSet& outputs, const crg::Crg& base, const crg::Crg& refined,
                      const crg::Grid& source, const cloud::MapReport& facts, unsigned threads);

}  // namespace lidar2mesh
