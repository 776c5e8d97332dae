// Where on the Earth (WGS84) the map coordinates of a road lie.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "base/answer.h"
#include "crg/file.h"

namespace road {

/// UTM on the WGS84 ellipsoid.
struct UtmZone {
  int number = 0;  ///< 1-60
  bool north = true;
};

/// The zone of a position; poles (beyond 84 N, 80 S) have none. Throws Error naming the value.
UtmZone utm_zone(double latitude_deg, double longitude_deg);
/// Easting and northing in `zone`, metres (5 nm accurate within the zone and its neighbours).
Eigen::Vector2d to_utm(const UtmZone& zone, double latitude_deg, double longitude_deg);
/// Latitude and longitude in degrees.
Eigen::Vector2d from_utm(const UtmZone& zone, const Eigen::Vector2d& easting_northing_m);

/// $ROAD_CRG_MPRO for coordinates in `zone`: WGS84 ellipsoid, no datum change, UTM.
std::vector<crg::HeaderEntry> projection_header(const UtmZone& zone);
/// $ROAD_CRG entries REFERENCE_LINE_START_LON/LAT/ALT and END_..., degrees and metres, for a line
/// in `zone`.
std::vector<crg::HeaderEntry> geographic_header(const UtmZone& zone,
                                                const crg::ReferenceLine& line);

/// How map coordinates belong to the Earth (WGS84).
struct Projection {
  enum class Kind : std::uint8_t {
    none,  ///< unknown
    utm,   ///< scale 0.9996 at the middle of the zone: 0.4 m per km against a tape
    tm  ///< transverse Mercator about (latitude_deg, longitude_deg) = (0, 0) m, scale 1 there: true
        ///< to a tape within 0.2 mm per km up to 100 km around
  } kind = Kind::none;
  UtmZone zone;
  double latitude_deg = 0.0, longitude_deg = 0.0;
};

/// The projection of this kind for positions around one place. Throws Error as utm_zone().
Projection projection_at(Projection::Kind kind, double latitude_deg, double longitude_deg);
Eigen::Vector2d project(const Projection& projection, double latitude_deg, double longitude_deg);
/// The same for positions that are only tried: a refusal in place of the Error.
base::Answer<Projection> try_projection_at(Projection::Kind kind, double latitude_deg,
                                           double longitude_deg);
base::Answer<Eigen::Vector2d> try_project(const Projection& projection, double latitude_deg,
                                          double longitude_deg);
/// $ROAD_CRG_MPRO, and REFERENCE_LINE_START_LON ... in $ROAD_CRG, of a file whose `line` lies in
/// `projection`; nothing when that is unknown.
void write_projection(const Projection& projection, const crg::ReferenceLine& line, crg::Crg& file);
/// What write_projection() wrote, into files of others too where they say UTM_nnN or UTM_nnS; kind
/// none for everything else.
Projection read_projection(const crg::Crg& file);
/// Latitude and longitude in degrees of a map point; the reverse of project(). Kind none has no
/// answer.
Eigen::Vector2d unproject(const Projection& projection, const Eigen::Vector2d& map_m);
/// The same as PROJ and OpenDRIVE name it.
std::string proj_text(const Projection& projection);

}  // namespace road
