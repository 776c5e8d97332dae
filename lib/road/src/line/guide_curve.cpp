#include "guide_curve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kReachShare =
    0.025;  // of the guide's length: a circuit has no room for wider roads,
constexpr double kReachShareOpen = 0.1;  // a piece of a road has
constexpr double kSmallestReach_m = 1.0;
constexpr double kRowsPerReach = 15.0, kRaysPerReach = 60.0;

/// Points on the centripetal Catmull-Rom curve through the guide (Yuksel et al. 2011), evenly
/// spaced; z is linear in between.
std::vector<Vector3d> resampled(const Guide& guide, double step_m) {
  const std::vector<Vector3d>& p = guide.points_m;
  const auto n = static_cast<std::ptrdiff_t>(p.size());
  const auto at = [&](std::ptrdiff_t i) -> Vector2d {
    if (guide.closed) return p[static_cast<std::size_t>((i % n + n) % n)].head<2>();
    if (i < 0) return 2.0 * p[0].head<2>() - p[1].head<2>();
    if (i >= n)
      return 2.0 * p[static_cast<std::size_t>(n - 1)].head<2>() -
             p[static_cast<std::size_t>(n - 2)].head<2>();
    return p[static_cast<std::size_t>(i)].head<2>();
  };
  std::vector<Vector3d> fine;
  for (std::ptrdiff_t i = 0; i < (guide.closed ? n : n - 1); ++i) {
    const Vector2d a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
    const double ab = std::sqrt(std::max((b - a).norm(), 1e-9)),
                 bc = std::sqrt(std::max((c - b).norm(), 1e-9)),
                 cd = std::sqrt(std::max((d - c).norm(), 1e-9));
    const double zb = p[static_cast<std::size_t>(i)].z(),
                 zc = p[static_cast<std::size_t>((i + 1) % n)].z();
    const auto pieces =
        static_cast<int>(std::clamp((c - b).norm() / step_m * 4.0, 1.0, 100000.0)) + 1;
    for (int k = 0; k < pieces; ++k) {
      const double t = ab + bc * k / pieces;
      const Vector2d a1 = (ab - t) / ab * a + t / ab * b,
                     a2 = (ab + bc - t) / bc * b + (t - ab) / bc * c,
                     a3 = (ab + bc + cd - t) / cd * c + (t - ab - bc) / cd * d;
      const Vector2d b1 = (ab + bc - t) / (ab + bc) * a1 + t / (ab + bc) * a2,
                     b2 = (ab + bc + cd - t) / (bc + cd) * a2 + (t - ab) / (bc + cd) * a3;
      const Vector2d q = (ab + bc - t) / bc * b1 + (t - ab) / bc * b2;
      fine.emplace_back(q.x(), q.y(), zb + (zc - zb) * k / pieces);
    }
  }
  fine.push_back(guide.closed ? fine.front() : p.back());
  std::vector<double> s_m{0.0};
  for (std::size_t i = 1; i < fine.size(); ++i)
    s_m.push_back(s_m.back() + (fine[i] - fine[i - 1]).head<2>().norm());
  const auto count =
      std::max<std::size_t>(4, static_cast<std::size_t>(std::lround(s_m.back() / step_m)));
  std::vector<Vector3d> even;
  std::size_t k = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double here_m =
        s_m.back() * static_cast<double>(i) / static_cast<double>(guide.closed ? count : count - 1);
    while (k + 2 < s_m.size() && s_m[k + 1] < here_m) ++k;
    const double t = std::clamp((here_m - s_m[k]) / std::max(s_m[k + 1] - s_m[k], 1e-12), 0.0, 1.0);
    even.push_back(fine[k] + t * (fine[k + 1] - fine[k]));
  }
  return even;
}

}  // namespace

GuideRows empty_rows(const Guide& guide) {
  GuideRows all;
  all.closed = guide.closed;
  double length_m = 0.0;
  for (std::size_t i = 1; i < guide.points_m.size(); ++i)
    length_m += (guide.points_m[i] - guide.points_m[i - 1]).head<2>().norm();
  all.reach_m = std::clamp((guide.closed ? kReachShare : kReachShareOpen) * length_m,
                           kSmallestReach_m, kUsualReach_m);
  all.across_m = all.reach_m / kRaysPerReach;
  const std::vector<Vector3d> curve = resampled(guide, all.reach_m / kRowsPerReach);
  const std::size_t n = curve.size();
  all.step_m = (curve[1] - curve[0]).head<2>().norm();
  all.rows.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0 ? i - 1 : (guide.closed ? n - 1 : 0),
                      after = i + 1 < n ? i + 1 : (guide.closed ? 0 : i);
    all.rows[i].at_m = curve[i].head<2>();
    all.rows[i].z_m = curve[i].z();
    all.rows[i].heading = (curve[after] - curve[before]).head<2>().normalized();
  }
  return all;
}

}  // namespace road
