// Grip along the road: a second grid of the same shape that holds friction instead of heights.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mesh/ray_surface.h"
#include "road/road_mesh.h"
#include "road/sample.h"

namespace road {

/// Grip relative to dry asphalt. The defaults are usual orders of magnitude for dry surfaces,
/// measured on no track: whoever has measured values should give them.
struct FrictionOptions {
  bool wanted = false;  ///< <name>.friction.crg is written
  double road = 1.0;
  double kerb = 0.9;   ///< painted concrete
  double grass = 0.5;  ///< run-off that no name tells to be something else
  double gravel = 0.45;
  double paint = 0.85;
  double concrete = 0.95;
  std::optional<std::string>
      picture_path;                       ///< painted over the classes, see read_friction_picture()
  std::optional<std::string> zones_path;  ///< and over the picture, see read_friction_zones()
};

/// A rectangle in u and v with one friction. u_begin_m > u_end_m goes over the start of a closed
/// road.
struct FrictionZone {
  double u_begin_m = 0.0, u_end_m = 0.0, v_begin_m = 0.0, v_end_m = 0.0, friction = 1.0;
};

/// CSV with the columns u_begin_m,u_end_m,v_begin_m,v_end_m,friction; later rows lie over earlier
/// ones. Throws Error with file:line on a missing number, v_begin_m > v_end_m, or a friction
/// outside 0 to 3.
std::vector<FrictionZone> read_friction_zones(const std::string& path);

/// Friction painted on a plan of the mesh, in its own frame and metres (the frame of
/// <name>.classes.png).
struct FrictionPicture {
  int width_px = 0, height_px = 0;
  std::vector<std::uint8_t> rgba;
  Eigen::Vector2d first_pixel_m =
      Eigen::Vector2d::Zero();  ///< map place of the middle of the first pixel
  Eigen::Matrix2d pixel_m_px =
      Eigen::Matrix2d::Identity();  ///< step in the map per column and per row

  /// Hundredth of the grey value where the pixel is opaque and grey; nothing for any colour, where
  /// it is transparent, and beside the picture.
  std::optional<double> at(double x_m, double y_m) const;
};

/// A PNG with its world file beside it: the same name with .pgw or .wld. Throws Error.
FrictionPicture read_friction_picture(const std::string& path);

/// What lies over the classes.
struct FrictionPaint {
  std::vector<FrictionZone> zones;
  std::optional<FrictionPicture> picture;
};

/// The files that the options name, read. Throws Error.
FrictionPaint read_friction_paint(const FrictionOptions& options);

struct FrictionReport {
  std::map<std::string, std::size_t>
      nodes;  ///< "road", "kerb", "grass", "gravel", "paint", "concrete", "painted" -> nodes
};

/// The sampled grid with friction in place of heights; NaN where there is no road. What a node is:
/// its class, and words in the object, material and texture names of the triangle below it (paint,
/// line, marking; concrete; gravel, sand; asphalt, tarmac on run-off). Without names the class
/// alone. `paint` lies over that; `line` is in the frame of the mesh.
crg::Grid friction_grid(const SampledGrid& sampled, const RaySurface& surface, const RoadMesh& road,
                        const crg::ReferenceLine& line, const FrictionOptions& options,
                        const FrictionPaint& paint, unsigned threads,
                        FrictionReport* report = nullptr);

/// The file that says where the pixels of a picture of frictions lie: the one that
/// read_friction_picture() takes.
std::optional<std::string> world_file_of(const std::string& picture_path);

}  // namespace road
