// What a step of 1 ms costs through a unit's functions, against the library's own call. Both drive
// the shipped car round the test's circle by the same commands; the unit gets all of them and gives
// its whole telemetry every step.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>

#include "fmu/shared_object.h"

namespace {

using Clock = std::chrono::steady_clock;

struct Times {
  std::vector<double> us;

  double median() {
    std::sort(us.begin(), us.end());
    return us[us.size() / 2];
  }
  void show(benchmark::State& state) {
    state.counters["median_us"] = median();
    const auto at = [&](double share) {
      return us[static_cast<std::size_t>(share * static_cast<double>(us.size() - 1))];
    };
    state.counters["p99.9_us"] = at(0.999);
    state.counters["p99.99_us"] = at(0.9999);
    state.counters["largest_us"] = us.back();
  }
};

/// Both in turn, so that the machine's moods touch them alike.
void unit_against_library(benchmark::State& state) {
  const fmu_tests::Unit unit;
  const fmu_tests::Fmi2 car(unit);
  fmu_tests::DrivenCar own(unit.folder().path("circle.crg"));
  if (car.set("start.speed", 10.0) != 0 || car.initialise() != 0) {
    state.SkipWithError("no unit");
    return;
  }
  std::vector<unsigned> inputs;
  for (const char* name : {"input.steering", "input.throttle", "input.brake.fl", "input.brake.fr",
                           "input.brake.rl", "input.brake.rr", "input.clutch"})
    inputs.push_back(fmu_tests::reference_of(name));
  std::vector<unsigned> outputs;
  const unsigned gear = fmu_tests::reference_of("car.gear");
  for (unsigned i = 0; i < own.row().size(); ++i)
    if (i != gear) outputs.push_back(i);
  std::vector<double> row(outputs.size());
  using Get = int (*)(void*, const unsigned*, std::size_t, double*);
  using Set = int (*)(void*, const unsigned*, std::size_t, const double*);
  using Step = int (*)(void*, double, double, int);
  const auto get = car.find<Get>("fmi2GetReal");
  const auto set = car.find<Set>("fmi2SetReal");
  const auto do_step = car.find<Step>("fmi2DoStep");
  Times by_unit, by_library, by_row;
  int step = 0;
  for (auto _ : state) {
    const auto asked =
        fmu_tests::asked_of(0.001 * step, own.row()[1], own.row()[2], own.row()[8], own.row()[9]);
    const double values[] = {asked.steer_command_rad,   asked.throttle_command,
                             asked.brake_command_pa[0], asked.brake_command_pa[1],
                             asked.brake_command_pa[2], asked.brake_command_pa[3],
                             asked.clutch_command};
    const auto a = Clock::now();
    int worst = set(car.component, inputs.data(), inputs.size(), values);
    worst = std::max(worst, do_step(car.component, 0.001 * step, 0.001, 1));
    worst = std::max(worst, get(car.component, outputs.data(), outputs.size(), row.data()));
    const auto b = Clock::now();
    const bool good = own.step_alone(asked);
    const auto c = Clock::now();
    own.show(asked);
    const auto d = Clock::now();
    if (worst != 0 || !good) {
      state.SkipWithError("a step failed");
      return;
    }
    by_unit.us.push_back(std::chrono::duration<double, std::micro>(b - a).count());
    by_library.us.push_back(std::chrono::duration<double, std::micro>(c - b).count());
    by_row.us.push_back(std::chrono::duration<double, std::micro>(d - b).count());
    ++step;
  }
  by_unit.show(state);
  state.counters["step_alone_us"] = by_library.median();
  state.counters["with_telemetry_us"] = by_row.median();
  state.counters["ratio"] = by_unit.median() / by_library.median();
  state.counters["ratio_with_telemetry"] = by_unit.median() / by_row.median();
}
BENCHMARK(unit_against_library)->Iterations(60000)->Repetitions(5);

}  // namespace

BENCHMARK_MAIN();
