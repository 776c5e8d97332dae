// Reads the bytes, checks them, writes and reads back, and asks two surfaces: aborts when a refused
// input is refused without naming file and place, when an accepted one answers a height or gradient
// that is not finite where it says it is valid, when the answer depends on the cursor, or when
// writing and reading back changes a value.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "crg/check.h"
#include "crg/error.h"
#include "crg/surface.h"
#include "fuzz/target.h"

namespace crg {
namespace {

#define REQUIRE(condition)                                                 \
  do {                                                                     \
    if (!(condition)) {                                                    \
      std::fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                        \
    }                                                                      \
  } while (false)

constexpr const char* kName = "input.crg";

void require_finite(const Sample& sample) {
  if (!sample.valid) return;
  for (const double value :
       {sample.u_m, sample.v_m, sample.x_m, sample.y_m, sample.z_m, sample.dzdx, sample.dzdy,
        sample.normal_x, sample.normal_y, sample.normal_z, sample.heading_rad}) {
    REQUIRE(std::isfinite(value));
  }
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void query(const Surface& surface) {
  const ReferenceLine& line = surface.reference_line();
  const std::vector<double>& v_m = surface.grid().v_m;
  const double length = line.u_step_m * static_cast<double>(line.size() - 1);
  const double width = v_m.back() - v_m.front();
  Cursor follows, height_follows;
  Point2 four[4] = {};
  Cursor car[4];
  double heights_m[4];
  float strip_m[40];
  for (int k = 0; k < 24; ++k) {
    const double u = line.u_begin_m + length * (-0.2 + 1.4 * std::fmod(0.618034 * k, 1.0));
    const double v = v_m.front() + width * (-0.2 + 1.4 * std::fmod(0.754878 * k, 1.0));
    const Sample by_uv = surface.at_uv(u, v);
    require_finite(by_uv);
    const Point2 point = surface.xy_of_uv(u, v);
    REQUIRE(std::isfinite(point.x_m) && std::isfinite(point.y_m));
    const Sample sample = surface.at_xy(point.x_m, point.y_m, follows);
    require_finite(sample);
    Cursor fresh;
    const UV uv = surface.uv_of_xy(point.x_m, point.y_m, fresh);
    REQUIRE(uv.u_m == sample.u_m && uv.v_m == sample.v_m);
    REQUIRE(same(surface.z_at_xy(point.x_m, point.y_m, height_follows), sample.z_m));
    for (int w = 0; w < 4; ++w)
      four[w] = w == k % 4 ? point : surface.xy_of_uv(u + 0.02 * w * line.u_step_m, v);
    for (int again = 0; again < 2; ++again) surface.z_at_xy(four, car, heights_m);
    REQUIRE(same(heights_m[k % 4], sample.z_m));
    surface.strip({.x_m = point.x_m,
                   .y_m = point.y_m,
                   .ahead = {std::cos(0.3 * k), std::sin(0.3 * k)},
                   .along = 5,
                   .across = 8,
                   .step_m = 0.05},
                  strip_m, follows);
  }
  for (const double far : {0.0, 1e3, -1e9, 1e15}) {
    require_finite(surface.at_xy(far, -far, follows));
    require_finite(surface.at_uv(far, far));
  }
  REQUIRE(!surface.at_xy(NAN, 0.0, follows).valid);
  REQUIRE(!surface.at_uv(INFINITY, 0.0).valid);
}

void require_same_after_writing(const Crg& crg) {
  const Crg back = read_bytes(to_bytes(crg, Format::KDBI), kName);
  REQUIRE(back.grid.z_m.size() == crg.grid.z_m.size());
  for (std::size_t i = 0; i < back.grid.z_m.size(); ++i) {
    const float a = back.grid.z_m[i], b = crg.grid.z_m[i];
    REQUIRE(a == b || (std::isnan(a) && std::isnan(b)));
  }
  REQUIRE(back.heading_rad.size() == crg.heading_rad.size());
}

}  // namespace

}  // namespace crg

void fuzz::run(std::string_view view) {
  using namespace crg;  // NOLINT: a target of this library
  const std::string bytes(view);
  try {
    const Crg crg = read_bytes(bytes, kName);
    const CheckReport report = check(crg);
    for (const Finding& finding : report.findings)
      REQUIRE(!finding.rule.empty() && !finding.message.empty());
    require_same_after_writing(crg);
    for (const ModifierUse use : {ModifierUse::AsInFile, ModifierUse::ReferenceDefaults}) {
      query(Surface(crg, {.modifiers = use}));
    }
  } catch (const Error& error) {
    REQUIRE(std::string(error.what()).starts_with(kName));
    require_refusal(error, kName);
  }
}
