// A rough line along the road, from somebody who knows where it is.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace road {

/// A file as it is: positions along the road, metres off, in the order of driving.
struct GuideFile {
  bool geographic = false;
  /// x, y, z in metres in the frame of the mesh, or latitude and longitude in degrees (WGS84) and
  /// the height in metres. Heights that are not known are NaN.
  std::vector<Eigen::Vector3d> points;
};

/// CSV with x_m,y_m[,z_m] (a driven log of crgdrive too) or lat_deg,lon_deg[,h_m]; GPX (the longest
/// track, or route), KML (the longest line, ring or gx:Track), GeoJSON (the longest line or ring);
/// a log of any maker (recording/log.h) with latitude and longitude. Told apart by what the file
/// begins with. With a mapping (recording/recording.h) it is a log, and the mapping names the
/// columns of x_m and y_m, in the frame of the mesh, or of latitude_rad and longitude_rad. Throws
/// Error naming the file (and the line of a CSV) when it is none of these, holds fewer than 3
/// positions, or a position that is no place on Earth.
GuideFile read_guide(const std::string& path, const std::string& mapping_path = {});

/// One lap, or a way from a beginning to an end, in the frame of the mesh.
struct Guide {
  std::vector<Eigen::Vector3d> points_m;  ///< no two after each other at one place; z may be NaN
  bool closed = false;                    ///< from the last point on to the first
};

/// A way that comes back to its beginning, in the direction in which it left it, is closed. Of
/// several laps the one whose end lies nearest to its beginning is taken, without the ways to and
/// from it. At least 3 different points, else throws Error.
Guide guide_along(const std::vector<Eigen::Vector3d>& points_m);

}  // namespace road
