#include "recording/telemetry_mcap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/error.h"
#include "recording/channels.h"
#include "recording/log_table.h"
#include "recording/recording.h"
#include "support/places.h"
#include "support/temporary_folder.h"

namespace recording {
namespace telemetry_mcap_test {

TEST(TelemetryMcap, ATableComesBackToTheBit) {
  Table table;
  std::vector<std::string> names = telemetry_channels();
  for (const char* more : {"window", "hold_n", "wake_x_m"}) names.emplace_back(more);
  for (std::size_t c = 0; c < names.size(); ++c) {
    std::vector<double> values;
    for (int i = 0; i < 300; ++i)
      values.push_back(c > 0 && (i + static_cast<int>(c)) % 17 == 0
                           ? std::numeric_limits<double>::quiet_NaN()
                           : std::exp(0.1 * static_cast<double>(c) - 3) * i / 7.0);
    table.add(names[c], values);
  }
  const Table back = parse_log_table(format_mcap(table, "# made by a test\n"), "log");
  ASSERT_EQ(back.names, table.names);
  for (std::size_t c = 0; c < names.size(); ++c)
    for (std::size_t i = 0; i < 300; ++i) {
      const double a = table.columns[c][i], b = back.columns[c][i];
      EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << names[c] << ' ' << i;
    }
}

TEST(TelemetryMcap, WantsATime) {
  Table table;
  table.add("vx_mps", {1, 2});
  EXPECT_THROW((void)format_mcap(table, ""), base::Error);
}

// The same manoeuvre as CSV, nine digits, and as MCAP, which a replay takes as it is.
TEST(TelemetryMcap, CrgdriveWritesWhereTheNameAsks) {
  const support::TemporaryFolder folder;
  const std::string car = places::source() + "/vehicles/open_wheel/vehicle.yaml";
  for (const char* name : {"drive.csv", "drive.mcap"})
    ASSERT_EQ(
        std::system((places::crgdrive() + " manoeuvre step-steer --car " + car +
                     " --stop-s 2 --quiet -o " + folder.path(name) + " > " + folder.path("said"))
                        .c_str()),
        0);
  const Table csv = read_table(folder.path("drive.csv")),
              mcap = read_log_table(folder.path("drive.mcap"));
  ASSERT_EQ(csv.names, mcap.names);
  for (std::size_t c = 0; c < csv.names.size(); ++c)
    for (std::size_t i = 0; i < csv.rows(); ++i)
      EXPECT_NEAR(mcap.columns[c][i], csv.columns[c][i], 6e-9 * std::abs(csv.columns[c][i]));
  EXPECT_EQ(read_recording(folder.path("drive.mcap"), {}).table.rows(), csv.rows());
}

}  // namespace telemetry_mcap_test
}  // namespace recording
