// Speed of height queries on closed tracks of 3 km and 22 km, 0.1 x 0.1 m, 15 m wide, beside a bare
// prefetched bilinear read of the same cells. Figures: docs/evidence.md.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "crg/roads.h"
#include "crg/strip.h"
#include "crg/surface.h"

namespace {

using namespace crg;

constexpr double kHalfWidth_m = 7.5;
constexpr std::size_t kColumns = 151;

const Surface& track(int length_km) {
  static std::unique_ptr<Surface> surfaces[2];
  std::unique_ptr<Surface>& surface = surfaces[length_km == 3 ? 0 : 1];
  if (!surface) {
    const std::size_t rows = static_cast<std::size_t>(length_km) * 10000 + 1;
    ReferenceLine line =
        test::circuit(rows, length_km == 3 ? 450.0 : 3300.0, 0.12, length_km == 3 ? 5 : 17);
    for (std::size_t i = 0; i < rows; ++i) {
      const double t = 2.0 * M_PI * static_cast<double>(i) / static_cast<double>(rows - 1);
      line.z_m.push_back(200.0 + 10.0 * std::sin(2.0 * t));
      line.banking.push_back(0.04 * std::sin(5.0 * t));
    }
    const Crg crg = make_crg(
        line, test::grid_of(line, -kHalfWidth_m, kHalfWidth_m, kColumns, [](double u, double v) {
          return 0.01 * std::sin(7.0 * u) + 0.02 * std::cos(0.9 * v);
        }));
    // As from a file.
    surface = std::make_unique<Surface>(read_bytes(to_bytes(crg, Format::KRBI), "track.crg"));
  }
  return *surface;
}

// Positions of four wheels at 60 m/s, a set every millisecond, for a whole lap; the car wanders
// slowly from side to side.
const std::vector<Point2>& wheels(int length_km) {
  static std::vector<Point2> points[2];
  std::vector<Point2>& result = points[length_km == 3 ? 0 : 1];
  if (result.empty()) {
    const Surface& surface = track(length_km);
    const ReferenceLine& line = surface.reference_line();
    const double length = line.u_step_m * static_cast<double>(line.size() - 1);
    for (double u = 2.0; u < length - 2.0; u += 0.06) {
      const double v = 4.0 * std::sin(u / 90.0);
      for (const double du : {1.4, -1.4}) {
        for (const double dv : {0.8, -0.8}) result.push_back(surface.xy_of_uv(u + du, v + dv));
      }
    }
  }
  return result;
}

void count(benchmark::State& state, std::size_t per_iteration) {
  state.counters["M/s"] = benchmark::Counter(
      1e-6 * static_cast<double>(per_iteration) * static_cast<double>(state.iterations()),
      benchmark::Counter::kIsRate);
}

// The same cells read with their places known beforehand: what memory and interpolation cost.
void bare_bilinear(benchmark::State& state) {
  const int km = static_cast<int>(state.range(0));
  const Surface& surface = track(km);
  const Grid& grid = surface.grid();
  struct Cell {
    std::uint32_t node;
    float fu, fv;
  };
  std::vector<Cell> cells;
  Cursor cursor[4];
  std::size_t k = 0;
  for (const Point2& p : wheels(km)) {
    const UV uv = surface.uv_of_xy(p.x_m, p.y_m, cursor[k++ % 4]);
    const double row = uv.u_m / grid.u_step_m, column = (uv.v_m + kHalfWidth_m) / 0.1;
    cells.push_back({static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(kColumns) +
                         static_cast<std::uint32_t>(column),
                     static_cast<float>(row - std::floor(row)),
                     static_cast<float>(column - std::floor(column))});
  }
  double sum = 0.0;
  for (auto _ : state) {
    for (const Cell& cell : cells) {
      const float* z = grid.z_m.data() + cell.node;
      __builtin_prefetch(z + 12 * kColumns);
      const double low = z[0] + static_cast<double>(cell.fv) * (static_cast<double>(z[1]) - z[0]);
      const double high = z[kColumns] + static_cast<double>(cell.fv) *
                                            (static_cast<double>(z[kColumns + 1]) - z[kColumns]);
      sum += low + static_cast<double>(cell.fu) * (high - low);
    }
  }
  benchmark::DoNotOptimize(sum);
  count(state, cells.size());
}

template <typename Query>
void driving(benchmark::State& state, Query query) {
  const int km = static_cast<int>(state.range(0));
  const Surface& surface = track(km);
  const std::vector<Point2>& points = wheels(km);
  double sum = 0.0;
  for (auto _ : state) {
    Cursor cursor[4];
    for (std::size_t k = 0; k < points.size(); k += 4) {
      for (std::size_t w = 0; w < 4; ++w) sum += query(surface, points[k + w], cursor[w]);
    }
  }
  benchmark::DoNotOptimize(sum);
  count(state, points.size());
}

void z_driving(benchmark::State& state) {
  driving(state, [](const Surface& surface, Point2 p, Cursor& cursor) {
    return surface.z_at_xy(p.x_m, p.y_m, cursor);
  });
}
// One call for the four wheels.
void z_of_car_driving(benchmark::State& state) {
  const int km = static_cast<int>(state.range(0));
  const Surface& surface = track(km);
  const std::vector<Point2>& points = wheels(km);
  double sum = 0.0;
  for (auto _ : state) {
    Cursor cursors[4];
    double z_m[4];
    for (std::size_t k = 0; k < points.size(); k += 4) {
      surface.z_at_xy(std::span(points).subspan(k, 4), cursors, z_m);
      sum += z_m[0] + z_m[1] + z_m[2] + z_m[3];
    }
  }
  benchmark::DoNotOptimize(sum);
  count(state, points.size());
}
void uv_driving(benchmark::State& state) {
  driving(state, [](const Surface& surface, Point2 p, Cursor& cursor) {
    return surface.uv_of_xy(p.x_m, p.y_m, cursor).u_m;
  });
}
void everything_driving(benchmark::State& state) {
  driving(state, [](const Surface& surface, Point2 p, Cursor& cursor) {
    const Sample sample = surface.at_xy(p.x_m, p.y_m, cursor);
    return sample.z_m + sample.dzdx + sample.dzdy + sample.heading_rad;
  });
}
// Everything, one wheel's lap in one call.
void everything_batch_driving(benchmark::State& state) {
  const int km = static_cast<int>(state.range(0));
  const Surface& surface = track(km);
  std::vector<Point2> points;
  for (std::size_t k = 0; k < wheels(km).size(); k += 4) points.push_back(wheels(km)[k]);
  std::vector<Sample> samples(points.size());
  for (auto _ : state) {
    Cursor cursor;
    surface.at_xy(points, samples, cursor);
    benchmark::DoNotOptimize(samples.data());
  }
  count(state, points.size());
}
void everything_of_uv_driving(benchmark::State& state) {
  const int km = static_cast<int>(state.range(0));
  const Surface& surface = track(km);
  std::vector<UV> uvs;
  Cursor cursor[4];
  std::size_t k = 0;
  for (const Point2& p : wheels(km)) uvs.push_back(surface.uv_of_xy(p.x_m, p.y_m, cursor[k++ % 4]));
  double sum = 0.0;
  for (auto _ : state) {
    for (const UV& uv : uvs) {
      const Sample sample = surface.at_uv(uv.u_m, uv.v_m);
      sum += sample.z_m + sample.dzdx + sample.dzdy + sample.heading_rad;
    }
  }
  benchmark::DoNotOptimize(sum);
  count(state, uvs.size());
}
void z_of_uv_driving(benchmark::State& state) {
  const int km = static_cast<int>(state.range(0));
  const Surface& surface = track(km);
  std::vector<UV> uvs;
  Cursor cursor[4];
  std::size_t k = 0;
  for (const Point2& p : wheels(km)) uvs.push_back(surface.uv_of_xy(p.x_m, p.y_m, cursor[k++ % 4]));
  double sum = 0.0;
  for (auto _ : state) {
    for (const UV& uv : uvs) sum += surface.z_at_uv(uv.u_m, uv.v_m);
  }
  benchmark::DoNotOptimize(sum);
  count(state, uvs.size());
}

std::vector<Point2> random_points(const Surface& surface, std::size_t number) {
  const ReferenceLine& line = surface.reference_line();
  std::mt19937 random(9);
  std::uniform_real_distribution<double> u_of(0.0,
                                              line.u_step_m * static_cast<double>(line.size() - 1)),
      v_of(-kHalfWidth_m, kHalfWidth_m);
  std::vector<Point2> points(number);
  for (Point2& p : points) p = surface.xy_of_uv(u_of(random), v_of(random));
  return points;
}

void z_random(benchmark::State& state) {
  const Surface& surface = track(static_cast<int>(state.range(0)));
  const std::vector<Point2> points = random_points(surface, 200000);
  double sum = 0.0;
  for (auto _ : state) {
    for (const Point2& p : points) {
      Cursor cursor;
      sum += surface.z_at_xy(p.x_m, p.y_m, cursor);
    }
  }
  benchmark::DoNotOptimize(sum);
  count(state, points.size());
}

void z_random_batch(benchmark::State& state) {
  const Surface& surface = track(static_cast<int>(state.range(0)));
  const std::vector<Point2> points = random_points(surface, 200000);
  std::vector<double> z_m(points.size());
  for (auto _ : state) {
    Cursor cursor;
    surface.z_at_xy(points, z_m, cursor);
    benchmark::DoNotOptimize(z_m.data());
  }
  count(state, points.size());
}

// One query at a time, timed singly; the clock's own cost is in the figures.
void z_random_latency(benchmark::State& state) {
  const Surface& surface = track(static_cast<int>(state.range(0)));
  const std::vector<Point2> points = random_points(surface, 200000);
  std::vector<double> ns(points.size(), 1e18);
  double sum = 0.0;
  for (auto _ : state) {
    for (std::size_t k = 0; k < points.size(); ++k) {
      Cursor cursor;
      const auto begin = std::chrono::steady_clock::now();
      sum += surface.z_at_xy(points[k].x_m, points[k].y_m, cursor);
      const auto end = std::chrono::steady_clock::now();
      ns[k] = std::chrono::duration<double, std::nano>(end - begin).count();
    }
  }
  benchmark::DoNotOptimize(sum);
  std::sort(ns.begin(), ns.end());
  state.counters["p50_ns"] = ns[ns.size() / 2];
  state.counters["p99.9_ns"] = ns[ns.size() * 999 / 1000];
  state.counters["max_ns"] = ns.back();
}

// A tyre's contact area of 10 x 40 samples, 1 cm apart, every millisecond along the lap.
void strips(benchmark::State& state, StripKernel kernel) {
  const Surface& surface = track(3);
  const std::vector<Point2>& points = wheels(3);
  std::vector<float> z(400);
  float sum = 0.0F;
  if (!available(kernel)) return state.SkipWithError("this processor lacks it");
  for (auto _ : state) {
    Cursor cursor[4];
    for (std::size_t k = 0; k + 8 < points.size(); k += 4) {
      for (std::size_t w = 0; w < 4; ++w) {
        const Point2 p = points[k + w], ahead = points[k + w + 4];
        Strip strip;
        strip.x_m = p.x_m;
        strip.y_m = p.y_m;
        const double apart_m = std::hypot(ahead.x_m - p.x_m, ahead.y_m - p.y_m);
        strip.ahead = {(ahead.x_m - p.x_m) / apart_m, (ahead.y_m - p.y_m) / apart_m};
        strip.along = 10;
        strip.across = 40;
        strip.step_m = 0.01;
        strip.kernel = kernel;
        surface.strip(strip, z, cursor[w]);
        sum += z[0] + z[399];
      }
    }
  }
  benchmark::DoNotOptimize(sum);
  count(state, (points.size() - 8) * 400);
}

BENCHMARK(bare_bilinear)->Arg(3);
BENCHMARK(z_driving)->Arg(3);
BENCHMARK(z_of_car_driving)->Arg(3);
BENCHMARK(uv_driving)->Arg(3);
BENCHMARK(everything_driving)->Arg(3);
BENCHMARK(everything_batch_driving)->Arg(3);
BENCHMARK(everything_of_uv_driving)->Arg(3);
BENCHMARK(z_of_uv_driving)->Arg(3);
BENCHMARK(bare_bilinear)->Arg(22);
BENCHMARK(z_driving)->Arg(22);
BENCHMARK(z_of_car_driving)->Arg(22);
BENCHMARK(z_random)->Arg(3)->Arg(22);
BENCHMARK(z_random_batch)->Arg(3)->Arg(22);
BENCHMARK(z_random_latency)->Arg(3)->Arg(22);
BENCHMARK_CAPTURE(strips, scalar, StripKernel::Scalar);
BENCHMARK_CAPTURE(strips, avx2, StripKernel::Avx2);
BENCHMARK_CAPTURE(strips, avx512, StripKernel::Avx512);

}  // namespace

BENCHMARK_MAIN();
