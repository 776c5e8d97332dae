#include "vehicle/step_many.h"

#include <algorithm>

#include "kernel.h"
#include "vehicle/error.h"

namespace vehicle {

namespace many {
namespace {

/// 0, 1 or neither: what laws ask of an amplitude before they compute.
int kind(double x) { return x == 0.0 ? 0 : (x == 1.0 ? 1 : 2); }

bool fit_together(const Car<double>& a, const Car<double>& b) {
  if (a.files != b.files || a.contact != b.contact ||
      a.tyre_options.alpha != b.tyre_options.alpha ||
      a.tyre_options.moments != b.tyre_options.moments ||
      a.tyre_options.mirrored != b.tyre_options.mirrored)
    return false;
  const auto same_kind = [](double x, double y) { return kind(x) == kind(y); };
  const auto both_zero = [](double x, double y) { return (x == 0.0) == (y == 0.0); };
  return std::equal(a.terms.value.begin(), a.terms.value.end(), b.terms.value.begin(), same_kind) &&
         std::equal(a.parameters.value.begin(), a.parameters.value.end(),
                    b.parameters.value.begin(), both_zero);
}

std::size_t width_of(Lanes lanes) {
  switch (lanes) {
    case Lanes::kAvx2:
      return 4;
    case Lanes::kAvx512:
      return 8;
    case Lanes::kOne:
    case Lanes::kBest:
      break;
  }
  return 1;
}

std::unique_ptr<Kernel> make_kernel([[maybe_unused]] Lanes lanes,
                                    [[maybe_unused]] std::span<const Car<double>* const> cars) {
#if defined(__x86_64__)
  if (lanes == Lanes::kAvx512) return make_avx512_kernel(cars);
  if (lanes == Lanes::kAvx2) return make_avx2_kernel(cars);
#endif
  return nullptr;
}

}  // namespace

Kernel::~Kernel() = default;

void ground_of(std::span<Lane, 4> lanes, const Road& road, std::size_t wheel, const FourAsk& ask,
               std::span<RoadPoint, 4> points) {
  std::size_t driven = 0;
  std::array<crg::Point2, 4> places;
  std::array<RoadCursors*, 4> cursors{};
  for (std::size_t k = 0; k < 4; ++k) {
    places[k] = {ask.x_m[k], ask.y_m[k]};
    if (lanes[k].sim == nullptr) continue;
    cursors[k] = &lanes[k].sim->cursors;
    ++driven;
  }
  const bool known = driven == 4 && lanes[0].car->contact != Contact::kStrip &&
                     road.at_four(places, ask.z_near_m, wheel, cursors,
                                  {&points[0], &points[1], &points[2], &points[3]});
  for (std::size_t k = 0; k < 4; ++k) {
    if (cursors[k] == nullptr) continue;
    const auto asked = [&](const auto& ground) {
      return ground(road, *lanes[k].car, wheel, ask.x_m[k], ask.y_m[k], ask.z_near_m[k],
                    ask.heading_x[k], ask.heading_y[k], *cursors[k], points[k]);
    };
    points[k].z_m =
        (known ? asked(dynamics::rest_on<double>) : asked(dynamics::ground_under<double>)).z_m;
  }
}

void settle_ledges_of(Lane& lane, double step_s, const State<double>& s, State<double>& rate,
                      Detail<double>& detail) {
  settle_ledges(*lane.car, step_s, s, lane.sim->discrete.ledge, lane.sim->discrete.ledges, rate,
                detail);
}

}  // namespace many

bool has_lanes(Lanes lanes) {
#if defined(__x86_64__)
  if (lanes == Lanes::kAvx2) return __builtin_cpu_supports("avx2");
  if (lanes == Lanes::kAvx512)
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx2");
#endif
  return lanes == Lanes::kOne || lanes == Lanes::kBest;
}

CarPacks::CarPacks(std::span<const Car<double>* const> cars, double step_s, Lanes lanes)
    : step_s_(step_s), cars_(cars.begin(), cars.end()) {
  if (!has_lanes(lanes)) throw Error("this processor does not have the lanes asked for");
  if (lanes == Lanes::kBest)
    lanes = has_lanes(Lanes::kAvx512) ? Lanes::kAvx512
                                      : (has_lanes(Lanes::kAvx2) ? Lanes::kAvx2 : Lanes::kOne);
  const std::size_t width = many::width_of(lanes);
  StepOptions options;
  options.step_s = step_s;
  for (std::size_t i = 0; i < cars_.size(); ++i) {
    check_step(cars_[i]->parameters, options);
    responses_.push_back(actuator_responses(*cars_[i], step_s));
    const auto with_room = [&](const Pack& pack) {
      return pack.cars.size() < width && many::fit_together(*cars_[pack.cars.front()], *cars_[i]);
    };
    const auto pack = std::find_if(packs_.begin(), packs_.end(), with_room);
    if (pack != packs_.end())
      pack->cars.push_back(i);
    else
      packs_.push_back({{i}, 0, nullptr});
  }
  for (Pack& pack : packs_) {
    // A pack takes the time of about so many single steps.
    pack.least = static_cast<std::ptrdiff_t>(width / 4 + 1);
    if (static_cast<std::ptrdiff_t>(pack.cars.size()) < pack.least) continue;
    std::vector<const Car<double>*> members;
    for (const std::size_t i : pack.cars) members.push_back(cars_[i]);
    pack.kernel = many::make_kernel(lanes, members);
  }
}
CarPacks::~CarPacks() = default;
CarPacks::CarPacks(CarPacks&&) noexcept = default;
CarPacks& CarPacks::operator=(CarPacks&&) noexcept = default;

void CarPacks::take(std::span<const Parameter> which) {
  std::array<const Car<double>*, many::kMostLanes> members{};
  for (Pack& pack : packs_) {
    if (pack.kernel == nullptr) continue;
    const std::size_t count = std::min(pack.cars.size(), members.size());
    for (std::size_t k = 0; k < count; ++k) members[k] = cars_[pack.cars[k]];
    pack.kernel->take(std::span(members.data(), count), which);
  }
}

void step_many(CarPacks& packs, std::span<Simulation<double>> sims,
               std::span<const Controls<double>> controls, const Road& road,
               const StepOptions& options, std::span<StepResult> results,
               std::span<Detail<double>> details) {
  const std::size_t n = packs.cars();
  if (sims.size() != n || controls.size() != n || results.size() != n ||
      (!details.empty() && details.size() != n))
    throw Error("step_many: wanted one entry for each car");
  if (options.step_s != packs.step_s_) throw Error("step_many: another step than the packs have");
  Detail<double> unwanted;
  std::array<Inputs<double>, many::kMostLanes> inputs;
  for (CarPacks::Pack& pack : packs.packs_) {
    std::array<many::Lane, many::kMostLanes> all;
    const std::span lanes(all.data(), std::min(pack.cars.size(), all.size()));
    const auto drives = [&](std::size_t i) { return results[i].ok(); };
    const auto driving = std::count_if(pack.cars.begin(), pack.cars.end(), drives);
    if (pack.kernel == nullptr || driving < pack.least) {
      for (const std::size_t i : pack.cars)
        if (drives(i))
          results[i] = step(*packs.cars_[i], sims[i], controls[i], road, options,
                            details.empty() ? unwanted : details[i]);
      continue;
    }
    for (std::size_t k = 0; k < lanes.size(); ++k) {
      const std::size_t i = pack.cars[k];
      if (!drives(i)) continue;
      inputs[k] = actuate(*packs.cars_[i], sims[i].discrete, controls[i], options.step_s,
                          packs.responses_[i]);
      lanes[k].car = packs.cars_[i];
      lanes[k].sim = &sims[i];
      lanes[k].in = &inputs[k];
      lanes[k].detail = details.empty() ? nullptr : &details[i];
    }
    pack.kernel->step(all, road, options);
    for (std::size_t k = 0; k < lanes.size(); ++k) {
      if (lanes[k].sim == nullptr) continue;
      Simulation<double>& sim = *lanes[k].sim;
      StepResult& result = results[pack.cars[k]] = lanes[k].result;
      if (!lanes[k].moved) continue;
      sim.time_s = static_cast<double>(sim.discrete.step) * options.step_s;
      if (lanes[k].suspect) result = judge(sim.state);
    }
  }
}

}  // namespace vehicle
