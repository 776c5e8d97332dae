#include "numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/json_text.h"
#include "crg/file.h"
#include "support/temporary_folder.h"

namespace numbers_test {

struct Unpacked {
  nlohmann::json head;
  std::map<std::string, std::vector<double>> of;
};

Unpacked unpack(const std::string& bytes) {
  Unpacked out;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data(), 4);
  out.head = base::parse_json<nlohmann::json>(bytes.substr(4, length));
  std::size_t at = 4 + length;
  for (const nlohmann::json& array : out.head["arrays"]) {
    EXPECT_EQ(at % 8, 0U);
    for (std::size_t k = 0; k < array["count"]; ++k) {
      double value = 0.0;
      float single = 0.0F;
      if (array["type"] == "f32") {
        std::memcpy(&single, bytes.data() + at, sizeof single);
        value = static_cast<double>(single);
      } else {
        std::memcpy(&value, bytes.data() + at, sizeof value);
      }
      at += array["type"] == "f32" ? 4 : 8;
      out.of[array["name"]].push_back(value);
    }
    at = (at + 7) / 8 * 8;
  }
  EXPECT_EQ(at, bytes.size());
  return out;
}

/// A figure of eight of two circles of 50 m round (50, 0) and (-50, 0): the crossing lies in the
/// origin, the road rises by 1 cm per metre of v to the left and is 6 m wide.
crg::Surface figure_of_eight(const support::TemporaryFolder& folder) {
  crg::ReferenceLine line;
  crg::Grid grid;
  grid.v_m = {-5.0, -3.0, 0.0, 3.0, 5.0};
  const double half = 2.0 * M_PI * 50.0;
  const std::size_t steps = 1256;  // the circles meet at a node
  grid.u_step_m = 2.0 * half / static_cast<double>(steps);
  double x = 0.0, y = 0.0, heading = M_PI / 2.0;
  line.u_step_m = grid.u_step_m;
  for (std::size_t i = 0; i <= steps; ++i) {
    line.x_m.push_back(x);
    line.y_m.push_back(y);
    line.heading_rad.push_back(heading);
    const float hole = std::nanf("");
    for (const float z : {hole, -0.03F, 0.0F, 0.03F, hole}) grid.z_m.push_back(z);
    // Right round (50, 0), then left round (-50, 0): both through the origin, northwards.
    const double turn = (i < steps / 2 ? -1.0 : 1.0) / 50.0;
    heading += 0.5 * turn * grid.u_step_m;
    x += grid.u_step_m * std::cos(heading);
    y += grid.u_step_m * std::sin(heading);
    heading += 0.5 * turn * grid.u_step_m;
  }
  const std::string path = folder.path("eight.crg");
  crg::write(crg::make_crg(line, grid), path, crg::Format::KRBI);
  return crg::Surface(crg::read(path));
}

TEST(PackedRoad, IsTheRoadWithTheEdgesOfWhatHasAHeight) {
  support::TemporaryFolder folder;
  const Unpacked road = unpack(view::packed_road(figure_of_eight(folder)));
  EXPECT_EQ(road.head["columns"], 5);
  EXPECT_NEAR(road.head["length_m"].get<double>(), 4.0 * M_PI * 50.0, 0.6);
  // A quarter of the first circle on, the line is at its top (50, 50), the left edge 3 m outside.
  const auto quarter = static_cast<std::size_t>(std::lround(0.5 * M_PI * 50.0 / 0.5));
  EXPECT_NEAR(road.of.at("x_m")[quarter], 50.0, 0.5);
  EXPECT_NEAR(road.of.at("y_m")[quarter], 50.0, 0.1);
  EXPECT_NEAR(road.of.at("left_y_m")[quarter], 53.0, 0.1);
  EXPECT_NEAR(road.of.at("right_y_m")[quarter], 47.0, 0.1);
  EXPECT_TRUE(std::isnan(road.of.at("z_m")[5 * quarter]));
  EXPECT_NEAR(road.of.at("z_m")[5 * quarter + 3], 0.03, 1e-6);
}

TEST(PackedPlaces, GoOnAlongTheirOwnLegWhereTheRoadTouchesItself) {
  support::TemporaryFolder folder;
  const crg::Surface road = figure_of_eight(folder);
  recording::Log log;
  log.channels.resize(2);
  log.channels[0].name = "x";
  log.channels[1].name = "y";
  // A lap on the middle of the line, a place every 2 m, as the two circles say.
  const double half = 2.0 * M_PI * 50.0;
  std::vector<double> truth;
  for (double s = 1.0; s < 2.0 * half - 1.0; s += 2.0) {
    const double angle = (s < half ? s : s - half) / 50.0;
    log.channels[0].values.push_back((s < half ? 50.0 : -50.0) * (1.0 - std::cos(angle)));
    log.channels[1].values.push_back(50.0 * std::sin(angle));
    truth.push_back(s);
  }
  const Unpacked places = unpack(view::packed_places(log, "x", "y", road));
  std::size_t told = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double u = places.of.at("u_m")[k];
    if (std::isnan(u)) continue;
    ++told;
    // Near the begin and the end either end of the line is right.
    if (truth[k] > 5.0 && truth[k] < 2.0 * half - 5.0) {
      EXPECT_NEAR(u, truth[k], 0.05) << truth[k];
    }
  }
  EXPECT_GT(told, truth.size() * 8 / 10);
  EXPECT_THROW(view::packed_places(log, "x", "z", road), base::Error);
}

TEST(PackedPlaces, FarFromTheRoadAreNone) {
  support::TemporaryFolder folder;
  recording::Log log;
  log.channels.resize(2);
  log.channels[0].name = "x";
  log.channels[1].name = "y";
  log.channels[0].values = {1000.0, std::nan(""), 50.0};
  log.channels[1].values = {1000.0, 0.0, 50.0};
  const Unpacked places = unpack(view::packed_places(log, "x", "y", figure_of_eight(folder)));
  EXPECT_THAT(places.of.at("u_m"),
              ::testing::ElementsAre(::testing::IsNan(), ::testing::IsNan(),
                                     ::testing::DoubleNear(0.5 * M_PI * 50.0, 0.6)));
}

/// A straight road along x from x_begin_m on, 100 m long; beside and beyond it is none.
crg::Surface straight(const support::TemporaryFolder& folder, const std::string& name,
                      double x_begin_m, double half_width_m, double banking) {
  crg::ReferenceLine line;
  crg::Grid grid;
  for (double v = -half_width_m; v < half_width_m + 0.1; v += 1.0) grid.v_m.push_back(v);
  grid.u_step_m = line.u_step_m = 0.5;
  for (int i = 0; i <= 200; ++i) {
    line.x_m.push_back(x_begin_m + 0.5 * i);
    line.y_m.push_back(0.0);
    line.heading_rad.push_back(0.0);
    for (const double v : grid.v_m)
      grid.z_m.push_back(static_cast<float>(0.02 * line.x_m.back() + banking * v));
  }
  crg::Crg file = crg::make_crg(line, std::move(grid));
  crg::set_value(file.options, "BORDER_MODE_U", 0.0);
  crg::set_value(file.options, "BORDER_MODE_V", 0.0);
  crg::write(file, folder.path(name), crg::Format::KRBI);
  return crg::Surface(crg::read(folder.path(name)));
}

TEST(PlaceJson, SaysWhereOnTheRoadAPlaceIs) {
  support::TemporaryFolder folder;
  const crg::Surface road = straight(folder, "road.crg", 10.0, 4.0, 0.0);
  const auto place = base::parse_json<nlohmann::json>(view::place_json(road, 32.25, -1.5));
  EXPECT_NEAR(place["u_m"].get<double>(), 22.25, 1e-6);
  EXPECT_NEAR(place["v_m"].get<double>(), -1.5, 1e-6);
  EXPECT_TRUE(
      base::parse_json<nlohmann::json>(view::place_json(road, 30.0, 80.0))["u_m"].is_null());
}

TEST(PackedProfile, GoesStraightAcrossTheRoadAndHasNothingBesideIt) {
  support::TemporaryFolder folder;
  const crg::Surface road = straight(folder, "road.crg", 10.0, 4.0, 0.01);
  // Aslant from 6 m to the right to 6 m to the left, 15 m long; the road reaches 4 m to each side.
  const Unpacked profile = unpack(view::packed_profile(road, {40.0, -6.0}, {49.0, 6.0}));
  const std::vector<double>&s = profile.of.at("s_m"), &z = profile.of.at("z_m");
  ASSERT_EQ(s.size(), 751U);
  EXPECT_NEAR(s.back(), 15.0, 1e-9);
  for (std::size_t k = 0; k < s.size(); ++k) {
    const double x = 40.0 + 0.6 * s[k], y = -6.0 + 0.8 * s[k];
    if (std::abs(y) > 4.001) {
      EXPECT_TRUE(std::isnan(z[k])) << y;
    } else if (std::abs(y) < 3.999) {
      EXPECT_NEAR(z[k], 0.02 * x + 0.01 * y, 1e-5);
      EXPECT_NEAR(profile.of.at("u_m")[k], x - 10.0, 1e-6);
      EXPECT_NEAR(profile.of.at("v_m")[k], y, 1e-6);
    }
  }
  EXPECT_EQ(unpack(view::packed_profile(road, {0.0, 0.0}, {5000.0, 0.0})).of.at("s_m").size(),
            20'000U);
  EXPECT_THROW(view::packed_profile(road, {40.0, 0.0}, {40.0, 0.0}), base::Error);
}

TEST(PackedDifference, ComparesHeightsAtTheSamePlacesOfTheMap) {
  support::TemporaryFolder folder;
  const crg::Surface road = straight(folder, "road.crg", 10.0, 4.0, 0.003),
                     other = straight(folder, "other.crg", 30.0, 2.0, 0.001);
  const Unpacked part = unpack(view::packed_difference(road, other, 15.0, 40.0));
  EXPECT_EQ(part.head["rows"], 51);
  EXPECT_EQ(part.head["columns"], 9);
  for (std::size_t i = 0; i < 51; ++i) {
    const double u = part.of.at("u_m")[i];
    EXPECT_NEAR(u, 15.0 + 0.5 * static_cast<double>(i), 1e-9);
    for (std::size_t j = 0; j < 9; ++j) {
      const double v = static_cast<double>(j) - 4.0, z = part.of.at("z_m")[9 * i + j],
                   there = part.of.at("against_m")[9 * i + j];
      EXPECT_NEAR(z, 0.02 * (10.0 + u) + 0.003 * v, 1e-5);
      // The other one begins at u = 20 of this one and is half as wide.
      if (u < 19.9 || std::abs(v) > 2.1) {
        EXPECT_TRUE(std::isnan(there)) << u << " " << v;
      } else if (u > 20.1 && std::abs(v) < 1.9) {
        EXPECT_NEAR(z - there, 0.002 * v, 1e-5) << u << " " << v;
      }
    }
  }
  EXPECT_THROW(view::packed_difference(road, other, 200.0, 300.0), base::Error);
  // A road that crosses itself has no other leg for a rival: against itself nothing differs.
  const crg::Surface eight = figure_of_eight(folder);
  const Unpacked self = unpack(view::packed_difference(eight, eight, -1e9, 1e9));
  EXPECT_THAT(self.of.at("against_m"),
              ::testing::Pointwise(::testing::NanSensitiveDoubleEq(), self.of.at("z_m")));
  // Over the start: the end first.
  const Unpacked over = unpack(view::packed_difference(road, other, 99.0, 1.0));
  EXPECT_THAT(over.of.at("u_m"), ::testing::ElementsAre(99.0, 99.5, 100.0, 0.0, 0.5, 1.0));
}

}  // namespace numbers_test
