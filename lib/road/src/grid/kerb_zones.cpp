#include "road/kerb_zones.h"

#include <fmt/format.h>

#include "base/csv.h"
#include "mesh/error.h"

namespace road {

std::vector<KerbZone> read_kerb_zones(const std::string& path) {
  const base::CsvTable table =
      base::read_csv(path, {"u_begin_m", "u_end_m", "v_begin_m", "v_end_m", "kerb"});
  std::vector<KerbZone> zones;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const auto fail = [&](const std::string& what) {
      throw Error(fmt::format("{}:{}: {}", path, table.line[i], what));
    };
    const KerbZone zone{table.value(i, 0), table.value(i, 1), table.value(i, 2), table.value(i, 3),
                        table.value(i, 4) == 1.0};
    if (zone.v_begin_m > zone.v_end_m)
      fail(fmt::format("v_begin_m {} lies left of v_end_m {}; wanted from right to left",
                       zone.v_begin_m, zone.v_end_m));
    if (!zone.kerb && table.value(i, 4) != 0.0)
      fail(fmt::format("kerb is {}; wanted 1 (kerb) or 0 (none)", table.value(i, 4)));
    zones.push_back(zone);
  }
  return zones;
}

SurfaceClass zoned(SurfaceClass found, double u_m, double v_m, const std::vector<KerbZone>& zones) {
  for (const KerbZone& zone : zones) {
    const bool along = zone.u_begin_m <= zone.u_end_m
                           ? u_m >= zone.u_begin_m && u_m <= zone.u_end_m
                           : u_m >= zone.u_begin_m || u_m <= zone.u_end_m;
    if (!along || v_m < zone.v_begin_m || v_m > zone.v_end_m) continue;
    if (zone.kerb)
      found = SurfaceClass::kerb;
    else if (found == SurfaceClass::kerb)
      found = SurfaceClass::road;
  }
  return found;
}

}  // namespace road
