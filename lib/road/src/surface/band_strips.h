// Strips as wide as a road, made of bands, and which of them may be the road. Private to
// classify_by_shape.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "bands.h"

namespace road {

inline constexpr double kWidestRoad_m = 45.0;
// Of strips this nearly as long as the longest the widest is the road; the others run beside it.
inline constexpr double kAsLong = 0.85;

/// Triangles of a road to be; area and border give length and width as of a long strip.
struct Strip {
  std::vector<std::uint32_t> triangles;  ///< ascending
  std::vector<std::size_t> chains;       ///< that its bands lie beside
  std::size_t rings = 0;
  double area_m2 = 0.0, border_m = 0.0;
  double length_m() const { return border_m / 2.0; }
  double width_m() const { return border_m > 0.0 ? 2.0 * area_m2 / border_m : 0.0; }
};

/// Columns that lie in one plane across the strip: those as wide as each other belong together; of
/// others nothing tells whether they do.
enum class Columns : std::uint8_t { as_wide, any };

/// A road is a band, what lies between the same two chains, and further columns. Of the bands that
/// `admits` names, all strips that are as wide as a road.
std::vector<Strip> strips_of_bands(const FlatSurface& flat, const Fans& fans,
                                   const std::vector<Chain>& chains, const std::vector<Band>& bands,
                                   const std::function<bool(std::size_t)>& admits, Columns columns);

/// Of bands as wide all along, of bands whose width changes smoothly, and of those with all columns
/// in one plane.
struct Strips {
  std::vector<Strip> steady, smooth, joined;
};

Strips strips_of(const FlatSurface& flat, const Fans& fans, const std::vector<Chain>& chains,
                 double shortest_m = kShortestChain_m);

/// All, of those that are alike the first one.
std::vector<Strip> all_strips(Strips strips);

/// Share of a strip's length along which it lies beside the road.
double beside_road(const FlatSurface& flat, const Fans& fans, const std::vector<char>& road,
                   const Strip& strip);

/// Share of a strip's triangles with a corner within `reach_m` of the road, in plan.
double close_to_road(const FlatSurface& flat, const std::vector<char>& road, const Strip& strip,
                     double reach_m);

/// Width of the only strip beside the road that may be the road itself, or its other half; 0 where
/// none may.
double rival_width_m(const FlatSurface& flat, const Fans& fans, const std::vector<Chain>& chains,
                     const std::vector<Strip>& strips, const Strip& chosen);

/// The roads of two halves that lie edge to edge: each is the only one beside the other that is as
/// wide and as even, and has something else on its far side.
std::vector<Strip> roads_of_halves(const FlatSurface& flat, const Fans& fans,
                                   const std::vector<Chain>& chains,
                                   const std::vector<Strip>& strips);

/// How rough the heights along the most uneven chain of a strip are from ring to ring, in the
/// median.
double unevenness_m(const FlatSurface& flat, const std::vector<Chain>& chains, const Strip& strip);

/// Whether a strip bends much more than the evenest one.
bool is_uneven(double unevenness_m, double evenest_m);

/// Whether ground lies along most of both sides.
bool has_ground_beside(const FlatSurface& flat, const Fans& fans, const Strip& strip);

/// What the strip is with all columns that lie in one plane with it, where nothing but their widths
/// tells where it ends: they are as even as it is.
const Strip* wider_strip(const FlatSurface& flat, const std::vector<Chain>& chains,
                         const std::vector<Strip>& joined, const Strip& strip);

/// As wide as circuits are: a road without others beside it.
bool is_whole_road(const Strip& strip);

}  // namespace road
