// Keeps the drivable surface of a track mesh and tells what every kept triangle is.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/answer.h"
#include "mesh/read_mesh.h"
#include "road/road_mesh.h"

namespace road {

/// One line of the name table: the first rule whose pattern (ECMAScript regex, case-insensitive,
/// searched) matches decides.
struct NameRule {
  enum class Field : std::uint8_t { object, material, texture } field = Field::object;
  std::string pattern;
  SurfaceClass surface_class = SurfaceClass::scenery;
  /// Naming convention that the rule belongs to. Rules with one are used only when it is the
  /// mesh's: the first convention of the table whose road rules match any object. Empty: always
  /// used.
  std::string convention = {};
};

/// Defaults for TORCS (TKMN, TKLS ...), Assetto Corsa (1ROAD, 2KERB, 3GRASS ...) and rFactor names,
/// and plain words (road, asphalt, kerb, curb, grass, gravel, tree, wall, fence ...).
std::vector<NameRule> default_name_rules();

/// For each object the rule that decides, by its place in `rules`; empty where none matches.
std::vector<std::optional<std::size_t>> rules_of(const std::vector<MeshObject>& objects,
                                                 const std::vector<NameRule>& rules);

/// What tells road from scenery. `automatic`: the names, unless geometry alone disagrees with them
/// and finds the more plausible road.
/// `no` leaves out colours too.
enum class UseNames : std::uint8_t { automatic, yes, no };

struct CleanOptions {
  std::vector<NameRule> name_rules = default_name_rules();
  UseNames use_names = UseNames::automatic;
  double weld_tolerance_m = 1e-3;  ///< vertices closer than this become one
  double max_slope_deg = 45.0;     ///< steeper triangles are no road or run-off (kerb faces may be)
  /// Border vertices this near each other in plan become one: cracks of re-exported meshes. They
  /// must agree within 1 mm in height, 5 mm where the export tore every edge apart.
  double snap_tolerance_m = 0.02;
  /// A gap across the whole road up to this long is bridged by new triangles (start/finish seams).
  double max_gap_m = 0.5;
  /// Of several separate roads keep the one nearest to this map point; of strips side by side that
  /// shape alone tells, the one on which it lies.
  std::optional<Eigen::Vector2d> near_m;
  /// What lies along it is the road, whatever it is called and however many pieces it has.
  std::optional<Guide> guide;
  /// Points in the order of driving, each nearest to the road that is meant: the road is what lies
  /// along the shortest way through them over everything that looks like road; closed when the last
  /// is the first. Empty, or at least two.
  std::vector<Eigen::Vector2d> route_m;
  /// Of the road along the guide, where nothing on the surface tells. With near_m: tells the strip
  /// there from all of the ground, where that is a closed road.
  std::optional<double> guide_width_m;
};

struct CleanReport {
  std::size_t triangles_in = 0, triangles_kept = 0;
  std::map<std::string, std::size_t>
      dropped;  ///< reason ("barrier", "scenery", "too steep", "zero area", "duplicate", "not
                ///< connected", ...) -> triangles
  std::map<std::string, std::size_t> kept;  ///< class -> triangles
  std::size_t vertices_welded = 0;
  double weld_tolerance_m = 0.0;
  std::size_t vertices_snapped = 0;  ///< border vertices moved by at most snap_tolerance_m
  double snap_tolerance_m = 0.0;
  std::size_t faces_turned = 0;        ///< kept triangles that pointed down
  std::size_t bridging_triangles = 0;  ///< made to close gaps of at most max_gap_m
  double bridged_m = 0.0;              ///< length of these gaps, all together
  std::size_t holes_closed = 0;        ///< of the mesh, between three or four corners
  double holes_closed_m2 = 0.0;        ///< of them what is road
  std::size_t non_manifold_edges = 0;
  std::size_t boundary_loops = 0;
  std::size_t components = 0;  ///< connected components of the drivable surface before filtering
  bool by_names = false;       ///< false: geometry alone, or a guide
  bool by_colour = false;      ///< names tell nothing, and colours tell more than geometry
  bool by_guide = false;       ///< along a guide or a route
  bool by_place = false;       ///< near_m told which strip of what shape tells
  std::vector<std::string>
      doubts;  ///< what along the guide speaks against the road: for doubts_about()
  /// With names: area that names and geometry both call road over the area that either does, before
  /// anything is dropped as not connected. Empty without names.
  std::optional<double> road_agreement;
  /// Names find an open road, all of it in one, and shape finds none that is longer or closed.
  bool is_all_by_names = false;
  std::vector<SurfaceClass> class_of_triangle;  ///< of every triangle of the mesh that came in
  /// Of these the ones that stand for others: coarser copies and undersides; ascending.
  std::vector<std::uint32_t> left_out;
  std::vector<std::string> remarks;
};

/// "the guide", "names", "colour" or "shape": what told road from scenery.
std::string told_by(const CleanReport& report);

/// How to read a mesh that shall be cleaned: with the colours of its objects where names count and
/// none calls an object road.
MeshReadOptions read_to_clean(MeshReadOptions read, const CleanOptions& options);

/// Drops everything a wheel does not drive on: trees, stands, gantries, barriers, terrain beyond
/// them. By names where the mesh has them; a piece of road under a misleading name (start strip) is
/// kept when it fills a gap of the named road, an underside of a bridge named as road is dropped.
/// By geometry alone otherwise: connected nearly horizontal surface that forms the longest strip.
/// Where no name tells the road and the objects have colours, these may tell it more exactly: what
/// is grey between ground of other colours.
/// A refusal when nothing drivable is left (says what was seen), or when two separate circuits of
/// similar size are present (says where they lie and how to choose: `near_m`).
/// A refusal when a guide and a route are given, or a width without either and without near_m.
/// Along a guide or route: one for NotUsable where more than 30 % of it have no surface.
base::Answer<RoadMesh> try_clean(const Mesh& mesh, const CleanOptions& options = {},
                                 CleanReport* report = nullptr);

/// The same for those who have no other road to take: throws the refusal as Error.
RoadMesh clean(const Mesh& mesh, const CleanOptions& options = {}, CleanReport* report = nullptr);

}  // namespace road
