#include "inspect/compare.h"

#include <algorithm>

#include "deviations.h"
#include "error_map.h"
#include "kerb_losses.h"
#include "map_rows.h"

namespace road {

Comparison compare(const HeightMap& map, const KerbStrips& kerbs, const ReferenceHeights& reference,
                   const std::string& name, const CompareOptions& options,
                   std::span<const PlaceError> known) {
  Comparison result;
  make_error_map(map, reference, options, result);
  make_statistics(result);
  const ReferenceKerbs of_reference = kerbs_of_reference(map, reference, options);
  find_kerb_losses(map, of_reference, name, options, result);
  find_deviations(map, of_reference, name, options, result);
  const std::vector<PlaceError> shown = show_known(known, result);
  make_statistics(result);
  find_worst(map, reference, options, shown, result);
  for (const KerbStrip& kerb : kerbs.strips) {
    const auto [low, high] = std::minmax(kerb.v_begin_m, kerb.v_end_m);
    result.kerb_cuts.push_back(
        cut(map, reference, kerb.u_of_profile_m, 0.5 * (low + high), low - 1.5, high + 1.5));
  }
  return result;
}

}  // namespace road
