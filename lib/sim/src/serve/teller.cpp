#include "teller.h"

#include <algorithm>

namespace sim {

void count_step(ServeCounts& counts, double took_s) {
  counts.step_sum_s += took_s;
  counts.longest_step_s = std::max(counts.longest_step_s, took_s);
  const auto bin = std::lower_bound(kStepBins_s.begin(), kStepBins_s.end(), took_s);
  ++counts.bins[static_cast<std::size_t>(bin - kStepBins_s.begin())];
}

std::vector<double> row_of(const MeasurementMessage& measured, const std::vector<double>& recorded,
                           const std::vector<double>& acts, std::uint64_t resets) {
  std::vector<double> row{measured.time_s};
  for (const auto* const values : {&measured.values, &recorded, &acts})
    row.insert(row.end(), values->begin(), values->end());
  row.push_back(measured.is_safe ? 1.0 : 0.0);
  row.push_back(static_cast<double>(resets));
  return row;
}

}  // namespace sim
