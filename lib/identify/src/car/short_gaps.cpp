#include "identify/short_gaps.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace identify {

recording::Recording without_short_gaps(recording::Recording recording, double longest_s) {
  recording::Table& table = recording.table;
  const std::vector<double>* const found = table.find("time_s");
  if (found == nullptr) return recording;
  const std::vector<double> time_s = *found;
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    if (table.names[c] == "time_s") continue;
    std::vector<double>& v = table.columns[c];
    const bool steps = table.names[c] == "gear";
    for (const recording::Stretch& stretch : recording.stretches) {
      std::size_t last = stretch.end;  // none yet
      for (std::size_t k = stretch.begin; k < stretch.end; ++k) {
        if (!std::isfinite(v[k])) continue;
        if (last < k && time_s[k] - time_s[last] <= longest_s)
          for (std::size_t i = last + 1; i < k; ++i) {
            const double way = (time_s[i] - time_s[last]) / (time_s[k] - time_s[last]);
            v[i] = steps ? v[last] : v[last] + way * (v[k] - v[last]);
          }
        last = k;
      }
    }
  }
  return recording;
}

}  // namespace identify
