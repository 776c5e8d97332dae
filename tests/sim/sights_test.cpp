#include "sim/sights.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "base/json_text.h"

namespace sights_test {

using nlohmann::json;

template <class Value>
Value take(std::string& bytes) {
  Value value{};
  EXPECT_GE(bytes.size(), sizeof value);
  std::memcpy(&value, bytes.data(), sizeof value);
  bytes.erase(0, sizeof value);
  return value;
}

sim::Scan scan_of(std::size_t points) {
  sim::Scan scan{2, "li\"dar", 1.25, {}, {1.5, 0, 0.5}, {0, 0.25, 0}};
  for (std::size_t k = 0; k < points; ++k) {
    const auto x_m = static_cast<float>(k + 1) / 3.0f;
    scan.points.push_back({x_m, -x_m, 1e-7f * x_m, 0.1f});
  }
  return scan;
}

TEST(Sights, AScanIsSplitAndComesTogetherInBothForms) {
  const sim::Scan scan = scan_of(9000);
  std::vector<sim::ScanPoint> read;
  std::size_t part = 0;
  const auto texts = sim::write_sight(scan, false, 60'000);
  for (const std::string& text : texts) {
    EXPECT_LE(text.size(), 60'000u);
    const json said = base::parse_json<json>(text);
    EXPECT_EQ(said.at("scan"), "li\"dar");
    EXPECT_EQ(said.at("time_s"), 1.25);
    EXPECT_EQ(said.at("at_m"), base::parse_json<json>("[1.5, 0, 0.5]"));
    EXPECT_EQ(said.at("turned_rad"), base::parse_json<json>("[0, 0.25, 0]"));
    EXPECT_EQ(said.at("part"), part++);
    EXPECT_EQ(said.at("parts"), texts.size());
    for (const json& p : said.at("points")) read.push_back({p.at(0), p.at(1), p.at(2), p.at(3)});
  }
  EXPECT_GT(texts.size(), 5u);
  ASSERT_EQ(read.size(), scan.points.size());
  EXPECT_EQ(std::memcmp(read.data(), scan.points.data(), read.size() * sizeof read[0]), 0)
      << "the same bits";

  read.clear();
  part = 0;
  const auto datagrams = sim::write_sight(scan, true, 60'000);
  EXPECT_EQ(datagrams.size(), 3u);
  for (std::string bytes : datagrams) {
    EXPECT_LE(bytes.size(), 60'000u);
    EXPECT_EQ(bytes.substr(0, 4), "KSS1");
    bytes.erase(0, 4);
    EXPECT_EQ(take<std::uint32_t>(bytes), 2u);
    EXPECT_EQ(take<std::uint32_t>(bytes), part++);
    EXPECT_EQ(take<std::uint32_t>(bytes), 3u);
    const auto count = take<std::uint32_t>(bytes);
    EXPECT_EQ(take<double>(bytes), 1.25);
    ASSERT_EQ(bytes.size(), 16 * count);
    while (!bytes.empty()) read.push_back(take<sim::ScanPoint>(bytes));
  }
  ASSERT_EQ(read.size(), scan.points.size());
  EXPECT_EQ(std::memcmp(read.data(), scan.points.data(), read.size() * sizeof read[0]), 0);

  // That nothing was seen is told too.
  EXPECT_EQ(base::parse_json<json>(sim::write_sight(scan_of(0), false, 60'000).at(0)).at("points"),
            json::array());
  EXPECT_EQ(sim::write_sight(scan_of(0), true, 60'000).at(0).size(), 28u);
}

TEST(Sights, EdgesAndPlansAreOneDatagram) {
  const sim::Edges edges{1, "camera", 0.5, {{1.5f, 2.0f, -0.5f}}, {{3.0f, -4.0f, 0.1f}, {5, 6, 7}}};
  EXPECT_EQ(
      base::parse_json<json>(sim::write_sight(edges, false, 60'000).at(0)),
      base::parse_json<json>(
          R"({"edges": "camera", "time_s": 0.5, "left": [[1.5, 2, -0.5]], "right": [[3, -4, 0.1], [5, 6, 7]]})"));
  std::string bytes = sim::write_sight(edges, true, 60'000).at(0);
  ASSERT_EQ(bytes.size(), 4u + 3 * 4 + 8 + 3 * 12);
  EXPECT_EQ(bytes.substr(0, 4), "KSE1");
  bytes.erase(0, 4);
  EXPECT_EQ(take<std::uint32_t>(bytes), 1u);
  EXPECT_EQ(take<std::uint32_t>(bytes), 1u);
  EXPECT_EQ(take<std::uint32_t>(bytes), 2u);
  EXPECT_EQ(take<double>(bytes), 0.5);
  EXPECT_EQ(take<float>(bytes), 1.5f);

  const sim::Plan plan{7, 0.25, {{1.0, 2.0, 30.0}, {3.0, 4.0, 29.5}}};
  EXPECT_EQ(base::parse_json<json>(sim::write_sight(plan, false, 60'000).at(0)),
            base::parse_json<json>(
                R"({"plan": [[1, 2, 30], [3, 4, 29.5]], "sequence": 7, "time_s": 0.25})"));
  bytes = sim::write_sight(plan, true, 60'000).at(0);
  ASSERT_EQ(bytes.size(), 4u + 2 * 4 + 8 + 2 * 24);
  EXPECT_EQ(bytes.substr(0, 4), "KSP1");
  bytes.erase(0, 4);
  EXPECT_EQ(take<std::uint32_t>(bytes), 7u);
  EXPECT_EQ(take<std::uint32_t>(bytes), 2u);
}

}  // namespace sights_test
