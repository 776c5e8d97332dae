// Roads that divide: a pit lane, an escape road, two parts that are alike.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <numbers>

#include "make/plausible.h"
#include "mesh/error.h"
#include "mesh/ray_surface.h"
#include "road/centreline.h"
#include "road/clean.h"
#include "support/figure.h"

namespace fork_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHalf_m = 6.0, kStraight_m = 300.0, kRadius_m = 80.0;
constexpr double kRound_m = 2.0 * (kStraight_m + std::numbers::pi * kRadius_m);

/// Two straights and two bends, counter-clockwise; positive offsets lie inside.
Vector3d stadium(double s_m, double offset_m) {
  const double bend_m = std::numbers::pi * kRadius_m;
  const bool second = s_m >= kStraight_m + bend_m;
  if (second) s_m -= kStraight_m + bend_m;
  Vector2d p;
  if (s_m < kStraight_m) {
    p = {s_m - 0.5 * kStraight_m, -kRadius_m + offset_m};
  } else {
    const double angle = (s_m - kStraight_m) / kRadius_m - 0.5 * std::numbers::pi;
    p = Vector2d(0.5 * kStraight_m, 0.0) +
        (kRadius_m - offset_m) * Vector2d(std::cos(angle), std::sin(angle));
  }
  if (second) p = -p;
  return {p.x(), p.y(), 0.0};
}

double middle_off_m(const Vector3d& p) {
  double nearest_m = 1e9;
  for (double s_m = 0.0; s_m < kRound_m; s_m += 0.1)
    nearest_m = std::min(nearest_m, (p - stadium(s_m, 0.0)).head<2>().norm());
  return nearest_m;
}

/// Beside the road, in offsets: where the other road's edges lie; equal where there is none.
struct Beside {
  double near_m, far_m;
};

/// A road 12 m wide in one piece with another one, of one material, every vertex used by all that
/// touch there.
road::Mesh divided(const std::function<Beside(double s_m)>& beside) {
  road::Mesh mesh;
  mesh.objects.push_back({"road", "asphalt", ""});
  std::map<std::pair<int, long>, std::uint32_t> known;
  constexpr int kRows = 276;
  const auto vertex = [&](int row, double offset_m) {
    const auto [at, is_new] = known.try_emplace({row % kRows, std::lround(1e4 * offset_m)},
                                                static_cast<std::uint32_t>(mesh.vertices_m.size()));
    if (is_new) mesh.vertices_m.push_back(stadium(kRound_m * (row % kRows) / kRows, offset_m));
    return at->second;
  };
  const auto triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a == b || b == c || c == a) return;
    mesh.triangles.push_back({a, b, c});
    mesh.object_of_triangle.push_back(0);
  };
  const auto piece = [&](int row, Beside from, Beside to) {
    const auto a = vertex(row, from.near_m), b = vertex(row + 1, to.near_m),
               c = vertex(row + 1, to.far_m), d = vertex(row, from.far_m);
    const bool is_inside = from.far_m + to.far_m > from.near_m + to.near_m;
    is_inside ? triangle(a, b, c) : triangle(a, c, b);
    is_inside ? triangle(a, c, d) : triangle(a, d, c);
  };
  for (int row = 0; row < kRows; ++row) {
    piece(row, {-kHalf_m, 0.0}, {-kHalf_m, 0.0});
    piece(row, {0.0, kHalf_m}, {0.0, kHalf_m});
    piece(row, beside(kRound_m * row / kRows),
          row + 1 == kRows ? beside(0.0) : beside(kRound_m * (row + 1) / kRows));
  }
  return mesh;
}

/// A lane that grows out of the road over `taper_m`, moves `gap_m` away, and comes back.
std::function<Beside(double)> lane(double begin_m, double end_m, double width_m, double taper_m,
                                   double gap_m = 6.0) {
  return [=](double s_m) -> Beside {
    const double sign = width_m > 0.0 ? 1.0 : -1.0;
    const double in_m = std::clamp(std::min(s_m - begin_m, end_m - s_m), 0.0, 1e9);
    const double away_m = gap_m * std::clamp((in_m - taper_m) / 40.0, 0.0, 1.0);
    const double near_m = sign * (kHalf_m + away_m);
    return {near_m, near_m + width_m * std::min(1.0, in_m / taper_m)};
  };
}

struct Traced {
  road::Centreline line;
  std::vector<std::string> doubts;
  double off_m = 0.0;
};

Traced trace(const road::Mesh& mesh) {
  road::CleanReport report;
  const road::RoadMesh surface = road::clean(mesh, {}, &report);
  Traced traced;
  traced.line = road::trace_centreline(surface);
  traced.doubts =
      road::doubts_about(traced.line, road::RaySurface(surface.mesh), surface.mesh, mesh, report);
  for (const Vector3d& p : traced.line.points_m)
    traced.off_m = std::max(traced.off_m, middle_off_m(p));
  support::figure_of_case("off_m", traced.off_m);
  return traced;
}

TEST(Fork, APitLaneOfTheSameSurfaceDoesNotMoveTheLine) {
  // Measured: inside 0.0 to 0.3 m, outside 0.2 to 0.3 m; the lane is 5 m wide.
  for (const double taper_m : {20.0, 60.0, 110.0}) {
    for (const double width_m : {5.0, -5.0}) {
      if (std::getenv("KERBSTONE_HEAVY") == nullptr && (taper_m < 100.0) != (width_m > 0.0))
        continue;
      SCOPED_TRACE(testing::Message() << "taper " << taper_m << " m, lane " << width_m << " m");
      const Traced traced = trace(divided(lane(60.0, 500.0, width_m, taper_m)));
      EXPECT_TRUE(traced.line.closed);
      EXPECT_NEAR(traced.line.length_m, kRound_m, 1.0);
      EXPECT_LT(traced.off_m, 0.5);
      EXPECT_TRUE(traced.doubts.empty()) << traced.doubts.front();
    }
  }
}

TEST(Fork, AnEscapeRoadDoesNotMoveTheLine) {
  const Traced traced = trace(divided([](double s_m) {
    // Straight on from the first bend, out of it; it ends.
    return s_m < 200.0 ? lane(40.0, 2000.0, -5.0, 40.0)(s_m) : Beside{-kHalf_m, -kHalf_m};
  }));
  EXPECT_TRUE(traced.line.closed);
  EXPECT_LT(traced.off_m, 0.5);
  EXPECT_TRUE(traced.doubts.empty()) << traced.doubts.front();
}

TEST(Fork, OfAWideRoadAndANarrowOneTheWideOneIsTaken) {
  // The lane runs outside round a bend: it is the longer way.
  const Traced traced = trace(divided(lane(250.0, 600.0, -8.0, 30.0, 15.0)));
  EXPECT_NEAR(traced.line.length_m, kRound_m, 1.0);
  EXPECT_LT(traced.off_m, 0.5);
}

TEST(Fork, TwoPartsThatAreAlikeAreAQuestion) {
  const road::Mesh mesh = divided(lane(20.0, 280.0, 12.0, 60.0));
  const road::RoadMesh surface = road::clean(mesh);
  try {
    road::trace_centreline(surface);
    FAIL() << "took one of two";
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("both parts are alike"));
    EXPECT_THAT(error.what(), testing::HasSubstr("11.7 m wide by way of"));
  }
}

}  // namespace fork_test
