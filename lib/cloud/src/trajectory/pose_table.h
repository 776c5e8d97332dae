// Files of poses as tables: a CSV by its names, or the text of the TUM benchmark.
#pragma once

#include <string>

#include "base/csv.h"

namespace cloud {

/// Columns time_s, x_m, y_m, z_m, qx, qy, qz, qw. A text without a header whose lines have eight
/// numbers between blanks is taken as TUM's, which are the same in this order. Throws Error, with
/// the way out: a binary file (SBET), poses without times (KITTI), other tables.
base::CsvTable pose_table(const std::string& path);

}  // namespace cloud
