// A road for other programs: OpenDRIVE, tyre models' road data files, maps, game engines.
#pragma once

#include <string>
#include <vector>

#include "crg/surface.h"
#include "mesh/mesh.h"
#include "road/road_edges.h"

namespace road {

/// The text of a file, and what of the road its format cannot hold or holds less exactly.
struct Exported {
  std::string text;
  std::vector<std::string> lost;
};

/// Files that an exported one names, as it shall name them.
struct NamedFiles {
  std::string crg;
  std::string friction_crg;  ///< empty: none
};

/// ASAM OpenDRIVE 1.8: one road whose reference line is that of the CRG, with a driving lane to
/// either side, elevation and superelevation, and the CRG attached as "genuine". Elevation and
/// superelevation are those of the straight line through both edges of each row; `lost` says how
/// far the surface between lies from it, also in `userData`. Widths lie in the plane that leans, as
/// t does. The outer edges of the lanes are within 2 mm of the road's, x, y and z; between rows too
/// where the line turns smoothly from row to row. Lanes end at `edges`, as track_widths() has them.
/// A closed road is its own successor.
/// Throws Error where the line has no road on it.
Exported opendrive(const crg::Surface& road, const std::string& name, const NamedFiles& files,
                   const RoadEdges& edges = {});

/// A road data file (.rdf) of tyre models that names the CRG: METHOD, ROAD_TYPE and CRG_ROADFILE as
/// the manual of Altair MotionView describes them. `friction` is its MU.
Exported road_data_file(const NamedFiles& files, double friction);

/// Reference line, borders, start and kerbs as GeoJSON (RFC 7946) or KML. Throws Error where the
/// file does not say where on the Earth it lies (UTM or TM in $ROAD_CRG_MPRO).
Exported plan_geojson(const crg::Surface& road);
Exported plan_kml(const crg::Surface& road, const std::string& name);
/// The same as a drawing, 1 unit a metre, north up.
Exported plan_svg(const crg::Surface& road);

/// The surface as triangles, objects and materials "road" and "kerb": every row that is
/// `step_m` from the one before, all columns. Coordinates are the map's less `origin_m`, which is 0
/// for roads within 10 km of the map's zero, so that 32 bits hold them to 1 mm. Throws Error beyond
/// 5 million triangles.
Mesh surface_mesh(const crg::Surface& road, double step_m, Eigen::Vector3d& origin_m);

}  // namespace road
