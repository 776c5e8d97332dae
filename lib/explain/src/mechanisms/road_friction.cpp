// Grip of the road that its file does not have.
#include <algorithm>
#include <cmath>

#include "base/interval90.h"
#include "effect.h"
#include "listing.h"
#include "road_changes.h"

namespace explain::road_friction {
namespace {

constexpr const char* kId = kRoad[3].id;

/// Amount: grip added, as a share.
constexpr Effect kGrip{
    .on_the_way = [](Underway& now, const Acting& a) { now.grip *= 1 + a.amount[0]; }};

void list(const Listing& l) {
  if (!l.lateral) return untestable(l, kId, kNoSlip);
  candidate(l, kId, {kRoad[3].name, kRoad[3].unit, kRoad[3].step, kRoad[3].least},
            {"the road has more (or less) grip here", "mu = mu_tyre (1 + change)",
             "brake hard at the place and beside it"},
            [](Setting& s, double v) { s.act(kGrip, v); })
      .along_road = true;
}

/// The profile of grip that a simulated car is given. A cell where the tyres are hardly used says
/// nothing by itself and one that says too little grip spins the wheels: each counts by its
/// interval, beside the tenth that stated tyre curves get wrong about grip, and neighbours of 10 m
/// differ by 0.05 (one standard deviation). Nothing is added at either end.
std::vector<ProfilePoint> steadied(std::vector<ProfilePoint> profile) {
  constexpr double kCurves = 0.1, kStep_per10m = 0.05;
  const std::size_t n = profile.size();
  const double step = kStep_per10m * std::sqrt((profile[1].u_m - profile[0].u_m) / 10);
  const double tie = 1 / (step * step);
  std::vector<double> diagonal(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double deviation = std::hypot(profile[i].ci90 / base::kNormal90, kCurves);
    const double weight = 1 / (deviation * deviation);
    diagonal[i] = weight + 2 * tie;
    profile[i].value *= weight;
    if (i == 0) continue;
    profile[i].value += tie / diagonal[i - 1] * profile[i - 1].value;
    diagonal[i] -= tie * tie / diagonal[i - 1];
  }
  for (std::size_t i = n; i-- > 0;)
    profile[i].value =
        (profile[i].value + (i + 1 < n ? tie * profile[i + 1].value : 0.0)) / diagonal[i];
  return profile;
}

void write(crg::Crg& factors, bool closed, const Finding& f) {
  crg::Grid& grid = factors.grid;
  const std::vector<double> along =
      profile_along(steadied(f.profile), grid.rows(), grid.u_step_m, closed);
  for (std::size_t i = 0; i < grid.rows(); ++i)
    for (std::size_t j = 0; j < grid.columns(); ++j)
      grid.at(i, j) *= static_cast<float>(std::clamp(1 + along[i], 0.1, 2.0));
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kId, .list = list, .most = 0.6, .write_grip = write}};
}

}  // namespace explain::road_friction
