// Writes the reports that page_test.mjs opens: make_report_pages DIR
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>

#include "crg/file.h"
#include "inspect/write_report.h"
#include "report/track_report.h"
#include "support/oval_road.h"

namespace {

using test_support::Oval;
using test_support::plant;

const char* const kMarkup =
    "<img src=x onerror=\"window.hacked=1\"></script><script>window.hacked=1</script>&lt;b&gt;";

/// A figure eight by hand: u = 0 to 600 m in rows 1 m apart, t = u / 600 m * 2 pi - pi / 2 along
/// (100 sin t, 50 sin 2t). The first pass over the middle, at u = 150 m, is a bridge 8 m above the
/// second, at u = 450 m. The plan's outermost columns have no heights. Between columns of the plan,
/// at v = 2.5 m, it has a ridge of 30 mm. Errors are 10 um, but 20 mm from u = 300 to 305 m.
report::TrackReport crossing() {
  report::TrackReport page;
  page.title = "Crossing";
  page.verdict = "usable";
  page.facts = {{"Width", "10.0 m"}};
  page.u_end_m = 600.0;
  const auto z_at = [](double u) {
    return 4.0 * (1.0 + std::cos(u / 600.0 * 2.0 * M_PI - 0.5 * M_PI));
  };
  report::Curve elevation{"elevation_m", "Elevation", "m", {}},
      tiny{"slope", "Slope", "%", {}, 100.0}, drift{"drift_x_m_1", "=Drift", "mm", {}, 1000.0};
  for (int j = -5; j <= 5; ++j) page.sheet.v_m.push_back(j);
  for (int j = -10; j <= 10; ++j) page.detail.v_m.push_back(0.5 * j);
  for (int i = 0; i <= 600; ++i) {
    const double t = i / 600.0 * 2.0 * M_PI - 0.5 * M_PI, dx = 100.0 * std::cos(t),
                 dy = 100.0 * std::cos(2.0 * t), ds = std::hypot(dx, dy);
    page.sheet.x_m.push_back(100.0 * std::sin(t));
    page.sheet.y_m.push_back(50.0 * std::sin(2.0 * t));
    page.sheet.normal_x.push_back(-dy / ds);
    page.sheet.normal_y.push_back(dx / ds);
    const auto z = static_cast<float>(z_at(i));
    for (const double v : page.sheet.v_m)
      page.sheet.z_m.push_back(std::abs(v) < 4.5 ? z : std::numeric_limits<float>::quiet_NaN());
    for (const double v : page.detail.v_m) page.detail.z_m.push_back(z + (v == 2.5 ? 0.03f : 0.0f));
    elevation.values.push_back(z);
    tiny.values.push_back(static_cast<float>(1e-14 * std::sin(t)));
    drift.values.push_back(static_cast<float>(4e-6 * std::sin(t)));
  }
  // A sheet without fields of its own has no elevation to colour it by either.
  page.sheet.fields.push_back(
      {"grip", "Grip", "1", std::vector<float>(page.sheet.z_m.size(), 1.0f), 1.0, false, {}});
  page.curves = {elevation, tiny, drift};
  report::ComparisonView errors;
  errors.key = "mesh";
  errors.reference = "mesh";
  errors.v_m = page.sheet.v_m;
  errors.rows = 600;
  for (std::size_t i = 0; i < errors.rows; ++i) {
    for (std::size_t j = 0; j < errors.v_m.size(); ++j)
      errors.error_m.push_back(i >= 300 && i < 305 ? 0.02f : 1e-5f);
  }
  errors.without_reference.assign(errors.error_m.size(), 0);
  errors.points = errors.error_m.size();
  errors.mean_m = -3.55e-15;
  errors.p50_m = 3.55e-15;
  errors.p95_m = errors.p99_m = 1e-5;
  errors.max_m = 0.02;
  errors.histogram_begin_m = -1e-6;
  errors.histogram_step_m = 2e-6 / 61;
  for (std::size_t k = 0; k < 61; ++k) errors.histogram.push_back(k == 30 ? 100 : 1);
  errors.worst = {{"worst",
                   302.0,
                   0.0,
                   0.02,
                   {-0.0012, 0.0, 0.0012},
                   {{"file", {0.0, 0.02, 0.0}}, {"mesh", {0.0, 0.0, 1e-9}}}}};
  page.comparisons = {errors};
  page.extra = {
      {"From elsewhere",
       {"A sentence."},
       {{"=fact", "@value"}},
       {{"=cmd|' /C calc'!A0",
         1.0,
         0.0,
         0.0,
         {-1.0, 1.0},
         {{"=1+1", {0.5, 0.25}}, {"say \"hi\", you", {-0.5, 1.0}}, {"\t@x", {1.0, 2.0}}}}}}};
  return page;
}

void write_pages(const std::filesystem::path& dir) {
  const Oval clean = test_support::oval_road();
  const std::string clean_path = (dir / "oval.crg").string();
  crg::write(crg::make_crg(clean.line, clean.grid, {"an oval for tests"}), clean_path,
             crg::Format::KRBI);

  if (report::page_available()) {
    std::filesystem::create_directories(dir / "crossing");
    std::ofstream(dir / "crossing" / "report.html", std::ios::binary)
        << report::report_page(crossing());
  }

  road::ReportRequest request;
  request.crg_path = clean_path;
  request.title = "Clean oval";
  road::write_report(request, (dir / "clean").string());

  // One defect of each kind, and names that try to be markup.
  Oval bad = clean;
  plant(bad, [](double u, double v) {
    double z = u < 200.03 || u > 800.0 ? 0.0 : 0.02 * (1.0 - (u - 200.03) / 599.97);
    if (std::abs(u - 120.0) < 1.0) z += 0.05 * (1.0 + std::cos(M_PI * (u - 120.0)));
    if (std::hypot(u - 431.2, v + 2.3) < 0.06) z = std::numeric_limits<double>::quiet_NaN();
    if (u > 600.0 && u < 600.3) z = std::numeric_limits<double>::quiet_NaN();
    if (u > 330.0 && u < 345.0 && v > 6.0 && v < 7.0)
      z -= 0.03 * (v < 6.6 ? (v - 6.0) / 0.6 : (7.0 - v) / 0.4);
    return z;
  });
  const std::string bad_path = (dir / "defects.crg").string();
  crg::write(crg::make_crg(bad.line, bad.grid, {kMarkup, "second line"}), bad_path,
             crg::Format::KRBI);
  const std::string hostile_path = (dir / "<img src=x onerror=window.hacked=1>.crg").string();
  crg::write(crg::make_crg(clean.line, clean.grid), hostile_path, crg::Format::KRBI);

  const road::Mesh mesh = test_support::mesh_of(clean, 2);
  road::ReportRequest full;
  full.crg_path = bad_path;
  full.title = kMarkup;
  full.mesh = &mesh;
  full.against_path = hostile_path;
  Oval rough = clean;
  plant(rough, [](double u, double v) { return 0.001 * std::sin(20.0 * u + 3.0 * v); });
  const crg::Crg before = crg::make_crg(rough.line, rough.grid);
  full.before = &before;
  full.control_points = {{kMarkup, {0, 0, 0}, {0.01, 0, 0}},
                         {"P2", {100, 0, 0}, {100, 0, 0}},
                         {"P3", {0, 50, 0}, {0, 50.02, 0}}};
  full.sources = {{kMarkup, kMarkup, "00"}};
  full.command_line = kMarkup;
  road::write_report(full, (dir / "defects").string());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_report_pages DIR\n");
    return 2;
  }
  try {
    std::filesystem::create_directories(argv[1]);
    write_pages(argv[1]);
    return report::page_available() ? 0 : 77;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
