// A Surface keeps what a file and its line say in the tables of its queries: asked for them, it
// gives back the very numbers.
#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "crg/surface.h"
#include "roads.h"

namespace crg {
namespace surface_data_test {

Crg road_of(ReferenceLine line, bool heights) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-0.05, 0.05);
  for (std::size_t i = 0; heights && i < line.size(); ++i) {
    line.z_m.push_back((i == 0 ? 80.0 : line.z_m.back()) + line.u_step_m * any(random));
    line.banking.push_back(any(random));
  }
  return make_crg(line, test::grid_of(line, -3.0, 2.0, 6,
                                      [](double u, double v) { return 0.01 * u + 0.02 * v; }));
}

ReferenceLine bend(std::size_t rows, double u_step_m) {
  return test::line_along(
      rows, u_step_m, [](double u) { return 0.01 * std::sin(u); }, 5e5, 4e6);
}

// As a file of floats holds them.
Crg in_floats(Crg crg) {
  for (std::vector<double>* channel : {&crg.heading_rad, &crg.slope, &crg.banking})
    for (double& value : *channel) value = static_cast<double>(static_cast<float>(value));
  return crg;
}

Crg with_nodes(Crg crg) {
  const ReferenceLine line = integrate_reference_line(crg);
  crg.x_m = line.x_m;
  crg.y_m = line.y_m;
  return crg;
}

Crg with_another_start(Crg crg) {
  crg.heading_rad.front() = 17.25;  // row 0 counts for nothing, and is kept
  crg.slope.front() = 1e300;        // beyond what a float holds
  return crg;
}

Crg without_channels(Crg crg) {
  crg.heading_rad.clear();
  crg.slope.clear();
  crg.banking.clear();
  return crg;
}

std::vector<std::pair<const char*, Crg>> roads() {
  const Crg open = road_of(bend(400, 0.1), true);
  return {{"closed", road_of(test::circuit(801, 20.0, 0.2, 3), true)},
          {"closed, floats", in_floats(road_of(test::circuit(801, 20.0, 0.2, 3), true))},
          {"closed, shorter than two chords", road_of(test::circuit(8, 0.1, 0.0, 3), true)},
          {"open", open},
          {"open, floats", in_floats(open)},
          {"open, flat", road_of(bend(400, 0.1), false)},
          {"open, coarse", road_of(bend(50, 3.0), true)},
          {"open, shorter than a chord", road_of(bend(4, 0.1), true)},
          {"open, two rows", road_of(bend(2, 0.1), true)},
          {"nodes", with_nodes(open)},
          {"another start", with_another_start(open)},
          {"no channels", without_channels(open)}};
}

void expect_same(const Crg& file, const Crg& want) {
  EXPECT_EQ(file.heading_rad, want.heading_rad);
  EXPECT_EQ(file.slope, want.slope);
  EXPECT_EQ(file.banking, want.banking);
  EXPECT_EQ(file.x_m, want.x_m);
  EXPECT_EQ(file.y_m, want.y_m);
  EXPECT_EQ(file.grid.z_m, want.grid.z_m);
  EXPECT_EQ(to_bytes(file, Format::KDBI), to_bytes(want, Format::KDBI));
}

void expect_same(const ReferenceLine& line, const ReferenceLine& want) {
  EXPECT_EQ(line.x_m, want.x_m);
  EXPECT_EQ(line.y_m, want.y_m);
  EXPECT_EQ(line.heading_rad, want.heading_rad);
  EXPECT_EQ(line.z_m, want.z_m);
  EXPECT_EQ(line.banking, want.banking);
  EXPECT_EQ(line.u_begin_m, want.u_begin_m);
  EXPECT_EQ(line.u_step_m, want.u_step_m);
  EXPECT_EQ(line.closed, want.closed);
}

TEST(WholeFile, IsWhatTheSurfaceWasMadeOf) {
  for (const auto& [name, crg] : roads()) {
    SCOPED_TRACE(name);
    const Surface surface(crg);
    EXPECT_EQ(surface.grid().z_m, crg.grid.z_m);
    expect_same(surface.file(), crg);
    expect_same(surface.reference_line(), integrate_reference_line(crg));
    EXPECT_EQ(surface.closed(), surface.reference_line().closed);
    EXPECT_EQ(&surface.file().grid, &surface.grid()) << "one grid";
  }
}

TEST(WholeFile, IsThereOnceHoweverManyAskAtOnce) {
  const Crg crg = road_of(test::circuit(801, 20.0, 0.2, 3), true);
  const Surface surface(crg);
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k) {
    threads.emplace_back([&] {
      Cursor cursor;
      EXPECT_TRUE(surface.at_xy(20.0, 0.0, cursor).valid) << "while others ask";
      EXPECT_EQ(surface.file().slope, crg.slope);
      EXPECT_EQ(surface.reference_line().size(), crg.heading_rad.size());
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace surface_data_test
}  // namespace crg
