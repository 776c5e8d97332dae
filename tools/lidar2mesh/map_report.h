#pragma once

#include <string>

#include "cloud/map.h"
#include "crg/file.h"

namespace lidar2mesh {

/// report.json and report.html in `output_dir`, where refined.crg and base.crg lie already: the
/// validation report of the refined road with sections about coverage, drift and kerbs. `source`:
/// NodeSource per node. Throws as road::make_report.
void write_map_report(const std::string& output_dir, const crg::Crg& base, const crg::Crg& refined,
                      const crg::Grid& source, const cloud::MapReport& facts, unsigned threads);

}  // namespace lidar2mesh
