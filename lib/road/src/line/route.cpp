#include "road/route.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>

#include "base/statistics.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFarWidths = 10.0;  // of the road: a point farther from it is a mistake

/// Every place of the graph, and which are next to each other.
struct Net {
  struct Place {
    Vector3d point_m;
    double half_width_m;
    std::vector<std::uint32_t> next;
    bool is_node;
  };
  std::vector<Place> places;
};

Net net_of(const RoadGraph& graph) {
  Net net;
  for (const RoadNode& node : graph.nodes)
    net.places.push_back({node.point_m, node.half_width_m, {}, true});
  const auto join = [&](std::size_t a, std::size_t b) {
    net.places[a].next.push_back(static_cast<std::uint32_t>(b));
    net.places[b].next.push_back(static_cast<std::uint32_t>(a));
  };
  for (const RoadBranch& branch : graph.branches) {
    std::size_t last = branch.from;
    for (std::size_t i = 0; i < branch.points_m.size(); ++i) {
      net.places.push_back({branch.points_m[i], branch.half_width_m[i], {}, false});
      join(last, net.places.size() - 1);
      last = net.places.size() - 1;
    }
    join(last, branch.to);
  }
  return net;
}

base::Answer<std::size_t> nearest(const Net& net, const Vector2d& p, std::size_t number) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < net.places.size(); ++i)
    if ((net.places[i].point_m.head<2>() - p).squaredNorm() <
        (net.places[best].point_m.head<2>() - p).squaredNorm())
      best = i;
  const double off_m = (net.places[best].point_m.head<2>() - p).norm();
  if (off_m > kFarWidths * 2.0 * net.places[best].half_width_m)
    return base::Refusal(fmt::format(
        "point {} of the route, ({:.1f}, {:.1f}), is {:.0f} m from the nearest road, at ({:.1f}, "
        "{:.1f}); wanted points on the road "
        "in the frame of the mesh (--route X,Y X,Y ...)",
        number, p.x(), p.y(), off_m, net.places[best].point_m.x(), net.places[best].point_m.y()));
  return best;
}

/// Places from `from` to `to` without both ends' repetition; empty when there is no way but over
/// what is used.
std::vector<std::size_t> shortest(const Net& net, std::size_t from, std::size_t to,
                                  const std::vector<char>& used) {
  std::vector<double> length_m(net.places.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> before(net.places.size(), net.places.size());
  std::priority_queue<std::pair<double, std::size_t>, std::vector<std::pair<double, std::size_t>>,
                      std::greater<>>
      open;
  length_m[from] = 0.0;
  open.emplace(0.0, from);
  while (!open.empty()) {
    const auto [here_m, at] = open.top();
    open.pop();
    if (here_m > length_m[at]) continue;
    if (at == to && at != from) break;
    for (const std::uint32_t next : net.places[at].next) {
      if (used[next] != 0 && next != to) continue;
      const double there_m = here_m + (net.places[next].point_m - net.places[at].point_m).norm();
      if (there_m >= length_m[next]) continue;
      length_m[next] = there_m;
      before[next] = at;
      open.emplace(there_m, next);
    }
  }
  if (before[to] == net.places.size()) return {};
  std::vector<std::size_t> path{to};
  while (path.back() != from) path.push_back(before[path.back()]);
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace

base::Answer<RoadWay> way_through(const RoadGraph& graph, const std::vector<Vector2d>& points_m) {
  const Net net = net_of(graph);
  if (net.places.empty())
    return base::Refusal("nothing looks like road: a route has nothing to lead over");
  std::vector<std::size_t> stops;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const auto place = nearest(net, points_m[i], i + 1);
    if (!place) return place.refusal();
    stops.push_back(*place);
  }
  RoadWay way;
  way.closed = stops.size() > 2 && stops.front() == stops.back();
  std::vector<char> used(net.places.size(), 0);
  const auto add = [&](std::size_t place) {
    way.points_m.push_back(net.places[place].point_m);
    way.half_width_m.push_back(net.places[place].half_width_m);
    if (!net.places[place].is_node) used[place] = 1;
  };
  add(stops.front());
  for (std::size_t k = 1; k < stops.size(); ++k) {
    if (stops[k] == stops[k - 1]) continue;
    const std::vector<std::size_t> path = shortest(net, stops[k - 1], stops[k], used);
    if (path.empty())
      return base::Refusal(fmt::format(
          "there is no way over what looks like road from point {} of the route, ({:.1f}, {:.1f}), "
          "to point {}, ({:.1f}, {:.1f}), that uses "
          "no road twice; give the points in the order of driving, or a line (--guide FILE)",
          k, points_m[k - 1].x(), points_m[k - 1].y(), k + 1, points_m[k].x(), points_m[k].y()));
    for (std::size_t i = 1; i < path.size(); ++i) add(path[i]);
  }
  if (way.closed) way.points_m.pop_back(), way.half_width_m.pop_back();
  if (way.points_m.size() < 4)
    return base::Refusal(
        "the route is a point; wanted at least two points some widths of the road apart (--route "
        "X,Y X,Y ...)");
  for (std::size_t i = 1; i < way.points_m.size() + (way.closed ? 1 : 0); ++i)
    way.length_m += (way.points_m[i % way.points_m.size()] - way.points_m[i - 1]).head<2>().norm();
  return way;
}

base::Answer<Guide> guide_of(const RoadWay& way) {
  Guide guide{{}, way.closed};
  const double half_m = base::median(way.half_width_m);
  const auto n = static_cast<std::ptrdiff_t>(way.points_m.size());
  double since_m = std::numeric_limits<double>::infinity();
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const auto at = [&](std::ptrdiff_t k) -> const Vector3d& {
      return way.points_m[static_cast<std::size_t>(
          way.closed ? (k % n + n) % n : std::clamp<std::ptrdiff_t>(k, 0, n - 1))];
    };
    if (i > 0) since_m += (at(i) - at(i - 1)).head<2>().norm();
    const bool is_end = !way.closed && (i == 0 || i == n - 1);
    if (since_m < 2.0 * half_m && !is_end) continue;
    since_m = 0.0;
    // Of the places within half a width.
    Vector3d sum = at(i);
    double count = 1.0;
    for (std::ptrdiff_t k = 1; !is_end && k < n / 4; ++k) {
      if ((at(i + k) - at(i)).head<2>().norm() > half_m ||
          (at(i - k) - at(i)).head<2>().norm() > half_m)
        break;
      sum += at(i + k) + at(i - k);
      count += 2.0;
    }
    guide.points_m.push_back(sum / count);
  }
  if (guide.points_m.size() < 3)
    return base::Refusal(
        fmt::format("the road found is {:.0f} m long and {:.0f} m wide; a road is longer than wide",
                    way.length_m, 2.0 * half_m));
  return guide;
}

std::vector<Vector2d> points_that_tell(const RoadGraph& graph, const RoadWay& way) {
  const std::size_t n = way.points_m.size();
  for (const std::size_t count : {2, 3, 4, 6, 8, 12, 16}) {
    if (way.closed && count < 3) continue;
    std::vector<Vector2d> points;
    for (std::size_t k = 0; k < count; ++k) {
      const Vector3d& p = way.points_m[way.closed ? k * n / count : k * (n - 1) / (count - 1)];
      points.emplace_back(std::round(10.0 * p.x()) / 10.0, std::round(10.0 * p.y()) / 10.0);
    }
    if (way.closed) points.push_back(points.front());
    const auto again = way_through(graph, points);
    if (again && again->closed == way.closed &&
        std::abs(again->length_m - way.length_m) < 0.03 * way.length_m)
      return points;
  }
  return {};
}

}  // namespace road
