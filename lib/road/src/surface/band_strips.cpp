#include "band_strips.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "base/statistics.h"
#include "road/clean.h"

namespace road {
namespace {

constexpr double kNarrowestRoad_m = 4.5;

constexpr double kFlatFold = 1.5 * std::numbers::pi / 180.0;

// Two chains bound the same band when this share of the triangles beside one lies beside the other.
constexpr double kCommonShare = 0.8;

// A strip beside the road may be the road itself when it is this wide (of the road taken; many a
// verge is half as wide as its road), or when it is less wide and lies between two wider ones, or
// beside something wider than most roads are.
constexpr double kAlikeWidth = 0.55, kRivalShare = 0.3, kUsuallyNarrower_m = 20.0;

constexpr double kBesideShare = 0.5;

// The halves of a road differ by this share of their width at most.
constexpr double kSameHalf = 0.1;

// Uneven is what bends this many times as much as the evenest strip, and this much more.
constexpr double kUneven = 4.0, kUneven_m = 0.005;
// Columns beside a strip that lie in one plane with it make it this much wider, at least.
constexpr double kClearlyWider = 1.1;
// Circuits are this wide or wider.
constexpr double kUsualRoad_m = 9.0;
// Of the border of a strip: a strip at the rim of the ground has at most half.
constexpr double kBothSides = 0.75;

void measure(const FlatSurface& flat, const Fans& fans, Strip& strip) {
  for (const std::uint32_t t : strip.triangles) {
    const Triangle& v = flat.triangles[t];
    const Eigen::Vector3d& a = flat.vertices_m[v[0]];
    strip.area_m2 += 0.5 * (flat.vertices_m[v[1]] - a).cross(flat.vertices_m[v[2]] - a).norm();
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t across = fans.left(v[(c + 1) % 3], v[c]);
      if (across != kNoIndex &&
          std::binary_search(strip.triangles.begin(), strip.triangles.end(), across))
        continue;
      strip.border_m += (flat.vertices_m[v[(c + 1) % 3]] - flat.vertices_m[v[c]]).norm();
    }
  }
}

/// Adds triangles that have two sides in common with the strip: chains that break off leave such
/// gaps between columns.
void fill_notches(const FlatSurface& flat, const Fans& fans,
                  std::vector<std::uint32_t>& triangles) {
  std::vector<char> in(flat.triangles.size(), 0);
  for (const std::uint32_t t : triangles) in[t] = 1;
  std::vector<std::uint32_t> newest = triangles;
  while (!newest.empty()) {
    std::vector<std::uint32_t> added;
    for (const std::uint32_t t : newest) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t near = fans.left(flat.triangles[t][(c + 1) % 3], flat.triangles[t][c]);
        if (near == kNoIndex || in[near]) continue;
        int sides = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::uint32_t across =
              fans.left(flat.triangles[near][(k + 1) % 3], flat.triangles[near][k]);
          sides += across != kNoIndex && in[across] ? 1 : 0;
        }
        if (sides < 2) continue;
        in[near] = 1;
        added.push_back(near);
      }
    }
    triangles.insert(triangles.end(), added.begin(), added.end());
    newest = std::move(added);
  }
  std::sort(triangles.begin(), triangles.end());
}

std::vector<char> marked(const FlatSurface& flat, const Strip& strip) {
  std::vector<char> mark(flat.triangles.size(), 0);
  for (const std::uint32_t t : strip.triangles) mark[t] = 1;
  return mark;
}

/// Of every triangle the bands that hold it, ascending, in one list.
class BandsOfTriangles {
 public:
  BandsOfTriangles(std::size_t triangles, const std::vector<Band>& bands,
                   const std::function<bool(std::size_t)>& admits)
      : first_(triangles + 1, 0) {
    std::vector<std::uint32_t> last(triangles, kNoIndex);  // a band may name a triangle twice
    const auto each = [&](const auto& use) {
      std::fill(last.begin(), last.end(), kNoIndex);
      for (std::uint32_t b = 0; b < bands.size(); ++b) {
        if (!admits(b)) continue;
        for (const std::uint32_t t : bands[b].triangles)
          if (std::exchange(last[t], b) != b) use(t, b);
      }
    };
    each([&](std::uint32_t t, std::uint32_t) { ++first_[t + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    bands_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    each([&](std::uint32_t t, std::uint32_t b) { bands_[next[t]++] = b; });
  }
  std::span<const std::uint32_t> operator[](std::uint32_t t) const {
    return std::span(bands_).subspan(first_[t], first_[t + 1] - first_[t]);
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> bands_;
};

/// The strips that run beside one, as long as it.
std::vector<const Strip*> neighbours(const FlatSurface& flat, const Fans& fans,
                                     const std::vector<Strip>& strips, const Strip& of) {
  const std::vector<char> mark = marked(flat, of);
  std::vector<const Strip*> beside;
  for (const Strip& strip : strips)
    if (&strip != &of && strip.length_m() >= kAsLong * of.length_m() &&
        beside_road(flat, fans, mark, strip) >= kBesideShare)
      beside.push_back(&strip);
  return beside;
}

/// How rough its heights are from ring to ring, in the median: by third differences, as banks and
/// crests are smooth over four rings. As large as second differences of noise.
double unevenness_m(const FlatSurface& flat, const Chain& chain) {
  constexpr double kOfNoise = 1.8;  // third over second differences, root of 20 / 6
  std::vector<double> bends_m;
  const auto z_m = [&](std::size_t i) { return flat.vertices_m[chain.at(i)].z(); };
  for (std::size_t i = 0; i + 2 < chain.edges(); ++i)
    bends_m.push_back(std::abs(z_m(i + 3) - z_m(i) - 3.0 * (z_m(i + 2) - z_m(i + 1))) / kOfNoise);
  return base::median_or(0.0, std::move(bends_m));
}

/// Of two strips beside one the only one that is as wide and even: one half of a road lies between
/// the other and its verge.
const Strip* other_half(const FlatSurface& flat, const std::vector<Chain>& chains,
                        std::vector<const Strip*> beside, const Strip& of) {
  if (beside.size() != 2) return nullptr;
  std::erase_if(beside, [&](const Strip* strip) {
    return std::abs(strip->width_m() - of.width_m()) > kSameHalf * of.width_m() ||
           is_uneven(unevenness_m(flat, chains, *strip), unevenness_m(flat, chains, of));
  });
  return beside.size() == 1 ? beside.front() : nullptr;
}

}  // namespace

std::vector<Strip> strips_of_bands(const FlatSurface& flat, const Fans& fans,
                                   const std::vector<Chain>& chains, const std::vector<Band>& bands,
                                   const std::function<bool(std::size_t)>& admits,
                                   Columns columns) {
  const BandsOfTriangles bands_of(flat.triangles.size(), bands, admits);
  std::vector<int> fold_known(chains.size(), -1);
  const auto flat_across = [&](std::size_t chain) {
    if (fold_known[chain] < 0)
      fold_known[chain] =
          fold_along(flat, fans, chains[chain]) < kFlatFold || is_crest(flat, fans, chains[chain])
              ? 1
              : 0;
    return fold_known[chain] == 1;
  };

  const auto same_bands = [&](std::uint32_t b) {
    std::map<std::uint32_t, std::size_t> common;
    for (const std::uint32_t t : bands[b].triangles)
      for (const std::uint32_t other : bands_of[t]) ++common[other];
    std::erase_if(common, [&](const auto& of) {
      return static_cast<double>(of.second) <
             kCommonShare * static_cast<double>(std::min(bands[b].triangles.size(),
                                                         bands[of.first].triangles.size()));
    });
    return common;
  };
  // Rough ground may begin level with the road: its far side is uneven.
  const auto goes_on_even = [&](std::uint32_t b) {
    const double even_m = unevenness_m(flat, chains[bands[b].chain]);
    const auto far = same_bands(b);
    return std::none_of(far.begin(), far.end(), [&](const auto& of) {
      return is_uneven(unevenness_m(flat, chains[bands[of.first].chain]), even_m);
    });
  };

  std::vector<char> grouped(bands.size(), 0);
  std::vector<std::uint32_t> strip_of(flat.triangles.size(), kNoIndex);  // named by its first band
  std::vector<Strip> strips;
  for (std::uint32_t first = 0; first < bands.size(); ++first) {
    if (grouped[first] || !admits(first)) continue;
    Strip strip;
    std::vector<std::uint32_t> open{first};
    grouped[first] = 1;
    while (!open.empty()) {
      const std::uint32_t b = open.back();
      open.pop_back();
      strip.chains.push_back(bands[b].chain);
      strip.rings = std::max(strip.rings, bands[b].rings);
      for (const std::uint32_t t : bands[b].triangles)
        if (std::exchange(strip_of[t], first) != first) strip.triangles.push_back(t);
      const std::uint32_t across = b ^ 1u;
      if (!grouped[across] && admits(across) &&
          (columns == Columns::any || as_wide(bands[b], bands[across])) &&
          flat_across(bands[b].chain) && goes_on_even(b) && goes_on_even(across)) {
        grouped[across] = 1;
        open.push_back(across);
      }
      for (const auto& [other, count] : same_bands(b)) {
        if (grouped[other]) continue;
        grouped[other] = 1;
        open.push_back(other);
      }
    }
    std::sort(strip.triangles.begin(), strip.triangles.end());
    fill_notches(flat, fans, strip.triangles);
    measure(flat, fans, strip);
    if (strip.width_m() >= kNarrowestRoad_m && strip.width_m() <= kWidestRoad_m)
      strips.push_back(std::move(strip));
  }
  return strips;
}

Strips strips_of(const FlatSurface& flat, const Fans& fans, const std::vector<Chain>& chains,
                 double shortest_m) {
  std::vector<Band> bands;  // two for every chain: left, right
  for (std::size_t i = 0; i < chains.size(); ++i) {
    bands.push_back(band_beside(flat, fans, chains, i, true));
    bands.push_back(band_beside(flat, fans, chains, i, false));
  }
  const auto long_enough = [&](std::size_t b) {
    return bands[b].length_m >= shortest_m && bands[b].width_m <= kWidestRoad_m;
  };
  const auto steady = [&](std::size_t b) {
    return long_enough(b) && bands[b].steady >= kSteadyShare;
  };
  const auto smooth = [&](std::size_t b) {
    return long_enough(b) && bands[b].smooth >= kSteadyShare;
  };
  return {strips_of_bands(flat, fans, chains, bands, steady, Columns::as_wide),
          strips_of_bands(flat, fans, chains, bands, smooth, Columns::as_wide),
          strips_of_bands(flat, fans, chains, bands, smooth, Columns::any)};
}

std::vector<Strip> all_strips(Strips strips) {
  std::vector<Strip> all = std::move(strips.steady);
  std::vector<Strip> others = std::move(strips.smooth);
  others.insert(others.end(), strips.joined.begin(), strips.joined.end());
  for (Strip& strip : others) {
    const bool known = std::any_of(all.begin(), all.end(), [&](const Strip& other) {
      std::vector<std::uint32_t> common;
      std::set_intersection(strip.triangles.begin(), strip.triangles.end(), other.triangles.begin(),
                            other.triangles.end(), std::back_inserter(common));
      return 2 * common.size() > strip.triangles.size();
    });
    if (!known) all.push_back(std::move(strip));
  }
  return all;
}

double beside_road(const FlatSurface& flat, const Fans& fans, const std::vector<char>& road,
                   const Strip& strip) {
  double beside_m = 0.0;
  for (const std::uint32_t t : strip.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t p = flat.triangles[t][c], q = flat.triangles[t][(c + 1) % 3];
      const std::uint32_t across = fans.left(q, p);
      if (across == kNoIndex || !road[across] || road[t]) continue;
      beside_m += (flat.vertices_m[q] - flat.vertices_m[p]).norm();
    }
  }
  return beside_m / strip.length_m();
}

double close_to_road(const FlatSurface& flat, const std::vector<char>& road, const Strip& strip,
                     double reach_m) {
  using Cell = std::pair<std::int64_t, std::int64_t>;
  const auto cell_of = [&](const Eigen::Vector2d& p) {
    return Cell(static_cast<std::int64_t>(std::floor(p.x() / reach_m)),
                static_cast<std::int64_t>(std::floor(p.y() / reach_m)));
  };
  std::multimap<Cell, Eigen::Vector2d> places;  // along the road's edges, twice in `reach_m`
  for (std::size_t t = 0; t < road.size(); ++t)
    for (std::size_t c = 0; road[t] && c < 3; ++c) {
      const Eigen::Vector2d p = flat.vertices_m[flat.triangles[t][c]].head<2>(),
                            q = flat.vertices_m[flat.triangles[t][(c + 1) % 3]].head<2>();
      const double steps = std::ceil(2.0 * (q - p).norm() / reach_m);
      for (double i = 0.0; i < std::min(steps, 1000.0); ++i) {
        const Eigen::Vector2d at = p + i / steps * (q - p);
        places.emplace(cell_of(at), at);
      }
    }
  const auto is_close = [&](const Eigen::Vector2d& p) {
    const Cell own = cell_of(p);
    for (std::int64_t x = own.first - 1; x <= own.first + 1; ++x)
      for (std::int64_t y = own.second - 1; y <= own.second + 1; ++y)
        for (auto [i, end] = places.equal_range({x, y}); i != end; ++i)
          if ((i->second - p).norm() < reach_m) return true;
    return false;
  };
  std::size_t close = 0;
  for (const std::uint32_t t : strip.triangles)
    close += std::any_of(flat.triangles[t].begin(), flat.triangles[t].end(),
                         [&](std::uint32_t v) { return is_close(flat.vertices_m[v].head<2>()); })
                 ? 1u
                 : 0u;
  return static_cast<double>(close) / static_cast<double>(strip.triangles.size());
}

double rival_width_m(const FlatSurface& flat, const Fans& fans, const std::vector<Chain>& chains,
                     const std::vector<Strip>& strips, const Strip& chosen) {
  const std::vector<const Strip*> beside = neighbours(flat, fans, strips, chosen);
  if (const Strip* half = other_half(flat, chains, beside, chosen)) return half->width_m();
  if (beside.size() != 1) return 0.0;
  const Strip& rival = *beside.front();
  if (rival.width_m() >= kAlikeWidth * chosen.width_m()) return rival.width_m();
  if (rival.width_m() < kRivalShare * chosen.width_m()) return 0.0;
  const std::vector<const Strip*> around = neighbours(flat, fans, strips, rival);
  const bool between =
      around.size() == 2 && std::all_of(around.begin(), around.end(), [&](const Strip* strip) {
        return strip->width_m() > rival.width_m();
      });
  return between || chosen.width_m() > kUsuallyNarrower_m ? rival.width_m() : 0.0;
}

std::vector<Strip> roads_of_halves(const FlatSurface& flat, const Fans& fans,
                                   const std::vector<Chain>& chains,
                                   const std::vector<Strip>& strips) {
  std::vector<const Strip*> half_of;
  for (const Strip& strip : strips)
    half_of.push_back(other_half(flat, chains, neighbours(flat, fans, strips, strip), strip));
  std::vector<Strip> roads;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    if (half_of[i] == nullptr || half_of[i] < &strips[i] ||
        half_of[static_cast<std::size_t>(half_of[i] - strips.data())] != &strips[i])
      continue;
    Strip road{{}, strips[i].chains, std::max(strips[i].rings, half_of[i]->rings)};
    std::set_union(strips[i].triangles.begin(), strips[i].triangles.end(),
                   half_of[i]->triangles.begin(), half_of[i]->triangles.end(),
                   std::back_inserter(road.triangles));
    road.chains.insert(road.chains.end(), half_of[i]->chains.begin(), half_of[i]->chains.end());
    measure(flat, fans, road);
    roads.push_back(std::move(road));
  }
  return roads;
}

double unevenness_m(const FlatSurface& flat, const std::vector<Chain>& chains, const Strip& strip) {
  double most_m = 0.0;
  for (const std::size_t c : strip.chains) most_m = std::max(most_m, unevenness_m(flat, chains[c]));
  return most_m;
}

bool is_uneven(double unevenness_m, double evenest_m) {
  return unevenness_m > kUneven_m + kUneven * evenest_m;
}

bool has_ground_beside(const FlatSurface& flat, const Fans& fans, const Strip& strip) {
  double beside_m = 0.0;
  for (const std::uint32_t t : strip.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t p = flat.triangles[t][c], q = flat.triangles[t][(c + 1) % 3];
      const std::uint32_t across = fans.left(q, p);
      if (across != kNoIndex &&
          !std::binary_search(strip.triangles.begin(), strip.triangles.end(), across))
        beside_m += (flat.vertices_m[q] - flat.vertices_m[p]).norm();
    }
  return beside_m > kBothSides * strip.border_m;
}

const Strip* wider_strip(const FlatSurface& flat, const std::vector<Chain>& chains,
                         const std::vector<Strip>& joined, const Strip& strip) {
  const auto holds = [&](const Strip& wider) {
    return wider.width_m() > kClearlyWider * strip.width_m() &&
           wider.length_m() > kAsLong * strip.length_m() &&
           std::includes(wider.triangles.begin(), wider.triangles.end(), strip.triangles.begin(),
                         strip.triangles.end()) &&
           !is_uneven(unevenness_m(flat, chains, wider), unevenness_m(flat, chains, strip));
  };
  const auto found = std::find_if(joined.begin(), joined.end(), holds);
  return found == joined.end() ? nullptr : &*found;
}

bool is_whole_road(const Strip& strip) { return strip.width_m() >= kUsualRoad_m; }

}  // namespace road
