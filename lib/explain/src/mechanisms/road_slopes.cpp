// A road that leans, climbs or bends up and down where its file does not.
#include "listing.h"
#include "road_changes.h"

namespace explain::road_slopes {
namespace {

constexpr const char* kBanking = kRoad[0].id;
constexpr const char* kGrade = kRoad[1].id;
constexpr const char* kCurvature = kRoad[2].id;

void list_banking(const Listing& l) {
  const bool vy = has(l, kVy), ay = has(l, kAy);
  if (!vy && !ay) return untestable(l, kBanking, "needs the lateral speed");
  Unknown& u = candidate(
      l, kBanking, {"banking added", "m/m", 0.01, vy && ay ? 0.006 : 0.015},
      {"the road leans more (or less) than the file says", "dvy/dt + r vx = Fy/m - g bank",
       "survey the cross slope with a level at the place"},
      [](Setting& s, double v) { s.bank += v; });
  u.along_road = true;
  // Gravity in an acceleration tells to which side; a cosine alone says how much.
  const Signals& first = l.logs.front();
  if (first.present[kAy] && first.present[kVy]) u.profile = &RoadProfiles::bank;
}

void list_grade(const Listing& l) {
  if (!l.engine && !has(l, kAx)) return untestable(l, kGrade, "needs throttle or ax");
  Unknown& u = candidate(
      l, kGrade, {"grade added", "m/m", 0.01, 0.005},
      {"the road climbs more (or less) than the file says", "dvx/dt - r vy = Fx/m - g grade",
       "drive the place in both directions, or coast through it"},
      [](Setting& s, double v) { s.grade += v; });
  u.along_road = true;
  u.sums_to_nothing = true;  // a closed road comes back to its height
  if (l.logs.front().present[kAx]) u.profile = &RoadProfiles::grade;
}

void list_curvature(const Listing& l) {
  if (!has(l, kAz) && !has(l, kLoadFront))
    return untestable(l, kCurvature, "needs az or wheel loads");
  Unknown& u = candidate(l, kCurvature, {"curvature added", "1/m", 0.0005, 0.0002},
                         {"a crest or dip that the file does not have", "az = g + curvature v^2",
                          "pass the place at another speed"},
                         [](Setting& s, double v) { s.vertical += v; });
  u.along_road = true;
  if (l.logs.front().present[kAz]) u.profile = &RoadProfiles::vertical;
}

/// The integral along the road; what does not come back to zero at the end is spread over the lap.
void integrate(std::vector<double>& v, double u_step_m) {
  double sum = 0;
  for (double& x : v) sum += x * u_step_m, x = sum;
  const double left = v.back();
  for (std::size_t i = 0; i < v.size(); ++i)
    v[i] -= left * static_cast<double>(i) / static_cast<double>(v.size() - 1);
}

void add_rise(crg::Grid& grid, const std::vector<double>& rise_m) {
  for (std::size_t i = 0; i < grid.rows(); ++i)
    for (std::size_t j = 0; j < grid.columns(); ++j) grid.at(i, j) += static_cast<float>(rise_m[i]);
}

std::vector<double> profile_of(const crg::Grid& grid, bool closed, const Finding& f) {
  return profile_along(f.profile, grid.rows(), grid.u_step_m, closed);
}

void write_banking(crg::Crg& road, bool closed, const Finding& f) {
  if (f.profile.size() < 2) return;
  const std::vector<double> along = profile_of(road.grid, closed, f);
  for (std::size_t i = 0; i < road.grid.rows(); ++i)
    for (std::size_t j = 0; j < road.grid.columns(); ++j)
      road.grid.at(i, j) += static_cast<float>(along[i] * road.grid.v_m[j]);
  // What keeps the height where the cars drove, one bin across.
  if (f.patch.dz_m.size() != f.profile.size()) return;
  std::vector<ProfilePoint> kept = f.profile;
  for (std::size_t k = 0; k < kept.size(); ++k) kept[k].value = f.patch.dz_m[k];
  add_rise(road.grid, profile_along(kept, road.grid.rows(), road.grid.u_step_m, closed));
}

/// Grade is the derivative of the height.
void write_grade(crg::Crg& road, bool closed, const Finding& f) {
  if (f.profile.size() < 2) return;
  std::vector<double> rise = profile_of(road.grid, closed, f);
  integrate(rise, road.grid.u_step_m);
  add_rise(road.grid, rise);
}

/// Curvature is the second derivative.
void write_curvature(crg::Crg& road, bool closed, const Finding& f) {
  if (f.profile.size() < 2) return;
  std::vector<double> rise = profile_of(road.grid, closed, f);
  integrate(rise, road.grid.u_step_m);
  double mean = 0;
  for (const double x : rise) mean += x / static_cast<double>(rise.size());
  for (double& x : rise) x -= mean;
  integrate(rise, road.grid.u_step_m);
  add_rise(road.grid, rise);
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kBanking, .list = list_banking, .most = 0.7, .write_heights = write_banking},
          {.id = kGrade, .list = list_grade, .most = 0.2, .write_heights = write_grade},
          {.id = kCurvature, .list = list_curvature, .write_heights = write_curvature}};
}

}  // namespace explain::road_slopes
