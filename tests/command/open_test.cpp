// A log is looked at before anything of it is mapped.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace open_test {

using cli::Folder;
using support::run_tool, support::ToolRun;
using ::testing::HasSubstr;
using ::testing::Not;

/// 60 rows at 20 Hz: a speed in km/h, a column that is dead, one of words.
std::string log_text() {
  std::string out = "Time,Speed,Dead,Mode\ns,km/h,g,\n";
  for (int i = 0; i < 60; ++i) out += fmt::format("{},{},0.5,race\n", 0.05 * i, 100 + i % 7);
  return out;
}

TEST(Open, ListsWhatIsThere) {
  const Folder folder;
  cli::write(folder / "log.csv", log_text());
  const ToolRun ran = run_tool(places::kerbstone(), {"open", folder / "log.csv", "--json"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto channels = base::parse_json<nlohmann::json>(ran.out)["channels"];
  ASSERT_EQ(channels.size(), 4u);
  EXPECT_EQ(channels[1]["unit"], "km/h");
  EXPECT_NEAR(channels[1]["rate_hz"].get<double>(), 20, 1e-6);
  EXPECT_EQ(channels[1]["least"], 100);
  EXPECT_EQ(channels[1]["greatest"], 106);
  EXPECT_EQ(channels[1]["dead"], false);
  EXPECT_EQ(channels[2]["dead"], true);
  EXPECT_EQ(channels[3]["words"], 60);
  EXPECT_EQ(channels[3]["samples"], 0);
}

TEST(Open, UnitsInNamesAndClocksThatGoBackAreSaid) {
  const Folder folder;
  cli::write(folder / "log.csv",
             "Time,RPM [rpm],CLT (°C),Dwell (coil)\n0.0,900,80,1\n0.1,910,80,1\n0.05,920,81,1\n");
  const ToolRun ran = run_tool(places::kerbstone(), {"open", folder / "log.csv", "--json"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto json = base::parse_json<nlohmann::json>(ran.out);
  EXPECT_EQ(json["channels"][1]["unit"], "rpm");
  EXPECT_EQ(json["channels"][2]["unit"], "°C");
  EXPECT_EQ(json["channels"][3]["unit"], "");
  EXPECT_EQ(json["notes"].back(), "rows that are earlier than the row before: 1");
}

TEST(Open, WritesAPageMcapAndCsv) {
  const Folder folder;
  cli::write(folder / "log.csv", log_text());
  const auto written = [&](const std::string& name) {
    const ToolRun ran =
        run_tool(places::kerbstone(), {"open", folder / "log.csv", "-o", folder / name});
    EXPECT_EQ(ran.code, 0) << ran.err;
    return folder / name;
  };
  const std::string page = cli::read(written("log.html"));
  EXPECT_THAT(page, HasSubstr("<svg"));
  EXPECT_THAT(page, HasSubstr("km/h"));
  for (const char* name : {"log.mcap", "copy.csv"}) {
    const auto channels = base::parse_json<nlohmann::json>(
        run_tool(places::kerbstone(), {"open", written(name), "--json"}).out)["channels"];
    const auto speed = std::find_if(channels.begin(), channels.end(), [](const auto& channel) {
      return channel["name"].template get<std::string>().starts_with("Speed");
    });
    ASSERT_NE(speed, channels.end()) << name;
    EXPECT_EQ((*speed)["samples"], 60) << name;
    EXPECT_EQ((*speed)["greatest"], 106) << name;
  }
}

TEST(Open, RefusesWhatItCannotDo) {
  const Folder folder;
  cli::write(folder / "log.csv", log_text());
  const auto said = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"open", folder / "log.csv"};
    words.insert(words.end(), more.begin(), more.end());
    const ToolRun ran = run_tool(places::kerbstone(), words);
    EXPECT_EQ(ran.code, 1);
    return ran.err;
  };
  EXPECT_THAT(said({"-o", folder / "log.csv"}), HasSubstr("is the log, and -o would overwrite it"));
  EXPECT_EQ(cli::read(folder / "log.csv"), log_text());
  EXPECT_THAT(said({"-o", folder / "log.pdf"}), HasSubstr("ends in .html, .mcap or .csv"));
  EXPECT_THAT(said({"-o", folder / "p.html", "--channel", "Sped"}), HasSubstr("no channel 'Sped'"));
  EXPECT_FALSE(std::filesystem::exists(folder / "p.html"));
}

TEST(Open, NamesWithCommasAndMomentsSince1970AreReadBack) {
  const Folder folder;
  std::string text = "rosbagTimestamp;Temp, front\n";
  for (int i = 0; i < 60; ++i)
    text += fmt::format("{};{}\n", 1700000000000000000 + i * 100000000LL, i);
  cli::write(folder / "log.csv", text);
  for (const char* name : {"copy.csv", "copy.mcap"}) {
    const ToolRun ran =
        run_tool(places::kerbstone(), {"open", folder / "log.csv", "-o", folder / name});
    ASSERT_EQ(ran.code, 0) << ran.err;
    const auto channels = base::parse_json<nlohmann::json>(
        run_tool(places::kerbstone(), {"open", folder / name, "--json"}).out)["channels"];
    ASSERT_EQ(channels.size(), 2u) << name;
    EXPECT_EQ(channels[1]["name"], "Temp, front");
    EXPECT_NEAR(channels[1]["rate_hz"].get<double>(), 10, 1e-3) << name;
  }
  cli::write(folder / "bare.csv", "time_s,a\n0,1\n,2\n1,3\n");
  const ToolRun bare =
      run_tool(places::kerbstone(), {"open", folder / "bare.csv", "-o", folder / "b.mcap"});
  EXPECT_EQ(bare.code, 1);
  EXPECT_THAT(bare.err, HasSubstr("row 2 has no moment"));
}

TEST(Open, OfADraftThatNothingCanUseTheMapSaysSo) {
  const Folder folder;
  cli::write(folder / "log.csv", log_text());
  const ToolRun good =
      run_tool(places::crgexplain(), {"map", folder / "log.csv", "-o", folder / "m.yaml"});
  EXPECT_EQ(good.code, 0) << good.err;
  cli::write(folder / "short.csv", log_text().substr(0, 100));
  const ToolRun ran = run_tool(places::crgexplain(),
                               {"map", folder / "short.csv", "--list", "-o", folder / "s.yaml"});
  EXPECT_EQ(ran.code, 3) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("a log of at least 50 is wanted"));
  EXPECT_THAT(ran.out, HasSubstr("vx_mps"));
  EXPECT_THAT(cli::read(folder / "s.yaml"), HasSubstr("vx_mps"));
}

}  // namespace open_test
