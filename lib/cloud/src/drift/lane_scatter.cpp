#include "lane_scatter.h"

#include <algorithm>
#include <cmath>

namespace cloud {

double LaneScatter::octaves_of(const SectionCell& cell) {
  const auto sine2 = static_cast<double>(cell.sine2);
  if (!(sine2 > 0.0)) return 0.0;
  return std::clamp(-std::log2(sine2), 0.0, static_cast<double>(kBins - 1));
}

void LaneScatter::add(const SectionCell& cell) {
  const double octaves = octaves_of(cell);
  Bin& bin = bins_[static_cast<std::size_t>(octaves)];
  const auto own = static_cast<double>(cell.freedom);
  bin.freedom += own, bin.square_m2 += static_cast<double>(cell.square_m2);
  bin.octaves += own * octaves;
}

void LaneScatter::close() {
  constexpr double kEnough = 50.0;
  const auto known = [&](std::size_t k) { return k < kBins && bins_[k].freedom >= kEnough; };
  for (std::size_t k = 0; k < kBins; ++k)
    for (std::size_t away = 0; away < kBins; ++away) {
      const std::size_t from = known(k - away) ? k - away : k + away;
      if (!known(from)) continue;
      nearest_m2_[k] = bins_[from].square_m2 / bins_[from].freedom;
      break;
    }
  for (const double least : {kEnough, 1.0}) {
    for (const Bin& bin : bins_)
      if (bin.freedom >= least)
        octaves_.push_back(bin.octaves / bin.freedom),
            per_freedom_m2_.push_back(bin.square_m2 / bin.freedom);
    if (!octaves_.empty()) return;
  }
}

double LaneScatter::in_bin_m2(const SectionCell& cell) const {
  return nearest_m2_[static_cast<std::size_t>(octaves_of(cell))];
}

double LaneScatter::at_m2(const SectionCell& cell) const {
  if (octaves_.empty()) return 0.0;
  const double x = octaves_of(cell);
  const auto after = static_cast<std::size_t>(
      std::upper_bound(octaves_.begin(), octaves_.end(), x) - octaves_.begin());
  if (after == 0) return per_freedom_m2_.front();
  if (after == octaves_.size()) return per_freedom_m2_.back();
  const double share = (x - octaves_[after - 1]) / (octaves_[after] - octaves_[after - 1]);
  return (1.0 - share) * per_freedom_m2_[after - 1] + share * per_freedom_m2_[after];
}

}  // namespace cloud
