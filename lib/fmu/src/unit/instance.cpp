#include "fmu/instance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "base/error.h"
#include "base/read_file.h"
#include "fmu/wording.h"
#include "recording/channels.h"
#include "text_place.h"
#include "vehicle/opponent.h"
#include "vehicle/telemetry.h"

namespace fmu {

namespace {

constexpr std::size_t kLargestUnitFileBytes = 65536;

}  // namespace

Instance::Instance(std::string resources, const std::string& token)
    : resources_(std::move(resources)), list_(variables()) {
  std::size_t inputs = 0;
  for (std::size_t k = 0; k < list_.size(); ++k) {
    for (std::size_t i = 0; i < list_[k].size; ++i) {
      variable_of_.push_back(k);
      type_of_.push_back(list_[k].type);
    }
    if (list_[k].index == 0) first_[static_cast<std::size_t>(list_[k].source)] = list_[k].reference;
    if (list_[k].source == Source::kInput) input_.at(inputs++) = list_[k].reference;
  }
  const std::string path = (std::filesystem::path(resources_) / "unit.txt").string();
  unit_ = parse_unit_file(base::read_file(path, kLargestUnitFileBytes), path, list_);
  if (token != unit_.token)
    throw base::Error(
        fmt::format("asked for the unit {}, but this one is {}; the model description is not that "
                    "of this binary's folder",
                    token.empty() ? "''" : token, unit_.token));
  telemetry_.resize(recording::telemetry_channels().size());
  files_ = load_files(unit_.texts, resources_);
  start_again();
}

/// Everything as after loading.
void Instance::start_again() {
  has_closed_ = false;
  now_ = SavedState{};
  now_.texts = unit_.texts;
  now_.numbers.assign(count_values(list_) - kTextCount, 0.0);
  now_.given.assign(now_.numbers.size(), 0);
  for (const Variable& v : list_)
    for (std::size_t i = 0; i < v.size && v.source != Source::kText; ++i)
      now_.numbers[v.reference + i] = v.start;
  for (const UnitFile::Number& number : unit_.numbers)
    for (const Variable& v : list_)
      if (v.name == number.name) now_.numbers[v.reference] = number.value;
  if (files_->texts != unit_.texts) files_ = load_files(unit_.texts, resources_);
  use_files(files_);
  exported_ = now_.numbers;
}

const Variable& Instance::variable(std::uint32_t reference) const {
  if (reference >= variable_of_.size())
    throw base::Error(fmt::format("there is no value reference {}; the last is {}", reference,
                                  variable_of_.size() - 1));
  return list_[variable_of_[reference]];
}

/// Shows the parameters of the files where none was given. Whoever sets each of them to a value
/// says with those that are the exported starts nothing: some importers do so by themselves.
void Instance::use_files(std::shared_ptr<const LoadedFiles> files) {
  files_ = std::move(files);
  const auto all_given = [&](Source source, std::size_t count) {
    const auto first = now_.given.begin() + first_[static_cast<std::size_t>(source)];
    return std::find(first, first + static_cast<std::ptrdiff_t>(count), kNotGiven) ==
           first + static_cast<std::ptrdiff_t>(count);
  };
  const auto show = [&](Source source, const auto& values) {
    const bool all = all_given(source, values.size());
    const std::uint32_t first = first_[static_cast<std::size_t>(source)];
    for (std::size_t i = 0; i < values.size(); ++i)
      if (now_.given[first + i] == kNotGiven || (all && now_.given[first + i] == kGivenAsExported))
        now_.numbers[first + i] = values[i];
  };
  show(Source::kParameter, files_->vehicle.parameters.value);
  show(Source::kTerm, files_->vehicle.terms.value);
  changed_ = true;
}

double Instance::input(Input which, std::size_t i) const {
  return now_.numbers[input_[static_cast<std::size_t>(which)] + i];
}

double Instance::start(Start which) const {
  return now_
      .numbers[first_[static_cast<std::size_t>(Source::kStart)] + static_cast<std::size_t>(which)];
}

/// The car of the parameters as they stand now.
void Instance::build_car() {
  vehicle::Parameters<double> parameters;
  vehicle::Amplitudes<double> terms;
  const double* const p =
      now_.numbers.data() + first_[static_cast<std::size_t>(Source::kParameter)];
  const double* const t = now_.numbers.data() + first_[static_cast<std::size_t>(Source::kTerm)];
  std::copy_n(p, vehicle::kParameterCount, parameters.value.begin());
  std::copy_n(t, vehicle::kTermCount, terms.value.begin());
  vehicle::StepOptions options;
  options.step_s = start(Start::kSolverStep);
  options.integrator = files_->integrator;
  vehicle::check_step(parameters, options);
  car_ = vehicle::make_car(files_->vehicle.files, parameters, terms, files_->vehicle.contact);
  options_ = options;
}

void Instance::place_car() {
  vehicle::StartOptions begin;
  begin.x_m = start(Start::kU);
  begin.y_m = start(Start::kV);
  begin.yaw_rad = start(Start::kYaw);
  if (files_->surface) {
    const crg::Sample at = files_->surface->at_uv(begin.x_m, begin.y_m);
    if (!at.valid || !at.inside)
      throw base::Error(fmt::format("{}: no road at start.u = {} m, start.v = {} m",
                                    now_.texts[place(Text::kRoad)], begin.x_m, begin.y_m));
    begin.x_m = at.x_m;
    begin.y_m = at.y_m;
    begin.z_near_m = at.z_m;
    begin.yaw_rad += at.heading_rad;
  }
  begin.speed_mps = start(Start::kSpeed);
  begin.gear = static_cast<int>(input(Input::kGear));
  begin.fuel_kg = start(Start::kFuel);
  begin.tyre_k = start(Start::kTyre);
  begin.disc_k = start(Start::kDisc);
  now_.simulation = vehicle::start(car_, files_->road, begin);
  now_.place = {};
}

/// A car at its begin, and its outputs there.
void Instance::begin_run() {
  if (files_->texts != now_.texts) use_files(load_files(now_.texts, resources_));
  build_car();
  place_car();
  tracker_.reset();
  if (files_->surface) tracker_.emplace(*files_->surface);
  // Forces and accelerations of the begin are those of a first step that is not taken.
  vehicle::Simulation<double> copy = now_.simulation;
  vehicle::Detail<double> detail;
  vehicle::Controls<double> asked = controls();
  look_at_opponents(asked);
  const vehicle::StepResult result =
      vehicle::step(car_, copy, asked, files_->road, options_, detail);
  if (!result.ok())
    throw base::Error(vehicle::describe(result, now_.begin_s, start(Start::kU), start(Start::kV)));
  now_.started = true;
  show_outputs(detail, asked);
  changed_ = false;  // not before: what failed is tried again
}

/// Before the first step, whatever was set shows in what is read.
void Instance::prepare() {
  if (changed_ && now_.phase <= Phase::kInitialising) begin_run();
}

vehicle::Controls<double> Instance::controls() const {
  vehicle::Controls<double> out;
  out.steer_command_rad = input(Input::kSteering);
  out.throttle_command = input(Input::kThrottle);
  for (std::size_t i = 0; i < vehicle::kWheels; ++i)
    out.brake_command_pa[i] = input(Input::kBrake, i);
  out.gear_command = static_cast<int>(input(Input::kGear));
  out.clutch_command = input(Input::kClutch);
  if (input(Input::kWakeActive) != 0.0) {
    out.opponent = true;
    out.wake_x_m = input(Input::kWakeX);
    out.wake_y_m = input(Input::kWakeY);
  }
  return out;
}

/// The wake of the nearest opponent from where the car is now.
void Instance::look_at_opponents(vehicle::Controls<double>& asked) const {
  if (input(Input::kWakeActive) != 0.0) return;
  std::array<vehicle::OpponentPlace, 4> places;
  std::size_t count = 0;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (input(Input::kOpponentActive, i) != 0.0)
      places[count++] = {input(Input::kOpponentX, i), input(Input::kOpponentY, i)};
  if (count == 0) return;
  const auto wake = vehicle::nearest_wake(
      std::span<const vehicle::OpponentPlace>(places.data(), count), now_.simulation.state);
  asked.opponent = true;
  asked.wake_x_m = wake->x_m;
  asked.wake_y_m = wake->y_m;
}

double Instance::time_s() const {
  return now_.begin_s +
         static_cast<double>(now_.simulation.discrete.step) * start(Start::kSolverStep);
}

void Instance::show_outputs(const vehicle::Detail<double>& detail,
                            const vehicle::Controls<double>& asked) {
  const vehicle::State<double>& s = now_.simulation.state;
  crg::UV at{s[vehicle::kX], s[vehicle::kY]};
  if (tracker_)
    at = tracker_->at(s[vehicle::kX], s[vehicle::kY],
                      s[vehicle::kZ] - car_.parameters[vehicle::Parameter::chassis_cog_height_m]);
  // References of the telemetry begin with 0, the time.
  vehicle::fill_telemetry(time_s(), s, detail, asked, at.u_m, at.v_m, telemetry_);
  std::copy(telemetry_.begin(), telemetry_.end(), now_.numbers.begin());
  double* out = now_.numbers.data() + first_[static_cast<std::size_t>(Source::kForces)];
#define FMU_WHEEL(channel, member, text) \
  for (const vehicle::WheelDetail<double>& wheel : detail.wheel) *out++ = wheel.member;
#define FMU_WHEEL_FLAG(channel, member, text) \
  for (const vehicle::WheelDetail<double>& wheel : detail.wheel) *out++ = wheel.member ? 1.0 : 0.0;
#define FMU_CAR(channel, member, text) *out++ = detail.member;
#include "forces.def"
#undef FMU_WHEEL
#undef FMU_WHEEL_FLAG
#undef FMU_CAR
  std::copy(s.value.begin(), s.value.end(),
            now_.numbers.begin() + first_[static_cast<std::size_t>(Source::kState)]);
}

void Instance::enter_initialisation(double begin_s) {
  if (now_.phase != Phase::kInstantiated)
    throw base::Error("initialisation was asked for twice; reset the unit before");
  if (!std::isfinite(begin_s)) throw base::Error("the start time is no number");
  now_.begin_s = begin_s;
  changed_ = true;
  now_.phase = Phase::kInitialising;
}

void Instance::leave_initialisation() {
  if (now_.phase != Phase::kInitialising)
    throw base::Error("initialisation was left without being entered");
  prepare();
  now_.phase = Phase::kStepping;
}

void Instance::terminate() {
  if (now_.phase != Phase::kStepping) throw base::Error("the unit is not being stepped");
  now_.phase = Phase::kTerminated;
}

void Instance::reset() { start_again(); }

std::string Instance::closing_remark() {
  if (std::exchange(has_closed_, true)) return {};
  return vehicle::ledge_warning(now_.simulation.discrete.ledges);
}

double Instance::number(std::uint32_t reference, Type type) {
  // Between steps, when everything shows already: what an importer asks hundreds of times.
  if (!changed_ && reference < type_of_.size() && type_of_[reference] == type &&
      type != Type::kString &&
      reference - first_[static_cast<std::size_t>(Source::kRate)] >= vehicle::kStateSize)
    return now_.numbers[reference];
  const Variable& v = variable(reference);
  if (v.type != type)
    throw base::Error(fmt::format("{} is {}, but {} was asked for",
                                  value_name(v, reference - v.reference), word(v.type),
                                  word(type)));
  if (v.source == Source::kRate) return rate(v.index + (reference - v.reference));
  if (changed_ && v.source != Source::kInput && v.source != Source::kStart) prepare();
  return now_.numbers[reference];
}

const std::string& Instance::text(std::uint32_t reference) {
  const Variable& v = variable(reference);
  if (v.type != Type::kString)
    throw base::Error(fmt::format("{} is {}, but a text was asked for",
                                  value_name(v, reference - v.reference), word(v.type)));
  return now_.texts[v.index];
}

void Instance::want_settable(const Variable& v) const {
  const bool before = now_.phase <= Phase::kInitialising;
  const bool may_be =
      v.causality == Causality::kInput ||
      (v.causality == Causality::kParameter && (before || v.variability == Variability::kTunable));
  if (v.causality != Causality::kInput && v.causality != Causality::kParameter)
    throw base::Error(fmt::format("{} is what the car does; it cannot be set", v.name));
  if (!may_be)
    throw base::Error(fmt::format("{} cannot be set after initialisation; reset the unit", v.name));
  if (now_.phase == Phase::kTerminated || now_.phase == Phase::kFailed)
    throw base::Error(fmt::format("{} was set after the end of the run", v.name));
}

std::string Instance::set_number(std::uint32_t reference, Type type, double value) {
  const Variable& v = variable(reference);
  if (now_.phase == Phase::kStepping && v.causality == Causality::kInput && v.type == type &&
      value >= v.low && value <= v.high && type == Type::kReal) {
    now_.numbers[reference] = value;
    return {};
  }
  const std::string name = value_name(v, reference - v.reference);
  if (v.type != type)
    throw base::Error(fmt::format("{} is {}, but {} was given", name, word(v.type), word(type)));
  want_settable(v);
  if (!std::isfinite(value))
    throw base::Error(fmt::format("{} = {}, wanted a number", name, value));
  std::string remark;
  if (!(value >= v.low && value <= v.high)) {
    remark = fmt::format("{} = {}, wanted {} to {}", name, value, v.low, v.high);
    if (v.causality == Causality::kParameter || v.type != Type::kReal) throw base::Error(remark);
    value = std::clamp(value, v.low, v.high);
    remark += fmt::format("; {} is taken", value);
  }
  if (v.source == Source::kParameter || v.source == Source::kTerm) {
    const bool is_exported = value == exported_[reference];
    now_.given[reference] = is_exported ? kGivenAsExported : kGiven;
  }
  if (now_.numbers[reference] == value && (v.causality == Causality::kInput || !changed_))
    return remark;
  now_.numbers[reference] = value;
  changed_ = changed_ || v.causality == Causality::kParameter || now_.phase <= Phase::kInitialising;
  return remark;
}

void Instance::set_text(std::uint32_t reference, std::string value) {
  const Variable& v = variable(reference);
  if (v.type != Type::kString)
    throw base::Error(fmt::format("{} is {}, but a text was given",
                                  value_name(v, reference - v.reference), word(v.type)));
  want_settable(v);
  constexpr std::size_t kLongest = 4096;
  if (value.size() > kLongest)
    throw base::Error(
        fmt::format("{}: {} letters, wanted at most {}", v.name, value.size(), kLongest));
  if (now_.texts[v.index] == value) return;
  now_.texts[v.index] = std::move(value);
  changed_ = true;
}

SavedState Instance::save() const {
  SavedState out = now_;
  if (tracker_) out.place = tracker_->place();
  return out;
}

void Instance::restore(const SavedState& state) {
  std::shared_ptr<const LoadedFiles> files =
      files_->texts == state.texts ? files_ : load_files(state.texts, resources_);
  const SavedState before = std::exchange(now_, state);
  const std::shared_ptr<const LoadedFiles> files_before = std::exchange(files_, std::move(files));
  changed_ = true;
  try {
    if (now_.started) build_car();
  } catch (...) {
    now_ = before;
    files_ = files_before;
    throw;
  }
  changed_ = now_.phase <= Phase::kInitialising;
  has_closed_ = false;
  tracker_.reset();
  if (!now_.started) return;
  if (files_->surface) {
    tracker_.emplace(*files_->surface);
    tracker_->go_on_from(now_.place);
  }
}

}  // namespace fmu
