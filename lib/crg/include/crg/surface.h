// Queries of a road: immutable Surface shared by all threads, one Cursor per wheel.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "crg/file.h"
#include "crg/options.h"
#include "crg/strip.h"

namespace crg {

/// Everything a query answers. u, v, x, y are numbers for every finite query; where there is no
/// road (a hole, or beyond a border of mode none), valid is false and z, gradient and normal are
/// NaN.
struct Sample {
  static constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  bool valid = false;
  bool inside = false;  ///< u and v lie within the grid, border modes not needed
  double u_m = kNaN, v_m = kNaN;
  double x_m = kNaN, y_m = kNaN, z_m = kNaN;
  double dzdx = kNaN, dzdy = kNaN;  ///< gradient in map axes
  double heading_rad =
      kNaN;  ///< of the reference line segment, CCW from +x; whole turns as in the file
  double curvature_1pm = kNaN;  ///< of the line through the point, left turn positive
  double normal_x = kNaN, normal_y = kNaN, normal_z = kNaN;  ///< upward unit normal
  double friction = kNaN;  ///< from the friction map, else the constant of the options
};

/// What a wheel asks: of a Sample its height, slope, place and grip.
struct Ground {
  bool valid = false, inside = false;
  double u_m = Sample::kNaN, v_m = Sample::kNaN;
  double z_m = Sample::kNaN, dzdx = Sample::kNaN, dzdy = Sample::kNaN;
  double friction = Sample::kNaN;

  Ground() = default;
  explicit Ground(const Sample& s)
      : valid(s.valid),
        inside(s.inside),
        u_m(s.u_m),
        v_m(s.v_m),
        z_m(s.z_m),
        dzdx(s.dzdx),
        dzdy(s.dzdy),
        friction(s.friction) {}
};

/// Of four points, number by number.
struct FourGrounds {
  std::array<double, 4> u_m, v_m, z_m, dzdx, dzdy;
  double friction;
};

/// Where the last query was found; only speeds up the next one, never changes its answer.
struct alignas(16) Cursor {
  // Number of a segment and the fraction within it, and 1.5 * 2^33 more.
  double last = 0.0;             ///< there the last query was
  double ahead = 12884901887.5;  ///< there the next is expected; at first before the road
};

struct UV {
  double u_m = std::numeric_limits<double>::quiet_NaN();
  double v_m = std::numeric_limits<double>::quiet_NaN();
};

/// Of the line through a point: as in Sample, which says more.
struct Heading {
  double heading_rad = std::numeric_limits<double>::quiet_NaN();
  double curvature_1pm = std::numeric_limits<double>::quiet_NaN();
};

/// What to do with the modifiers of a file.
enum class ModifierUse {
  AsInFile,           ///< apply those in the file; none where it has no section
  None,               ///< apply nothing
  ReferenceDefaults,  ///< as in the file, and where it has no section what the reference API does
};

/// How heights between the nodes of the grid are found.
enum class Interpolation {
  Bilinear,  ///< the standard: continuous, with kinks at the rows and columns
  Smooth     ///< continuous first derivatives along u and v; the same at the nodes
};

struct SurfaceOptions {
  ModifierUse modifiers = ModifierUse::AsInFile;
  Interpolation interpolation = Interpolation::Bilinear;
  /// Curvature of the reference line itself in place of the line at v through the point.
  bool curvature_of_reference_line = false;
  double friction = 1.0;  ///< grip where there is no friction map, or a hole in it
  /// A second file of the same shape whose "heights" are friction coefficients. Its own header is
  /// not used: the road says where the values lie.
  std::optional<Crg> friction_map = {};
};

class Surface {
 public:
  /// Applies modifiers and options of the file. Throws Error when the file cannot be evaluated.
  explicit Surface(Crg crg, SurfaceOptions options = {});
  ~Surface();
  Surface(Surface&&) noexcept;
  Surface& operator=(Surface&&) noexcept;

  /// z at (u, v); NaN outside the road or on a hole.
  double z_at_uv(double u_m, double v_m) const noexcept;
  /// Beyond the ends the road goes straight on (or closes, where the file says so).
  Point2 xy_of_uv(double u_m, double v_m) const noexcept;
  /// The (u, v) of a map point: where it lies on the grid of several legs, or on none, the leg
  /// nearest to it. NaN only for points that are not finite.
  UV uv_of_xy(double x_m, double y_m, Cursor& cursor) const noexcept;
  /// z alone; the fastest query.
  double z_at_xy(double x_m, double y_m, Cursor& cursor) const noexcept;
  Sample at_xy(double x_m, double y_m, Cursor& cursor) const noexcept;
  /// Of at_xy() what Ground has, in less time.
  Ground ground_at_xy(double x_m, double y_m, Cursor& cursor) const noexcept;
  /// The usual case of four points at once, where the processor has AVX2: all are where their
  /// cursors lead, on the grid and valid. Else false, and nothing is changed: ask one by one.
  bool ground_of_four(const std::array<Point2, 4>& points, const std::array<Cursor*, 4>& cursors,
                      FourGrounds& out) const noexcept;
  Sample at_uv(double u_m, double v_m) const noexcept;
  /// heading_rad and curvature_1pm of at_uv() alone.
  Heading heading_at_uv(double u_m, double v_m) const noexcept;

  /// Many points with one cursor, in the order of a path: out[k] belongs to points[k]. Looks at as
  /// many as the shorter of the two holds.
  void at_xy(std::span<const Point2> points, std::span<Sample> out, Cursor& cursor) const noexcept;
  void z_at_xy(std::span<const Point2> points, std::span<double> z_m,
               Cursor& cursor) const noexcept;
  /// The same where x and y lie in arrays of their own.
  void at_xy(std::span<const double> x_m, std::span<const double> y_m, std::span<Sample> out,
             Cursor& cursor) const noexcept;
  void z_at_xy(std::span<const double> x_m, std::span<const double> y_m, std::span<double> z_m,
               Cursor& cursor) const noexcept;
  /// Points that each have their own cursor: the wheels of a car, one call per step. z_m[k] belongs
  /// to points[k] and cursors[k]; looks at as many as the shortest span holds. The answers are
  /// those of z_at_xy() one by one, about 1.5 times as fast where the processor has AVX2.
  void z_at_xy(std::span<const Point2> points, std::span<Cursor> cursors,
               std::span<double> z_m) const noexcept;

  /// The heights of a strip, relative to the height that is returned: that of the reference line
  /// beside the middle of the strip. dz_m[i * across + j] is sample j across of row i along; NaN
  /// where there is no road. Fills as much as dz_m holds. Within 1e-5 m of at_xy() on roads whose
  /// rows are 0.1 m apart or nearer (docs/evidence.md).
  double strip(const Strip& strip, std::span<float> dz_m, Cursor& cursor) const noexcept;
  /// The same for who can do without rows far from the middle: those in `first` are filled, then
  /// those that `more` asks for; others may keep what they hold. `first` lies within the strip,
  /// dz_m holds all of it, `more` does not throw.
  double strip(const Strip& strip, StripRows first, const MoreRows& more, std::span<float> dz_m,
               Cursor& cursor) const noexcept;

  const Grid& grid() const noexcept;  ///< after modifiers
  /// The last row leads to the first: the file asks for it, and the ends meet.
  bool closed() const noexcept;
  /// File and line after modifiers. Made at the first call, from any thread, and kept: 24 and 40
  /// bytes a row more. Whoever wants grid or closed alone asks for those.
  const Crg& file() const;
  const ReferenceLine& reference_line() const;

 private:
  struct Data;
  std::unique_ptr<const Data> data_;
};

}  // namespace crg
