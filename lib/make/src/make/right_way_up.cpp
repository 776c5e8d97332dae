#include "right_way_up.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "base/statistics.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kEvery_m = 5.0;
constexpr double kAside = 0.6;       // of the half width: inside of kerbs and rims
constexpr double kClearShare = 0.8;  // of the places that tell anything
constexpr double kTelling = 0.3;     // of all places; of bends they are few
constexpr std::size_t kFewestBends = 10, kFewestStraight = 10;
// Roads fall to their sides by 1 to 4 %; a steeper trough is a model's.
constexpr double kLeastCrown = 0.004, kMostCrown = 0.06;
constexpr double kLeastBank = 0.01, kWidestBend_m = 400.0;
constexpr double kLowest_m = 0.03, kHighest_m = 2.5;  // paint lies lower, bridges higher

/// For and against, by places.
struct Votes {
  std::size_t yes = 0, no = 0;
  void add(bool is_yes) { ++(is_yes ? yes : no); }
  int told(double of_all) const {
    const auto most = static_cast<double>(std::max(yes, no)), both = static_cast<double>(yes + no);
    if (both == 0.0 || both < of_all || most < kClearShare * both) return 0;
    return yes > no ? 1 : -1;
  }
};

struct LinePlace {
  Vector3d at_m;
  Vector2d left;
  double half_m;
};

std::vector<LinePlace> places_along(const Centreline& line) {
  std::vector<LinePlace> places;
  double gone_m = kEvery_m;
  for (std::size_t i = 0; i + 1 < line.points_m.size(); ++i) {
    const Vector2d along = (line.points_m[i + 1] - line.points_m[i]).head<2>();
    gone_m += along.norm();
    if (gone_m < kEvery_m || along.norm() == 0.0) continue;
    gone_m = 0.0;
    places.push_back(
        {line.points_m[i], Vector2d(-along.y(), along.x()).normalized(), line.half_width_m[i]});
  }
  return places;
}

/// 1 / radius at the middle of three places, positive to the left.
double curvature(const LinePlace& before, const LinePlace& after) {
  const double way_m = (after.at_m - before.at_m).head<2>().norm();
  const double turn =
      std::atan2(before.left.x() * after.left.y() - before.left.y() * after.left.x(),
                 before.left.dot(after.left));
  return way_m > 0.0 ? turn / way_m : 0.0;
}

}  // namespace

WayUp right_way_up(const Centreline& line, const RaySurface& road, const RaySurface* everything) {
  const std::vector<LinePlace> places = places_along(line);
  Votes crown, bank, cover;
  std::vector<double> banks, bends_1pm;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const LinePlace& place = places[i];
    const double aside_m = kAside * place.half_m;
    const auto height = [&](double v_m) {
      const Vector2d at = place.at_m.head<2>() + v_m * place.left;
      return road.nearest_hit(at.x(), at.y(), place.at_m.z(), 0.5 + 0.5 * std::abs(v_m));
    };
    const auto middle = height(0.0), left = height(aside_m), right = height(-aside_m);
    if (!middle || !left || !right) continue;
    const double crowned = (middle->z_m - 0.5 * (left->z_m + right->z_m)) / aside_m;
    if (std::abs(crowned) > kLeastCrown && std::abs(crowned) < kMostCrown) crown.add(crowned > 0.0);
    const double banked = 0.5 * (left->z_m - right->z_m) / aside_m;
    const double bend =
        i > 1 && i + 2 < places.size() ? curvature(places[i - 2], places[i + 2]) : 0.0;
    banks.push_back(banked);
    bends_1pm.push_back(bend);
    if (everything == nullptr) continue;
    bool over = false, under = false;
    for (const SurfaceHit& hit : everything->all_hits(place.at_m.x(), place.at_m.y())) {
      const double off_m = hit.z_m - middle->z_m;
      if (std::abs(off_m) >= kLowest_m && std::abs(off_m) <= kHighest_m)
        (off_m > 0.0 ? over : under) = true;
    }
    if (over != under) cover.add(under);
  }
  // A road that falls to one side all along is not banked. Most of an oval is bend: what its
  // straights have alike counts there.
  const auto is_bend = [&](std::size_t i) { return std::abs(bends_1pm[i]) > 1.0 / kWidestBend_m; };
  std::vector<double> straight, apart;
  for (std::size_t i = 0; i < banks.size(); ++i)
    if (!is_bend(i)) straight.push_back(banks[i]);
  const double of_straights = base::median_or(0.0, straight);
  for (const double banked : straight) apart.push_back(std::abs(banked - of_straights));
  const bool are_alike =
      straight.size() >= kFewestStraight && base::median_or(0.0, apart) < kLeastBank;
  const double all_along = are_alike ? of_straights : base::median_or(0.0, banks);
  for (std::size_t i = 0; i < banks.size(); ++i)
    if (const double banked = banks[i] - all_along; std::abs(banked) > kLeastBank && is_bend(i))
      bank.add(banked * bends_1pm[i] < 0.0);
  const double some = kTelling * static_cast<double>(places.size());
  const int told[] = {crown.told(some), bank.told(kFewestBends), cover.told(some)};
  const auto [least, most] = std::minmax_element(std::begin(told), std::end(told));
  const bool is_told = *least >= 0 || *most <= 0;
  // Troughs are drawn, and bends banked outwards all along are not.
  return {is_told ? *least + *most : 0, is_told ? *least + *most : told[1]};
}

std::optional<std::string> doubt_about_up(const Centreline& line, const RaySurface& road,
                                          UpAxis up) {
  if (right_way_up(line, road, nullptr).told >= 0) return std::nullopt;
  return fmt::format(
      "the road is a trough, or its bends are banked outwards, as if it were upside down: if its "
      "heights are negated, give --up {} --mirror; if it is right so, give --up {}",
      name_of(up_along(line_of(up), !is_minus(up))), name_of(up));
}

}  // namespace road
