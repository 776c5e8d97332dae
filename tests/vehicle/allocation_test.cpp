// Counts what the heap is asked for while the car drives. Replaces operator new of this program.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>

#include "crg/surface.h"
#include "test_car.h"

namespace {
std::atomic<long> allocations{0};
}

[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size != 0 ? size : 1);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace allocation_test {

using namespace vehicle;  // NOLINT: a test of this library

/// A straight road of `height_m` with waves of `wave_m`; as a friction map the height is the grip.
crg::Crg straight_road(double height_m, double wave_m) {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 0.25;
  for (int i = 0; i <= 2000; ++i) {
    line.x_m.push_back(0.25 * i);
    line.y_m.push_back(0.0);
    line.heading_rad.push_back(0.0);
  }
  for (int j = -8; j <= 8; ++j) grid.v_m.push_back(0.5 * j);
  for (int i = 0; i <= 2000; ++i)
    for (int j = -8; j <= 8; ++j)
      grid.z_m.push_back(static_cast<float>(height_m + wave_m * std::sin(0.5 * i)));
  return crg::make_crg(line, grid);
}

TEST(Allocation, NoneWhileTheCarDrives) {
  const CarFiles files = test_car_files();
  crg::SurfaceOptions options;
  options.friction_map = straight_road(0.9, 0.05);
  const crg::Surface surface(straight_road(0.0, 0.01), options);
  for (const Contact contact : {Contact::kSinglePoint, Contact::kFourPoint, Contact::kStrip}) {
    const Car<double> car = make_car(files, test_parameters(), default_amplitudes(), contact);
    const Road road(surface);
    StartOptions begin;
    begin.x_m = 20.0;
    begin.speed_mps = 40.0;
    begin.gear = 3;
    Simulation<double> sim = start(car, road, begin);
    Detail<double> detail;
    Controls<double> controls;
    controls.gear_command = 3;
    controls.throttle_command = 0.6;
    const long before = allocations;
    for (int i = 0; i < 5000; ++i)
      if (!step(car, sim, controls, road, {}, detail).ok()) break;
    EXPECT_EQ(allocations - before, 0);
    EXPECT_EQ(sim.discrete.step, 5000);
    EXPECT_GT(detail.wheel[0].road.u_m, 200.0);
  }
}

}  // namespace allocation_test
