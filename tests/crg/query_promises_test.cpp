// What every query promises: no allocation, no exceptions, and one Surface for many threads.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>
#include <thread>
#include <vector>

#include "crg/patches.h"
#include "crg/surface.h"
#include "roads.h"

namespace {
thread_local std::size_t allocations = 0;
}

[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size != 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size != 0 ? size : 1);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const std::size_t step = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(step, (size + step - 1) / step * step)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace crg {
namespace query_promises_test {

Surface road(Interpolation interpolation = Interpolation::Bilinear) {
  const ReferenceLine line = test::circuit(1501, 40.0, 0.2, 3);
  Crg crg = make_crg(
      line, test::grid_of(line, -4.0, 4.0, 17, [](double u, double v) { return std::sin(u) * v; }));
  crg.grid.at(40, 3) = NAN;
  return Surface(std::move(crg), {.interpolation = interpolation});
}

double ask_everything(const Surface& surface, int from) {
  Cursor cursor;
  double sum = 0.0;
  std::vector<float> dz(400);
  std::vector<Point2> points(8);
  std::vector<Sample> samples(8);
  std::vector<Cursor> cursors(8);
  std::vector<double> heights(8);
  const std::size_t before = allocations;
  for (int k = from; k < from + 300; ++k) {
    const double x = 55.0 * std::cos(0.7 * k), y = 55.0 * std::sin(0.71 * k);
    const Sample sample = surface.at_xy(x, y, cursor);
    if (sample.valid) sum += sample.z_m + sample.dzdx;
    const UV uv = surface.uv_of_xy(x + 1.0, y, cursor);
    const double z = surface.z_at_uv(uv.u_m, uv.v_m);
    if (!std::isnan(z)) sum += z;
    sum += surface.at_uv(0.1 * k, 1.0).heading_rad + surface.xy_of_uv(-k, 20.0).x_m;
    const double base = surface.strip({.x_m = x, .y_m = y}, dz, cursor);
    if (!std::isnan(dz[0])) sum += base + static_cast<double>(dz[0]);
    for (Point2& point : points) point = {x, y};
    surface.at_xy(points, samples, cursor);
    surface.z_at_xy(points, cursors, heights);
    if (!std::isnan(heights[k % 8])) sum += heights[k % 8];
  }
  EXPECT_EQ(allocations, before);
  return sum;
}

TEST(QueryPromises, NothingIsAllocated) {
  ask_everything(road(), 0);
  ask_everything(road(Interpolation::Smooth), 0);
  const std::size_t before = allocations;
  std::vector<int> seen(1);
  EXPECT_GT(allocations, before) << "allocations are not counted";
}

TEST(QueryPromises, NothingThrows) {
  using S = const Surface;
  static_assert(noexcept(std::declval<S>().z_at_uv(0.0, 0.0)));
  static_assert(noexcept(std::declval<S>().xy_of_uv(0.0, 0.0)));
  static_assert(noexcept(std::declval<S>().uv_of_xy(0.0, 0.0, std::declval<Cursor&>())));
  static_assert(noexcept(std::declval<S>().z_at_xy(0.0, 0.0, std::declval<Cursor&>())));
  static_assert(noexcept(std::declval<S>().at_xy(0.0, 0.0, std::declval<Cursor&>())));
  static_assert(noexcept(std::declval<S>().z_at_xy(std::span<const Point2>(), std::span<Cursor>(),
                                                   std::span<double>())));
  static_assert(noexcept(std::declval<S>().at_uv(0.0, 0.0)));
  static_assert(noexcept(std::declval<S>().strip({}, {}, std::declval<Cursor&>())));
}

// Run under ThreadSanitizer (preset tsan), this is the proof that queries share nothing.
TEST(QueryPromises, ThreadsShareASurface) {
  const Surface surface = road();
  const double alone[2] = {ask_everything(surface, 0), ask_everything(surface, 1000)};
  std::atomic<int> agreed = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      if (ask_everything(surface, t % 2 == 0 ? 0 : 1000) == alone[t % 2]) ++agreed;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(agreed, 4);
}

// The same for all that a Surface may carry: friction, patches, smooth heights, contact strips.
TEST(QueryPromises, ThreadsShareFrictionPatchesAndStrips) {
  const ReferenceLine line = test::line_along(801, 0.1, [](double) { return 0.01; });
  const Crg base = make_crg(line, test::grid_of(line, -4.0, 4.0, 41, [](double u, double v) {
                              return 0.1 * std::sin(u) * v;
                            }));
  const Crg grip = make_crg(line, test::grid_of(line, -4.0, 4.0, 41, [](double u, double) {
                              return 0.8 + 0.1 * std::sin(u);
                            }));
  const ReferenceLine short_line = test::line_along(
      61, 0.05, [](double) { return 0.0; }, 20.0, 2.0, 0.3);
  const Crg kerb = make_crg(short_line, test::grid_of(short_line, -1.0, 1.0, 21,
                                                      [](double u, double) { return 0.05 * u; }));
  std::vector<PatchedSurface::Patch> patches;
  patches.push_back({Surface(kerb), 0.2});
  const PatchedSurface patched(Surface(base, {.friction_map = grip}), std::move(patches));
  const Surface smooth(base, {.interpolation = Interpolation::Smooth, .friction_map = grip});
  const auto ask = [&](int from) {
    double sum = 0.0;
    Cursor on_patched, on_smooth, for_strip;
    std::vector<float> dz(400);
    for (int k = from; k < from + 400; ++k) {
      const double x = 0.1 * std::fmod(3.7 * k, 300.0), y = 2.0 * std::sin(0.05 * k);
      const Sample a = patched.at_xy(x, y, on_patched), b = smooth.at_xy(x, y, on_smooth);
      if (a.valid) sum += a.z_m + a.friction + a.dzdy;
      if (b.valid) sum += b.z_m + b.friction;
      smooth.strip({.x_m = x, .y_m = y, .ahead = {std::cos(0.01 * k), std::sin(0.01 * k)}}, dz,
                   for_strip);
      if (!std::isnan(dz[k % 400])) sum += dz[k % 400];
    }
    return sum;
  };
  const double alone[2] = {ask(0), ask(250)};
  EXPECT_NE(alone[0], alone[1]);
  std::atomic<int> agreed = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 6; ++t)
    threads.emplace_back([&, t] { agreed += ask(t % 2 == 0 ? 0 : 250) == alone[t % 2] ? 1 : 0; });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(agreed, 6);
}

}  // namespace query_promises_test
}  // namespace crg
