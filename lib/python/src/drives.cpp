// Many cars of one kind for Python, stepped together in packs: what learning needs.
#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drive.h"
#include "recording/channels.h"
#include "road_arrays.h"
#include "vehicle/step_many.h"

namespace py = pybind11;

namespace kerbstone {
namespace {

constexpr std::size_t kBrakes = vehicle::kWheels;

/// `each` numbers for each car, car after car: from one for all, from `each` for all cars, or from
/// an array that has all.
std::vector<double> spread(std::string_view name, const py::object& given, std::size_t cars,
                           std::size_t each = 1) {
  const Numbers values(given);
  const auto has = [&](std::initializer_list<std::size_t> shape) {
    return std::equal(
        values.shape(), values.shape() + values.ndim(), shape.begin(), shape.end(),
        [](py::ssize_t a, std::size_t b) { return static_cast<std::size_t>(a) == b; });
  };
  std::vector<double> out(cars * each);
  const double* const from = values.data();
  if (has({}))
    std::fill(out.begin(), out.end(), *from);
  else if (each == 1 ? has({cars}) : has({cars, each}))
    std::copy_n(from, out.size(), out.begin());
  else if (each > 1 && has({each}))
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = from[k % each];
  else if (each == 1)
    throw py::value_error(fmt::format("{}: a number or {} of them wanted", name, cars));
  else
    throw py::value_error(
        fmt::format("{}: a number, {} of them or {} x {} wanted", name, each, cars, each));
  return out;
}

/// All that one of many cars holds between steps.
struct OneOfMany {
  vehicle::Simulation<double> sim;
  vehicle::RoadTracker::Place place;
  vehicle::StepResult result;
  std::string problem;      ///< empty: it drives
  std::vector<double> row;  ///< of telemetry
};

/// What Drives.state gives, and the cars that take it: those with this key.
struct KeptState {
  std::shared_ptr<const int> key;
  OneOfMany car;
};

/// Cars that are driven step by step, together. Refers to car and road, which Python keeps alive.
/// Several threads may call: one steps while the others wait.
class Drives {
 public:
  Drives(const Car& car, const Road& road, std::vector<vehicle::StartOptions> starts, double step_s)
      : car_(car),
        road_(road.surface),
        starts_(std::move(starts)),
        packs_(std::vector<const vehicle::Car<double>*>(starts_.size(), &car.car), step_s),
        trackers_(starts_.size(), vehicle::RoadTracker(road.surface)),
        sims_(starts_.size()),
        before_(starts_.size()),
        controls_(starts_.size()),
        results_(starts_.size()),
        details_(starts_.size()),
        problems_(starts_.size()),
        rows_(starts_.size() * width()) {
    options_.step_s = step_s;
    for (std::size_t i = 0; i < cars(); ++i) take(i, begun(i));
  }

  std::size_t cars() const { return starts_.size(); }

  void step(const py::object& steer_rad, const py::object& throttle, const py::object& brake_pa,
            const py::object& gear, const py::object& clutch, int steps) {
    want_steps(steps);
    const std::size_t n = cars();
    const std::vector<double> steers = spread("steer_rad", steer_rad, n),
                              throttles = spread("throttle", throttle, n),
                              brakes = spread("brake_pa", brake_pa, n, kBrakes),
                              gears = spread("gear", gear, n),
                              clutches = spread("clutch", clutch, n);
    std::vector<vehicle::Controls<double>> controls(n);
    for (std::size_t i = 0; i < n; ++i) {
      Asked asked{steers[i], throttles[i], {}, gears[i], clutches[i]};
      std::copy_n(&brakes[kBrakes * i], kBrakes, asked.brake_pa.begin());
      controls[i] = controls_of(car_, asked);
    }
    const py::gil_scoped_release free;
    const std::scoped_lock alone(mutex_);
    controls_ = std::move(controls);
    go(steps);
  }

  py::array_t<double> channel(const std::string& name) {
    const std::size_t place = place_of_channel(name);
    return of_each([&](std::size_t i) { return rows_[i * width() + place]; });
  }
  py::array_t<double> time_s() {
    return of_each([&](std::size_t i) { return sims_[i].time_s; });
  }
  std::vector<std::optional<std::string>> problems() {
    const std::scoped_lock alone(mutex_);
    std::vector<std::optional<std::string>> out(cars());
    for (std::size_t i = 0; i < cars(); ++i)
      if (!problems_[i].empty()) out[i] = problems_[i];
    return out;
  }

  KeptState state(int car) {
    const std::size_t i = place_of(car);
    const std::scoped_lock alone(mutex_);
    const double* const row = &rows_[i * width()];
    return {key_,
            {sims_[i], trackers_[i].place(), results_[i], problems_[i], {row, row + width()}}};
  }
  void set_state(int car, const KeptState& state) {
    const std::size_t i = place_of(car);
    if (state.key != key_) throw py::value_error("state: one of these cars wanted");
    const std::scoped_lock alone(mutex_);
    take(i, state.car);
  }
  void reset(int car) {
    const std::size_t i = place_of(car);
    const std::scoped_lock alone(mutex_);
    take(i, begun(i));
  }

 private:
  static std::size_t width() { return recording::telemetry_channels().size(); }
  std::size_t place_of(int car) const {
    if (car < 0 || static_cast<std::size_t>(car) >= cars())
      throw py::index_error(fmt::format("car {}: 0 to {} wanted", car, cars() - 1));
    return static_cast<std::size_t>(car);
  }
  OneOfMany begun(std::size_t i) const {
    return {vehicle::start(car_.car, road_, starts_[i]),
            {},
            {},
            "",
            std::vector<double>(width(), std::nan(""))};
  }
  void take(std::size_t i, const OneOfMany& car) {
    sims_[i] = car.sim;
    trackers_[i].go_on_from(car.place);
    results_[i] = car.result;
    problems_[i] = car.problem;
    std::copy(car.row.begin(), car.row.end(), &rows_[i * width()]);
  }

  /// Steps of all cars that drive; the mutex is held, the interpreter's lock is not.
  void go(int steps) {
    std::vector<std::size_t> driving;
    for (std::size_t i = 0; i < cars(); ++i)
      if (results_[i].ok()) driving.push_back(i);
    for (int k = 0; k < steps; ++k) {
      for (const std::size_t i : driving)
        if (results_[i].ok()) before_[i] = {sims_[i].state, sims_[i].time_s};
      vehicle::step_many(packs_, sims_, controls_, road_, options_, results_, details_);
    }
    for (const std::size_t i : driving)
      problems_[i] = tell(sims_[i], results_[i], before_[i], details_[i], controls_[i],
                          trackers_[i], std::span(&rows_[i * width()], width()));
  }

  /// The array is made without the mutex: making it may run other code of Python.
  template <class Number>
  py::array_t<double> of_each(Number number) {
    std::vector<double> out(cars());
    {
      const std::scoped_lock alone(mutex_);
      for (std::size_t i = 0; i < out.size(); ++i) out[i] = number(i);
    }
    return py::array_t<double>(static_cast<py::ssize_t>(out.size()), out.data());
  }

  const std::shared_ptr<const int> key_ = std::make_shared<int>(0);
  const Car& car_;
  vehicle::Road road_;
  std::vector<vehicle::StartOptions> starts_;
  vehicle::CarPacks packs_;
  vehicle::StepOptions options_;
  std::mutex mutex_;  ///< guards what follows, and the packs
  std::vector<vehicle::RoadTracker> trackers_;
  std::vector<vehicle::Simulation<double>> sims_;
  std::vector<Before> before_;  ///< of the last step of each
  std::vector<vehicle::Controls<double>> controls_;
  std::vector<vehicle::StepResult> results_;
  std::vector<vehicle::Detail<double>> details_;
  std::vector<std::string> problems_;  ///< empty: it drives
  std::vector<double> rows_;           ///< of telemetry, car after car
};

std::unique_ptr<Drives> start_drives(const Car& car, const Road& road, int cars,
                                     const py::object& u_m, const py::object& v_m,
                                     const py::object& speed_mps, const py::object& gear,
                                     const py::object& fuel_kg, const py::object& tyre_k,
                                     const py::object& disc_k, double step_s) {
  constexpr int kMost = 10'000;  // of 60 kB each
  if (cars < 1 || cars > kMost) throw py::value_error(fmt::format("cars: 1 to {} wanted", kMost));
  want_step_s(step_s);
  const auto n = static_cast<std::size_t>(cars);
  const std::vector<double> u = spread("u_m", u_m, n), v = spread("v_m", v_m, n),
                            speed = spread("speed_mps", speed_mps, n), g = spread("gear", gear, n),
                            fuel = spread("fuel_kg", fuel_kg, n),
                            tyre = spread("tyre_k", tyre_k, n), disc = spread("disc_k", disc_k, n);
  std::vector<vehicle::StartOptions> starts;
  for (std::size_t i = 0; i < n; ++i)
    starts.push_back(start_of(car, road, {u[i], v[i], speed[i], g[i], fuel[i], tyre[i], disc[i]}));
  return std::make_unique<Drives>(car, road, std::move(starts), step_s);
}

}  // namespace

void add_drives(py::module_& m, py::class_<Car>& cars) {
  using namespace pybind11::literals;
  const py::class_<KeptState> kept(m, "DriveState", "All of one of many cars at a moment.");
  py::class_<Drives>(m, "Drives", "Many cars of one kind that are driven step by step, together.")
      .def("step", &Drives::step,
           "As Drive.step, with a number for all cars or an array of one for each; brake_pa also "
           "4 for all or cars x 4.\n"
           "A car that cannot go on stands, and is in `problems`; the others go on. Releases the "
           "interpreter's lock.",
           py::kw_only(), "steer_rad"_a = 0.0, "throttle"_a = 0.0, "brake_pa"_a = 0.0, "gear"_a = 1,
           "clutch"_a = 0.0, "steps"_a = 1)
      .def("__len__", &Drives::cars)
      .def("__getitem__", &Drives::channel,
           "A channel of each car's last step, by name; NaN before the first.", "channel"_a)
      .def_property_readonly("time_s", &Drives::time_s, "of each car")
      .def_property_readonly("problems", &Drives::problems,
                             "for each car why it stands, in a sentence, or None")
      .def("state", &Drives::state,
           "All of this car now, its problem too: any car of these Drives takes it.", "car"_a)
      .def("set_state", &Drives::set_state, "The car goes on from there, bit for bit.", "car"_a,
           "state"_a)
      .def("reset", &Drives::reset, "Back to how the car began.", "car"_a);
  cars.def("start_many", &start_drives,
           "Sets so many cars on the road, along it, to be driven together; numbers for all or an "
           "array of one for each.\n"
           "They do not meet. Each goes bit for bit as a Drive that is asked the same.",
           "road"_a, py::kw_only(), "cars"_a, "u_m"_a = 0.0, "v_m"_a = 0.0, "speed_mps"_a = 0.0,
           "gear"_a = 1, "fuel_kg"_a = 30.0, "tyre_k"_a = 360.0, "disc_k"_a = 500.0,
           "step_s"_a = 0.001, py::keep_alive<0, 1>(), py::keep_alive<0, 2>());
}

}  // namespace kerbstone
