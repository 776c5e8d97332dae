#include "road/kerb.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/parallel.h"

namespace road {

namespace {

constexpr double kEdgeBin_m = 0.01;    // kerb edges this close together share their columns
constexpr double kHalfFace_m = 0.005;  // a vertical face is carried by two columns this far from it
constexpr double kSmallestColumn_m = 0.004;
constexpr double kShortestEdge_m = 5.0;  // of kerb edge that is worth columns of its own
constexpr std::size_t kRowsPerChunk = 64;
constexpr double kJoinAlong_m = 1.0;  // kerbs closer than this along u are one

bool is_kerb(const SampledGrid& s, std::size_t node) {
  return s.provenance[node] != Provenance::none && s.surface_class[node] == SurfaceClass::kerb;
}

/// One row's stretch of kerb nodes [first, last].
struct Stretch {
  std::size_t first, last;
};

std::vector<Stretch> stretches(const SampledGrid& s, std::size_t row) {
  std::vector<Stretch> result;
  const std::size_t columns = s.grid.columns();
  for (std::size_t j = 0; j < columns; ++j) {
    if (!is_kerb(s, row * columns + j)) continue;
    const std::size_t first = j;
    while (j + 1 < columns && is_kerb(s, row * columns + j + 1)) ++j;
    result.push_back({first, j});
  }
  return result;
}

/// Largest rise of the stretch above the road beside it, continued with its cross slope.
double rise_m(const SampledGrid& s, std::size_t row, const Stretch& k) {
  const std::size_t columns = s.grid.columns();
  const auto& v = s.grid.v_m;
  // The road lies towards the line.
  const bool right = v[k.first] + v[k.last] < 0.0;
  const std::ptrdiff_t inward = right ? 1 : -1;
  const std::size_t inner = right ? k.last : k.first;
  const auto road_node = [&](double distance_m) -> std::ptrdiff_t {
    auto j = static_cast<std::ptrdiff_t>(inner) + inward;
    while (j >= 0 && j < static_cast<std::ptrdiff_t>(columns) &&
           std::abs(v[static_cast<std::size_t>(j)] - v[inner]) < distance_m) {
      j += inward;
    }
    if (j < 0 || j >= static_cast<std::ptrdiff_t>(columns)) return -1;
    return std::isnan(s.grid.at(row, static_cast<std::size_t>(j))) ? -1 : j;
  };
  const std::ptrdiff_t a = road_node(0.0), b = road_node(1.0);
  if (a < 0) return 0.0;
  const double va = v[static_cast<std::size_t>(a)],
               za = static_cast<double>(s.grid.at(row, static_cast<std::size_t>(a)));
  double slope = 0.0;
  if (b >= 0 && b != a) {
    slope = (static_cast<double>(s.grid.at(row, static_cast<std::size_t>(b))) - za) /
            (v[static_cast<std::size_t>(b)] - va);
  }
  double largest = 0.0;
  for (std::size_t j = k.first; j <= k.last; ++j) {
    largest =
        std::max(largest, static_cast<double>(s.grid.at(row, j)) - (za + slope * (v[j] - va)));
  }
  return largest;
}

std::vector<Kerb> find_kerbs(const SampledGrid& s) {
  struct Open {
    Kerb kerb;
    std::size_t last_row;
  };
  std::vector<Kerb> done;
  std::vector<Open> open;
  const std::size_t rows = s.grid.rows();
  const auto join = static_cast<std::size_t>(std::ceil(kJoinAlong_m / s.grid.u_step_m));
  for (std::size_t i = 0; i < rows; ++i) {
    for (const Stretch& k : stretches(s, i)) {
      const double v0 = s.grid.v_m[k.first], v1 = s.grid.v_m[k.last], u = s.grid.u_of(i);
      const auto fits = std::find_if(open.begin(), open.end(), [&](const Open& o) {
        return v0 <= o.kerb.v_end_m + 0.2 && v1 >= o.kerb.v_begin_m - 0.2;
      });
      if (fits == open.end()) {
        open.push_back({{u, u, v0, v1, rise_m(s, i, k), u}, i});
      } else {
        fits->kerb.u_end_m = u;
        fits->kerb.v_begin_m = std::min(fits->kerb.v_begin_m, v0);
        fits->kerb.v_end_m = std::max(fits->kerb.v_end_m, v1);
        if (const double rise = rise_m(s, i, k); rise > fits->kerb.height_m)
          fits->kerb.height_m = rise, fits->kerb.u_highest_m = u;
        fits->last_row = i;
      }
    }
    std::erase_if(open, [&](const Open& o) {
      const bool ended = i - o.last_row > join;
      if (ended) done.push_back(o.kerb);
      return ended;
    });
  }
  for (const Open& o : open) done.push_back(o.kerb);
  std::erase_if(done,
                [&](const Kerb& k) { return k.u_end_m - k.u_begin_m < 2.0 * s.grid.u_step_m; });
  std::sort(done.begin(), done.end(), [](const Kerb& a, const Kerb& b) {
    return std::tie(a.u_begin_m, a.v_begin_m) < std::tie(b.u_begin_m, b.v_begin_m);
  });
  return done;
}

struct Node {
  float z_m;
  SurfaceClass surface_class;
};

/// The surface at (row, v) between two known neighbours of the row; nothing where it is not between
/// them.
std::optional<Node> probe(const SampledGrid& s, const RaySurface& surface, const RoadMesh& road,
                          const crg::ReferenceLine& line, std::size_t row, double v_m,
                          const std::vector<KerbZone>& zones) {
  const auto& v = s.grid.v_m;
  const auto right =
      static_cast<std::size_t>(std::upper_bound(v.begin(), v.end(), v_m) - v.begin());
  if (right == 0 || right == v.size()) return std::nullopt;
  const auto z0 = static_cast<double>(s.grid.at(row, right - 1)),
             z1 = static_cast<double>(s.grid.at(row, right));
  if (std::isnan(z0) || std::isnan(z1)) return std::nullopt;
  const double t = (v_m - v[right - 1]) / (v[right] - v[right - 1]);
  const crg::Point2 p = crg::node_position(line, row, v_m);
  const auto hit = surface.nearest_hit(p.x_m, p.y_m, z0 + t * (z1 - z0), 0.3 + std::abs(z1 - z0));
  if (!hit) return std::nullopt;
  return Node{static_cast<float>(hit->z_m),
              zoned(road.class_of_triangle[hit->triangle], s.grid.u_of(row), v_m, zones)};
}

/// probe for up to 16 rows from `first` at once.
std::array<std::optional<Node>, 16> probe_rows(const SampledGrid& s, const RaySurface& surface,
                                               const RoadMesh& road, const crg::ReferenceLine& line,
                                               std::size_t first, std::size_t count, double v_m,
                                               const std::vector<KerbZone>& zones) {
  constexpr double kReach_m = 0.3;
  const auto& v = s.grid.v_m;
  const auto right =
      static_cast<std::size_t>(std::upper_bound(v.begin(), v.end(), v_m) - v.begin());
  RayPacket16 packet{};
  packet.max_depth_m = static_cast<float>(2.0 * kReach_m);
  std::array<double, 16> low_m{}, high_m{};
  for (std::size_t k = 0; k < count; ++k) {
    const auto z0 = static_cast<double>(s.grid.at(first + k, right - 1)),
               z1 = static_cast<double>(s.grid.at(first + k, right));
    if (std::isnan(z0) || std::isnan(z1)) continue;
    low_m[k] = std::min(z0, z1);
    high_m[k] = std::max(z0, z1);
    const crg::Point2 p = crg::node_position(line, first + k, v_m);
    packet.x_m[k] = static_cast<float>(p.x_m - surface.origin_m().x());
    packet.y_m[k] = static_cast<float>(p.y_m - surface.origin_m().y());
    packet.z_top_m[k] = static_cast<float>(0.5 * (z0 + z1) + kReach_m - surface.origin_m().z());
    packet.active[k] = -1;
  }
  surface.cast_down(packet);
  std::array<std::optional<Node>, 16> nodes;
  for (std::size_t k = 0; k < count; ++k) {
    if (packet.active[k] == 0) continue;
    const double z_m = static_cast<double>(packet.z_m[k]) + surface.origin_m().z();
    // A hit between its neighbours is the surface; anything else is looked at more closely.
    if (z_m >= low_m[k] - 0.02 && z_m <= high_m[k] + 0.02) {
      nodes[k] = Node{static_cast<float>(z_m), zoned(road.class_of_triangle[packet.triangle[k]],
                                                     s.grid.u_of(first + k), v_m, zones)};
    } else {
      nodes[k] = probe(s, surface, road, line, first + k, v_m, zones);
    }
  }
  return nodes;
}

/// v where the surface changes between kerb and not kerb inside (v[j], v[j + 1]), to 1 mm.
std::optional<double> edge_between(const SampledGrid& s, const RaySurface& surface,
                                   const RoadMesh& road, const crg::ReferenceLine& line,
                                   std::size_t row, std::size_t j,
                                   const std::vector<KerbZone>& zones) {
  const std::size_t node = row * s.grid.columns() + j;
  const bool kerb_first = is_kerb(s, node);
  double lo = s.grid.v_m[j], hi = s.grid.v_m[j + 1];
  while (hi - lo > 1e-3) {
    const double middle = 0.5 * (lo + hi);
    const auto found = probe(s, surface, road, line, row, middle, zones);
    if (!found) return std::nullopt;
    ((found->surface_class == SurfaceClass::kerb) == kerb_first ? lo : hi) = middle;
  }
  return 0.5 * (lo + hi);
}

/// New columns at the places where most metres of kerb edge lie.
std::vector<double> choose_columns(const SampledGrid& s, const RaySurface& surface,
                                   const RoadMesh& road, const crg::ReferenceLine& line,
                                   const std::vector<Kerb>& kerbs, const KerbOptions& options) {
  const std::size_t columns = s.grid.columns();
  std::map<long, double> metres;  // per bin of v
  const auto every =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(0.5 / s.grid.u_step_m)));
  for (std::size_t i = 0; i < s.grid.rows(); i += every) {
    for (std::size_t j = 0; j + 1 < columns; ++j) {
      const std::size_t node = i * columns + j;
      if (s.provenance[node] == Provenance::none || s.provenance[node + 1] == Provenance::none)
        continue;
      if (is_kerb(s, node) == is_kerb(s, node + 1)) continue;
      const double u = s.grid.u_of(i);
      const bool high = std::any_of(kerbs.begin(), kerbs.end(), [&](const Kerb& k) {
        return k.height_m >= options.min_height_m && u >= k.u_begin_m && u <= k.u_end_m &&
               s.grid.v_m[j + 1] >= k.v_begin_m - 0.2 && s.grid.v_m[j] <= k.v_end_m + 0.2;
      });
      if (!high) continue;
      if (const auto edge = edge_between(s, surface, road, line, i, j, options.zones)) {
        metres[std::lround(*edge / kEdgeBin_m)] += static_cast<double>(every) * s.grid.u_step_m;
      }
    }
  }
  std::vector<std::pair<double, long>> ranked;
  for (const auto& [bin, length] : metres) {
    if (length >= kShortestEdge_m) ranked.emplace_back(-length, bin);
  }
  std::sort(ranked.begin(), ranked.end());

  const auto budget =
      static_cast<std::size_t>(options.max_extra_columns_share * static_cast<double>(columns));
  std::vector<double> all = s.grid.v_m, added;
  for (const auto& [length, bin] : ranked) {
    for (const double offset : {-kHalfFace_m, kHalfFace_m}) {
      const double v = static_cast<double>(bin) * kEdgeBin_m + offset;
      if (added.size() >= budget || v <= s.grid.v_m.front() || v >= s.grid.v_m.back()) continue;
      const auto after = std::lower_bound(all.begin(), all.end(), v);
      if (*after - v < kSmallestColumn_m || v - *(after - 1) < kSmallestColumn_m) continue;
      all.insert(after, v);
      added.push_back(v);
    }
  }
  std::sort(added.begin(), added.end());
  return added;
}

}  // namespace

void mark_kerb_zones(SampledGrid& s, const std::vector<KerbZone>& zones) {
  if (zones.empty()) return;
  const std::size_t columns = s.grid.columns();
  for (std::size_t node = 0; node < s.surface_class.size(); ++node)
    s.surface_class[node] = zoned(s.surface_class[node], s.grid.u_of(node / columns),
                                  s.grid.v_m[node % columns], zones);
}

SampledGrid refine_kerbs(SampledGrid sampled, const RaySurface& surface, const RoadMesh& road,
                         const crg::ReferenceLine& line, const KerbOptions& options,
                         KerbReport* report) {
  KerbReport result;
  mark_kerb_zones(sampled, options.zones);
  result.kerbs = find_kerbs(sampled);
  const std::vector<double> added =
      result.kerbs.empty() ? std::vector<double>{}
                           : choose_columns(sampled, surface, road, line, result.kerbs, options);
  if (!added.empty()) {
    SampledGrid refined;
    refined.grid.u_begin_m = sampled.grid.u_begin_m;
    refined.grid.u_step_m = sampled.grid.u_step_m;
    const auto& old_v = sampled.grid.v_m;
    std::merge(old_v.begin(), old_v.end(), added.begin(), added.end(),
               std::back_inserter(refined.grid.v_m));
    const std::size_t rows = sampled.grid.rows(), columns = refined.grid.columns(),
                      old_columns = old_v.size();
    std::vector<std::ptrdiff_t> source(columns, -1);
    for (std::size_t j = 0, k = 0; j < columns; ++j) {
      if (k < old_columns && refined.grid.v_m[j] == old_v[k])
        source[j] = static_cast<std::ptrdiff_t>(k++);
    }
    refined.grid.z_m.assign(rows * columns, std::numeric_limits<float>::quiet_NaN());
    refined.provenance.assign(rows * columns, Provenance::none);
    refined.surface_class.assign(rows * columns, SurfaceClass::road);
    base::parallel_for(
        rows, kRowsPerChunk, options.threads, [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t j = 0; j < columns; ++j) {
              if (source[j] < 0) continue;
              const std::size_t to = i * columns + j,
                                from = i * old_columns + static_cast<std::size_t>(source[j]);
              refined.grid.z_m[to] = sampled.grid.z_m[from];
              refined.provenance[to] = sampled.provenance[from];
              refined.surface_class[to] = sampled.surface_class[from];
            }
          }
          for (std::size_t j = 0; j < columns; ++j) {
            if (source[j] >= 0) continue;
            for (std::size_t first = begin; first < end; first += 16) {
              const auto nodes = probe_rows(sampled, surface, road, line, first,
                                            std::min<std::size_t>(16, end - first),
                                            refined.grid.v_m[j], options.zones);
              for (std::size_t k = 0; first + k < end && k < 16; ++k) {
                if (!nodes[k]) continue;
                const std::size_t to = (first + k) * columns + j;
                refined.grid.z_m[to] = nodes[k]->z_m;
                refined.provenance[to] = Provenance::mesh;
                refined.surface_class[to] = nodes[k]->surface_class;
              }
            }
          }
        });
    // The last row of a closed line stands for the first.
    if (line.closed) {
      const auto last = static_cast<std::ptrdiff_t>((rows - 1) * columns);
      std::copy_n(refined.grid.z_m.begin(), columns, refined.grid.z_m.begin() + last);
      std::copy_n(refined.provenance.begin(), columns, refined.provenance.begin() + last);
      std::copy_n(refined.surface_class.begin(), columns, refined.surface_class.begin() + last);
    }
    sampled = std::move(refined);
    result.columns_added = added.size();
  }
  for (std::size_t node = 0; node < sampled.provenance.size(); ++node)
    result.cells += is_kerb(sampled, node) ? 1 : 0;
  if (report != nullptr) *report = std::move(result);
  return sampled;
}

}  // namespace road
