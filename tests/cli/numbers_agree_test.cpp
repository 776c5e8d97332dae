// The demo circuit, built once: width, largest error, kerbs and heights are the same numbers
// wherever they are told, in the terminal, summary.json, report.json, report.html and by the
// commands that look at the road later.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "crg/file.h"
#include "support/demo_circuit.h"
#include "support/places.h"
#include "support/run_crgbuild.h"

namespace cli {
namespace numbers_agree_test {

using ::testing::HasSubstr;
using Json = nlohmann::json;

Json data_of_page(const std::string& html) {
  const std::string begin = "id=\"report-data\">";
  const std::size_t at = html.find(begin);
  return at == std::string::npos
             ? Json()
             : base::parse_json<Json>(
                   html.substr(at + begin.size(), html.find("</script>", at) - at - begin.size()));
}

std::string fact(const Json& report, const std::string& name) {
  for (const Json& f : report["facts"]) {
    if (f["name"] == name) return f["value"];
  }
  return "no fact " + name;
}

TEST(Numbers, OfTheDemoAreTheSameEverywhere) {
  const Folder folder;
  support::put_demo_circuit(folder.path());
  const std::string circuit = folder / "tracks/kerbstone-ring/circuit.yaml";
  if (std::getenv("KERBSTONE_HEAVY") == nullptr)  // a kerb of two steps, for a rough place
    write(
        circuit,
        read(circuit) +
            "  - {side: left, u_begin_m: 400, u_end_m: 440, width_m: 1.6, height_m: 0.10, profile: "
            "[[0, 0], [0.05, 0.3], [0.5, 0.4], [0.56, 1.0], [0.95, 0.95], [1, 0]]}\n");
  std::filesystem::copy(places::source() + "/tracks/kerbstone-ring/track.yaml",
                        folder / "tracks/kerbstone-ring");
  ASSERT_EQ(crgbuild({"synth", circuit, "-o", folder / "out/demo"}).code, 0);
  const Ran built =
      crgbuild({"build", folder / "tracks/kerbstone-ring/track.yaml", "-o", folder / "out/demo"});
  ASSERT_EQ(built.code, 0) << built.err;
  const std::string road = folder / "out/demo/kerbstone-ring.crg";
  const Json summary = base::parse_json<Json>(read(folder / "out/demo/summary.json")),
             report = base::parse_json<Json>(read(folder / "out/demo/report.json"));
  const Ran info = crgbuild({"info", road}), info_json = crgbuild({"info", road, "--json"});
  const Ran later = crgbuild(
      {"report", road, "--mesh", folder / "out/demo/kerbstone-ring.obj", "-o", folder / "later"});
  ASSERT_EQ(later.code, 0) << later.err;
  const Json of_file = base::parse_json<Json>(info_json.out)["grid"],
             report_later = base::parse_json<Json>(read(folder / "later/report.json"));
  std::vector<const Json*> reports{&report, &report_later};
  const Json page = exists(folder / "out/demo/report.html")
                        ? data_of_page(read(folder / "out/demo/report.html"))
                        : report;
  ASSERT_TRUE(page.is_object());
  reports.push_back(&page);
  const auto m = [](const Json& number) { return number.get<double>(); };

  // Width.
  const Json &line = summary["centreline"], &grid = summary["grid"];
  const std::string of_road = fmt::format("{:.1f} to {:.1f} m", m(line["width_min_m"]),
                                          m(line["width_max_m"])),
                    of_all = fmt::format("{:.1f} to {:.1f} m", m(grid["width_min_m"]),
                                         m(grid["width_max_m"]));
  EXPECT_THAT(built.out, HasSubstr(of_road + " wide, with kerbs and run-off " + of_all));
  EXPECT_EQ(fact(report, "Width of the road"),
            fmt::format("{:.1f} m ({})", m(line["width_median_m"]), of_road));
  const std::string width = fmt::format("{:.1f} m ({})", m(grid["width_median_m"]), of_all);
  EXPECT_THAT(info.out, HasSubstr(width));
  for (const char* key : {"width_min_m", "width_median_m", "width_max_m", "z_min_m", "z_max_m"})
    EXPECT_NEAR(m(of_file[key]), m(grid[key]), 1e-6) << key;

  // The largest error, and the other numbers of the comparison.
  const Json& validation = summary["validation"];
  const double largest_m = m(validation["z_error_m"]["max"]);
  double rough_m = 0.0;
  for (const Json& place : validation["rough_places"])
    rough_m = std::max(rough_m, m(place["largest_error_m"]));
  EXPECT_EQ(rough_m, largest_m) << "the demo has rough places, and the largest error is there";
  EXPECT_THAT(built.out,
              HasSubstr(fmt::format("99 % within {:.2f} mm, the largest error {:.2f} mm",
                                    1e3 * m(validation["z_error_m"]["p99"]), 1e3 * largest_m)));
  for (const Json* r : reports) {
    EXPECT_EQ(fact(*r, "Width of all that has a height"), width);
    EXPECT_EQ(fact(*r, "z"),
              fmt::format("{:.3f} to {:.3f} m", m(grid["z_min_m"]), m(grid["z_max_m"])));
    EXPECT_EQ(fact(*r, "Largest error against the mesh"),
              fmt::format("{:.2f} mm", 1e3 * largest_m));
    const Json& mesh = (*r)["comparisons"][0];
    ASSERT_EQ(mesh["key"], "mesh");
    EXPECT_EQ(mesh["points"], validation["points"]);
    for (const char* share : {"p50", "p95", "p99", "max"})
      EXPECT_NEAR(m(mesh["abs_error_m"][share]), m(validation["z_error_m"][share]), 1e-8) << share;
    EXPECT_NEAR(m(mesh["mean_m"]), m(validation["mean_error_m"]), 1e-8);
    EXPECT_NEAR(std::abs(m(mesh["worst"][0]["value_m"])), largest_m, 1e-8)
        << "the first of the worst places";
    EXPECT_NEAR(m(mesh["worst"][0]["u_m"]), m(validation["worst_u_m"]), 1e-3);
    double worst_rough_m = 0.0;
    for (const Json& place : (*r)["rough"]["places"])
      worst_rough_m = std::max(worst_rough_m, m(place["largest_error_m"]));
    EXPECT_NEAR(worst_rough_m, largest_m, 1e-8);
  }
  for (const Json* r : {&report, &report_later}) {
    double along_m = 0.0;
    for (const Json& error : (*r)["along_u"]["largest_error_mesh_m"])
      along_m = std::max(along_m, error.is_null() ? 0.0 : m(error));
    EXPECT_NEAR(along_m, largest_m, 1e-6);
  }

  // Kerbs. A report without the build finds its own, by shape, and says so.
  const Json& kerbs = summary["kerb"]["kerbs"];
  EXPECT_THAT(built.out, HasSubstr(fmt::format("  {} kerbs; ", kerbs.size())));
  for (const Json* r : {&report, &page}) {
    EXPECT_EQ(fact(*r, "Kerbs"), fmt::format("{}", kerbs.size()));
    ASSERT_EQ((*r)["kerbs"].size(), kerbs.size());
    for (std::size_t k = 0; k < kerbs.size(); ++k) {
      const Json& shown = (*r)["kerbs"][k];
      for (const char* key : {"u_begin_m", "u_end_m", "height_m"})
        EXPECT_NEAR(m(shown[key]), m(kerbs[k][key]), 1e-3) << key;
    }
  }
  EXPECT_EQ(fact(report_later, "Kerbs"),
            fmt::format("{}, by the shape of the road", report_later["kerbs"].size()));
}

TEST(Numbers, HeightsAreThoseOfTheSurfaceAndPlacesThoseOfTheHeader) {
  const Folder folder;
  write(folder / "s.obj", Stadium{}.obj());
  const Ran built = crgbuild({"build", folder / "s.obj", "-o", folder / "out", "--yaw-deg", "0",
                              "--translation-m", "500,700,310", "--no-report", "--u-step-m", "0.5",
                              "--v-step-m", "0.5"});
  ASSERT_EQ(built.code, 0) << built.err;
  const Json summary = base::parse_json<Json>(read(folder / "out/summary.json"));
  EXPECT_NEAR(summary["grid"]["z_min_m"], 309.4, 0.1);
  EXPECT_NEAR(summary["grid"]["z_max_m"], 310.6, 0.1);
  EXPECT_TRUE(summary["wgs84"].is_null());
  const Ran info = crgbuild({"info", folder / "out/s.crg"});
  EXPECT_THAT(info.out, HasSubstr("\nz        309."));
  EXPECT_THAT(info.out, HasSubstr(" to 310."));
  EXPECT_EQ(info.out.find("latitude"), std::string::npos);
  // The same road with a header that says where on the Earth it is.
  crg::Crg file = crg::read(folder / "out/s.crg");
  for (const auto& [key, value] : {std::pair{"START_LAT", 48.25},
                                   {"START_LON", 11.5},
                                   {"START_ALT", 310.0},
                                   {"END_LAT", 48.25000001},
                                   {"END_LON", 11.5}})
    crg::set_value(file.road, std::string("REFERENCE_LINE_") + key, value);
  crg::write(file, folder / "earth.crg", crg::Format::KRBI);
  const Ran earth = crgbuild({"info", folder / "earth.crg"});
  EXPECT_THAT(
      earth.out,
      HasSubstr("\nstart    latitude 48.25000000, longitude 11.50000000 deg, height 310.000 m\n"));
  EXPECT_THAT(earth.out, HasSubstr("\nend      latitude 48.25000001, longitude 11.50000000 deg\n"));
  const Json json = base::parse_json<Json>(crgbuild({"info", folder / "earth.crg", "--json"}).out);
  EXPECT_EQ(json["wgs84"]["start"]["latitude_deg"], 48.25);
  EXPECT_EQ(json["wgs84"]["start"]["height_m"], 310.0);
  EXPECT_TRUE(json["wgs84"]["end"]["height_m"].is_null());
  // Projected coordinates: the build writes that header itself.
  const Ran utm = crgbuild({"build", folder / "s.obj", "-o", folder / "utm", "--yaw-deg", "0",
                            "--translation-m", "690000,5345000,500", "--utm-zone", "32N",
                            "--no-report", "--u-step-m", "0.5", "--v-step-m", "0.5"});
  ASSERT_EQ(utm.code, 0) << utm.err;
  const Json placed = base::parse_json<Json>(read(folder / "utm/summary.json"))["wgs84"];
  EXPECT_NEAR(placed["start"]["latitude_deg"], 48.23, 0.05);
  EXPECT_NEAR(placed["start"]["longitude_deg"], 11.56, 0.05);
  EXPECT_EQ(placed, base::parse_json<Json>(
                        crgbuild({"info", folder / "utm/s.crg", "--json"}).out)["wgs84"]);
}

}  // namespace numbers_agree_test
}  // namespace cli
