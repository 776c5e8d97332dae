#include "road_looks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string>

#include "colour_tone.h"

namespace road {
namespace {

constexpr double kRoadInside = 0.02;  // a look that is rarer under the guide is paint or a mistake
constexpr double kRoadOutside = 2.0;  // the road's look is so many times rarer beside it
constexpr double kBesideMain = 0.1;   // more of the places beside than the road's main look has
constexpr double kNotPaint_m = 0.3;   // from the main look
constexpr double kNamesKnow = 0.95;   // of the places under the guide are called road

}  // namespace

Looks looks_of(const Mesh& mesh) {
  const bool has_looks =
      std::any_of(mesh.objects.begin(), mesh.objects.end(),
                  [](const MeshObject& o) { return !o.material.empty() || !o.texture.empty(); });
  Looks looks;
  std::map<std::string, std::uint32_t> known;
  for (const MeshObject& object : mesh.objects) {
    const std::string name = !has_looks               ? object.name
                             : object.texture.empty() ? object.material
                             : object.material.empty()
                                 ? object.texture
                                 : object.material + " with " + object.texture;
    const auto [at, added] =
        known.try_emplace(name, static_cast<std::uint32_t>(looks.names.size()));
    if (added) looks.names.push_back(name);
    looks.of_object.push_back(at->second);
  }
  return looks;
}

bool part_by_names(const Guide& guide, const RaySurface& surface, const Mesh& mesh,
                   const std::vector<std::uint32_t>& source,
                   const std::vector<SurfaceClass>& by_names, Looks& looks,
                   std::vector<std::uint32_t>& look_of_triangle) {
  std::vector<std::uint32_t> is_named(source.size());
  for (std::size_t k = 0; k < source.size(); ++k)
    is_named[k] = by_names[source[k]] == SurfaceClass::road ? 1 : 0;
  if (look_shares(guide, surface, is_named, 2).inside[1] < kNamesKnow) return false;
  const auto count = static_cast<std::uint32_t>(looks.names.size());
  for (std::uint32_t k = 0; k < count; ++k)
    looks.names.push_back(looks.names[k] + " not called road");
  for (std::size_t k = 0; k < source.size(); ++k)
    if (is_named[k] == 0) {
      look_of_triangle[k] += count;
      looks.of_object[mesh.object_of_triangle[source[k]]] = look_of_triangle[k];
    }
  return true;
}

bool join_rare_looks(const Mesh& mesh, const LookShares& shares, Looks& looks,
                     std::vector<std::uint32_t>& look_of_triangle) {
  const std::vector<std::uint32_t> groups = colour_groups(mesh.objects);
  std::map<std::uint32_t, std::uint32_t> look_of_group;
  std::vector<std::uint32_t> becomes(looks.names.size());
  std::iota(becomes.begin(), becomes.end(), 0U);
  std::map<std::uint32_t, std::size_t> joined;
  std::vector<bool> is_seen(looks.names.size(), false);
  for (std::size_t i = 0; i < mesh.objects.size(); ++i) {
    const std::uint32_t look = looks.of_object[i];
    if (is_seen[look] || groups[i] == kNoGroup || shares.inside[look] >= kRoadInside) continue;
    is_seen[look] = true;
    becomes[look] = look_of_group.try_emplace(groups[i], look).first->second;
    if (becomes[look] != look) ++joined[becomes[look]];
  }
  for (std::uint32_t& look : looks.of_object) look = becomes[look];
  for (std::uint32_t& look : look_of_triangle) look = becomes[look];
  for (const auto& [look, count] : joined)
    looks.names[look] += " and " + std::to_string(count) + " of its colour";
  return !joined.empty();
}

std::vector<bool> road_looks(const LookShares& shares, std::size_t called_road) {
  std::vector<bool> is_road(shares.inside.size(), false);
  std::size_t main = 0;
  const auto worth = [&](std::size_t k) {
    return shares.inside[k] * shares.inside[k] / (shares.outside[k] + 0.05);
  };
  for (std::size_t k = 0; k < is_road.size(); ++k) {
    if (worth(k) > worth(main)) main = k;
    is_road[k] = shares.inside[k] >= (k < called_road ? 0.0 : kRoadInside) &&
                 shares.inside[k] > kRoadOutside * shares.outside[k] &&
                 shares.inside_there[k] > kRoadOutside * shares.outside_there[k];
  }
  // What lies only where the road's main look lies too, or what is called road, is paint on it,
  // ground that goes on beneath it, what carries it, or a roof over what is called road. Paint lies
  // close to it, and not beside the road.
  std::vector<double> alone(is_road.size(), 0.0), far(is_road.size(), 0.0);
  const double each = 1.0 / static_cast<double>(std::max<std::size_t>(shares.places.size(), 1));
  for (const auto& seen : shares.places)
    for (const LookShares::Seen& one : seen) {
      double above_m = std::numeric_limits<double>::quiet_NaN();  // the nearest main look
      for (const LookShares::Seen& other : seen)
        if ((other.look == main || other.look < called_road) &&
            !(std::abs(other.z_m - one.z_m) >= std::abs(above_m)))
          above_m = other.z_m - one.z_m;
      if (std::isnan(above_m))
        alone[one.look] += each;
      else if (above_m > kNotPaint_m || (called_road > 0 && above_m < -kNotPaint_m))
        far[one.look] += each;
    }
  for (std::size_t k = 0; k < is_road.size(); ++k)
    if (alone[k] < kRoadInside &&
        (shares.outside_there[k] > shares.outside_there[main] + kBesideMain ||
         far[k] > 0.5 * shares.inside[k]))
      is_road[k] = false;
  is_road[main] = true;
  return is_road;
}

}  // namespace road
