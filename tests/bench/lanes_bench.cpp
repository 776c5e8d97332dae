// Cars stepped in packs beside the same cars stepped one by one: the shipped car round a closed
// track of 0.4 km, 0.1 x 0.1 m, with waves of 1 cm, steps of 1 ms. Both in turn, blocks of 20
// steps, so that the machine's moods touch them alike. Figures: docs/evidence.md.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <thread>
#include <vector>

#include "crg/roads.h"
#include "support/places.h"
#include "vehicle/step_many.h"
#include "vehicle/vehicle_file.h"

namespace {

using namespace vehicle;

const crg::Surface& track() {
  static const crg::Surface surface = [] {
    crg::ReferenceLine line = crg::test::circuit(4001, 60.0, 0.08, 3);
    return crg::Surface(
        crg::make_crg(line, crg::test::grid_of(line, -7.5, 7.5, 151, [](double u, double v) {
                        return 0.01 * std::sin(0.7 * u) * std::cos(0.9 * v);
                      })));
  }();
  return surface;
}

/// Cars that go round.
struct Field {
  Vehicle file = read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  Road road{track()};
  std::vector<Car<double>> cars;
  std::vector<Simulation<double>> sims;
  std::vector<Controls<double>> controls;
  std::vector<StepResult> results;

  Field(std::size_t count, Contact contact) : controls(count), results(count) {
    for (std::size_t i = 0; i < count; ++i) {
      Parameters<double> p = file.parameters;
      p[Parameter::chassis_mass_kg] *= 1.0 + 0.002 * static_cast<double>(i);
      cars.push_back(make_car(file.files, p, file.terms, contact));
      const crg::Sample at = track().at_uv(5.0 + 15.0 * static_cast<double>(i), 0.0);
      StartOptions begin;
      begin.x_m = at.x_m;
      begin.y_m = at.y_m;
      begin.yaw_rad = at.heading_rad;
      begin.z_near_m = at.z_m;
      begin.speed_mps = 15.0 + static_cast<double>(i % 8);
      begin.gear = 3;
      sims.push_back(start(cars.back(), road, begin));
    }
  }
  std::vector<const Car<double>*> places() const {
    std::vector<const Car<double>*> out;
    for (const Car<double>& car : cars) out.push_back(&car);
    return out;
  }
  /// Steers to the line, holds the speed, brakes now and then.
  void ask() {
    crg::Cursor cursor;
    for (std::size_t i = 0; i < cars.size(); ++i) {
      const State<double>& s = sims[i].state;
      const crg::Sample at = track().at_xy(s[kX], s[kY], cursor);
      const double away =
          std::remainder(at.heading_rad - s[kYaw], 2.0 * 3.14159265358979) - 0.05 * at.v_m;
      Controls<double>& c = controls[i];
      c.steer_command_rad = cars[i].parameters[Parameter::steering_ratio] *
                            std::clamp(0.6 * away + 3.0 * at.curvature_1pm, -0.2, 0.2);
      c.throttle_command = s[kVx] < 16.0 + static_cast<double>(i % 8) ? 0.5 : 0.0;
      c.brake_command_pa.fill(sims[i].discrete.step / 500 % 7 == 6 ? 8e5 : 0.0);
      c.gear_command = 3;
    }
  }
  bool good() const {
    return std::all_of(results.begin(), results.end(), [](const StepResult& r) { return r.ok(); });
  }
};

/// Of the processor: other work of the machine does not count.
double now_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

constexpr int kBlock = 20;

void packs_beside_single(benchmark::State& state, Contact contact, Lanes lanes) {
  const auto count = static_cast<std::size_t>(state.range(0));
  Field alone(count, contact), together(count, contact);
  CarPacks packs(together.places(), 0.001, lanes);
  const StepOptions options;
  Detail<double> detail;
  std::vector<double> one_s, many_s;
  for (auto _ : state) {
    alone.ask();
    together.ask();
    const double a = now_s();
    for (int k = 0; k < kBlock; ++k)
      for (std::size_t i = 0; i < count; ++i)
        alone.results[i] =
            step(alone.cars[i], alone.sims[i], alone.controls[i], alone.road, options, detail);
    one_s.push_back(now_s() - a);
    const double b = now_s();
    for (int k = 0; k < kBlock; ++k)
      step_many(packs, together.sims, together.controls, together.road, options, together.results);
    many_s.push_back(now_s() - b);
  }
  if (!alone.good() || !together.good()) return state.SkipWithError("a car was lost");
  const auto median_us = [&](std::vector<double>& times) {
    std::nth_element(times.begin(), times.begin() + static_cast<long>(times.size() / 2),
                     times.end());
    return 1e6 * times[times.size() / 2] / (kBlock * static_cast<double>(count));
  };
  const double one = median_us(one_s), many = median_us(many_s);
  state.counters["single_us"] = one;
  state.counters["packs_us"] = many;
  state.counters["cars_in_the_time_of_one"] = one / many;
}
BENCHMARK_CAPTURE(packs_beside_single, single_point_avx512, Contact::kSinglePoint, Lanes::kAvx512)
    ->Arg(16)
    ->Iterations(150);
BENCHMARK_CAPTURE(packs_beside_single, single_point_avx2, Contact::kSinglePoint, Lanes::kAvx2)
    ->Arg(16)
    ->Iterations(150);
BENCHMARK_CAPTURE(packs_beside_single, four_point, Contact::kFourPoint, Lanes::kBest)
    ->Arg(16)
    ->Iterations(200);
BENCHMARK_CAPTURE(packs_beside_single, strip, Contact::kStrip, Lanes::kBest)
    ->Arg(16)
    ->Iterations(50);

/// All threads at once, each with cars of its own.
void car_steps(benchmark::State& state) {
  const auto threads = static_cast<std::size_t>(state.range(0));
  std::vector<std::unique_ptr<Field>> fields;
  std::vector<CarPacks> packs;
  for (std::size_t t = 0; t < threads; ++t) {
    fields.push_back(std::make_unique<Field>(16, Contact::kSinglePoint));
    packs.emplace_back(fields.back()->places(), 0.001);
  }
  constexpr int kBlocks = 200;
  for (auto _ : state) {
    std::vector<std::thread> workers;
    for (std::size_t t = 0; t < threads; ++t)
      workers.emplace_back([&, t] {
        Field& field = *fields[t];
        for (int block = 0; block < kBlocks; ++block) {
          field.ask();
          for (int k = 0; k < kBlock; ++k)
            step_many(packs[t], field.sims, field.controls, field.road, {}, field.results);
        }
      });
    for (std::thread& worker : workers) worker.join();
  }
  for (const auto& field : fields)
    if (!field->good()) return state.SkipWithError("a car was lost");
  state.counters["car_steps_per_s"] =
      benchmark::Counter(static_cast<double>(state.iterations() * threads * 16 * kBlocks * kBlock),
                         benchmark::Counter::kIsRate);
}
BENCHMARK(car_steps)->Arg(1)->Arg(2)->Iterations(5)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
