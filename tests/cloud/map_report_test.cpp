// The page of a refined road tells what was mended and noticed; that it differs from its base is no
// remark.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/json_text.h"
#include "base/random.h"
#include "cloud/refine.h"
#include "nlohmann/json.hpp"
#include "support/temporary_folder.h"

namespace cloud {
namespace map_report_test {

using ::testing::HasSubstr;

TEST(MapReport, SaysWhatWasNoticedAndNotThatItDiffersFromItsBase) {
  const support::TemporaryFolder folder;
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 0.5;
  for (double v = -3.0; v <= 3.0; v += 0.5) grid.v_m.push_back(v);
  for (double u = 0.0; u <= 40.0; u += 0.5) {
    line.x_m.push_back(u), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
    grid.z_m.insert(grid.z_m.end(), grid.v_m.size(), 0.0f);
  }
  crg::write(crg::make_crg(line, grid), folder.path("road.crg"), crg::Format::KRBI);
  std::string text = "x,y,z,classification\n";
  base::Random random(1);
  for (double x = 0.0; x < 40.0; x += 0.12)
    for (double y = -3.0; y < 3.0; y += 0.12)
      text += fmt::format("{},{},{},{}\n", x, y, 0.05 + 0.004 * (random.uniform() - 0.5),
                          random.uniform() < 0.01 ? 7 : 2);
  RefineRequest request;
  request.scans = {folder.file("scan.csv", text)}, request.base = folder.path("road.crg");
  request.frame = "map", request.correct_drift = false, request.output_dir = folder.path("out");
  EXPECT_TRUE(refine(request).facts.faults.empty());
  const auto report = base::parse_json<nlohmann::json>(folder.read("out/report.json"));
  EXPECT_EQ(report["verdict"], "usable");
  EXPECT_TRUE(report["findings"].empty()) << report["findings"];
  EXPECT_THAT(report["extra"][0]["sentences"].dump(), HasSubstr("marked as noise"));
}

}  // namespace map_report_test
}  // namespace cloud
