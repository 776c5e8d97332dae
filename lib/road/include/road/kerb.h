// Kerbs on the grid: where they are, and columns fine enough to carry their profile.
#pragma once

#include "road/kerb_zones.h"
#include "road/sample.h"

namespace road {

struct Kerb {
  double u_begin_m, u_end_m;
  double v_begin_m, v_end_m;  ///< across, from the right
  double height_m;     ///< largest rise above the road beside it, continued with its cross slope
  double u_highest_m;  ///< where that is
};

struct KerbOptions {
  double max_extra_columns_share = 0.5;        ///< at most this share of new columns (file size)
  double min_height_m = 0.01;                  ///< lower strips named as kerb are not refined
  std::optional<std::string> zones_path = {};  ///< what the zones are read from
  std::vector<KerbZone> zones = {};  ///< over what the mesh says, later ones over earlier ones
  unsigned threads = 0;              ///< 0 = all cores; any number gives the same bytes
};

struct KerbReport {
  std::vector<Kerb> kerbs;
  std::size_t cells = 0;  ///< nodes on kerbs after refinement
  std::size_t columns_added = 0;
};

/// What the zones say of the nodes, into surface_class.
void mark_kerb_zones(SampledGrid& sampled, const std::vector<KerbZone>& zones);

/// Adds v columns at kerb edges (resampled by rays) and marks kerb nodes in surface_class, as the
/// mesh and the zones say.
SampledGrid refine_kerbs(SampledGrid sampled, const RaySurface& surface, const RoadMesh& road,
                         const crg::ReferenceLine& line, const KerbOptions& options = {},
                         KerbReport* report = nullptr);

}  // namespace road
