#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/statistics.h"
#include "defects.h"

namespace road {

std::vector<Finding> find_tile_steps(const HeightMap& map, const FindingOptions& options) {
  std::vector<Finding> found;
  const std::size_t rows = map.rows(), columns = map.columns();
  if (rows < 4) return found;
  const std::size_t stride = std::max<std::size_t>(1, columns / 96);
  std::vector<float> step(rows, 0.0f), share(rows, 0.0f);
  base::parallel_for(rows - 3, 1024, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<float> jumps;
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t i = k + 1;  // between rows i and i + 1
      jumps.clear();
      std::size_t present = 0;
      for (std::size_t j = 0; j < columns; j += stride) {
        // What is left of the rise over one step after the mean of the rises before and behind it.
        const float a = map.at(i - 1, j), b = map.at(i, j), c = map.at(i + 1, j),
                    d = map.at(i + 2, j);
        present += !std::isnan(b);
        const float jump = 1.5f * (c - b) - 0.5f * (d - a);
        if (!std::isnan(jump)) jumps.push_back(jump);
      }
      if (jumps.size() < 3 || 2 * jumps.size() < present) continue;
      const float median = base::quantile(jumps, 0.5);
      std::size_t alike = 0;
      for (const float jump : jumps) alike += jump * median > 0.25f * median * median;
      step[i] = median;
      share[i] = static_cast<float>(alike) / static_cast<float>(jumps.size());
    }
  });
  std::vector<float> sizes;
  for (std::size_t i = 1; i + 2 < rows; ++i) sizes.push_back(std::abs(step[i]));
  const double threshold =
      std::max(options.min_tile_step_m, 10.0 * static_cast<double>(base::quantile(sizes, 0.5)));
  for (std::size_t i = 1; i + 2 < rows; ++i) {
    const double size = std::abs(step[i]);
    if (size < threshold || static_cast<double>(share[i]) < options.min_tile_share) continue;
    // The rows beside a step show half of it with the other sign.
    bool largest = true;
    for (std::size_t k = i > 3 ? i - 2 : 1; k <= std::min(i + 2, rows - 3); ++k) {
      if (std::abs(step[k]) > std::abs(step[i]) ||
          (k < i && std::abs(step[k]) == std::abs(step[i])))
        largest = false;
    }
    if (!largest) continue;
    found.push_back(finding(
        map, "tile_step", map.u_of(i), map.u_of(i + 1), step[i], "m",
        size > options.max_tile_step_m ? Severity::error : Severity::remark,
        fmt::format("The road steps {} by {:.1f} mm at u = {:.1f} m, over {:.0f} % of its width",
                    step[i] > 0 ? "up" : "down", 1000.0 * size, map.u_of(i),
                    100.0 * static_cast<double>(share[i]))));
  }
  return found;
}

}  // namespace road
