// Writes the reports that page_test.mjs opens: make_report_pages DIR
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <limits>

#include "crg/file.h"
#include "report/track_report.h"
#include "road/write_report.h"
#include "support/oval_road.h"

namespace {

using test_support::Oval;
using test_support::plant;

const char* const kMarkup = "<img src=x onerror=\"window.hacked=1\"></script><script>window.hacked=1</script>&lt;b&gt;";

void write_pages(const std::filesystem::path& dir) {
  const Oval clean = test_support::oval_road();
  const std::string clean_path = (dir / "oval.crg").string();
  crg::write(crg::make_crg(clean.line, clean.grid, {"an oval for tests"}), clean_path, crg::Format::KRBI);

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
    if (u > 330.0 && u < 345.0 && v > 6.0 && v < 7.0) z -= 0.03 * (v < 6.6 ? (v - 6.0) / 0.6 : (7.0 - v) / 0.4);
    return z;
  });
  const std::string bad_path = (dir / "defects.crg").string();
  crg::write(crg::make_crg(bad.line, bad.grid, {kMarkup, "second line"}), bad_path, crg::Format::KRBI);
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
  full.control_points = {{kMarkup, {0, 0, 0}, {0.01, 0, 0}}, {"P2", {100, 0, 0}, {100, 0, 0}}, {"P3", {0, 50, 0}, {0, 50.02, 0}}};
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
