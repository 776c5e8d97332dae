#include "sim/serve_unit.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>

#include "apart.h"
#include "base/error.h"
#include "command_socket.h"
#include "sim/message.h"
#include "sim/unit.h"
#include "sim/unpack.h"
#include "unit_places.h"

namespace sim {
namespace {

constexpr double kLate_s = 0.002;
constexpr int kMostPerStep = 64;
constexpr std::size_t kMostValues = 100'000'000;

double now_s() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void sleep_until(double time_s) {
  timespec until{};
  until.tv_sec = static_cast<time_t>(std::floor(time_s));
  until.tv_nsec = static_cast<long>(1e9 * (time_s - std::floor(time_s)));
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

/// What keeps a thread of 1 kHz on time, as far as this user may: scheduled before all others, its
/// memory held, and the processors kept from sleeping (those of a virtual machine that sleep are
/// given away, and come back up to 40 ms late).
class RealTime {
 public:
  RealTime() : latency_(::open("/dev/cpu_dma_latency", O_RDWR | O_CLOEXEC)) {
    sched_param priority{};
    priority.sched_priority = 10;
    is_scheduled_ = ::sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
    if (is_scheduled_) ::mlockall(MCL_CURRENT);
    const std::int32_t none = 0;  // microseconds to wake up
    if (latency_ >= 0 && ::write(latency_, &none, sizeof none) != sizeof none) close();
  }
  ~RealTime() { close(); }
  RealTime(const RealTime&) = delete;
  RealTime& operator=(const RealTime&) = delete;

  bool is_scheduled() const { return is_scheduled_; }

 private:
  void close() {
    if (latency_ >= 0) ::close(latency_);
    latency_ = -1;
  }

  int latency_;
  bool is_scheduled_ = false;
};

/// Numbers of a unit, read and written one by one; arrays as a whole behind it.
class Numbers {
 public:
  Numbers(Unit& unit, const std::string& path, const std::vector<std::string>& names)
      : unit_(unit) {
    for (const std::string& name : names) {
      places_.push_back(place_of(unit.description(), path, name));
      if (!is_number(*places_.back().variable))
        throw base::Error(fmt::format("{}: {} holds no number", path, name));
    }
  }

  /// Inputs, and parameters that may change while the unit runs.
  void want_settable(const std::string& path) const {
    for (const Place& place : places_)
      if (!place.variable->is_input() &&
          !(place.variable->causality == "parameter" && place.variable->variability == "tunable"))
        throw base::Error(fmt::format(
            "{}: {} is no input of the unit and no tunable parameter, it is: {} {}", path,
            place.variable->name, place.variable->variability, place.variable->causality));
  }

  std::vector<double> get() {
    std::vector<double> out;
    for (const Place& place : places_) {
      all_.resize(place.variable->size);
      unit_.get(*place.variable, all_);
      out.push_back(all_[place.index]);
    }
    return out;
  }

  void set(const std::vector<double>& values) {
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const UnitVariable& variable = *places_[k].variable;
      all_.resize(variable.size);
      if (variable.size > 1) unit_.get(variable, all_);
      all_[places_[k].index] = values[k];
      unit_.set(variable, all_);
    }
  }

 private:
  Unit& unit_;
  std::vector<Place> places_;
  std::vector<double> all_;
};

/// What is measured: numbers of the unit as they are, or as sensors tell them.
class Measurements {
 public:
  Measurements(Unit& unit, const std::string& path, const ServeOptions& options)
      : options_(options),
        sensors_(options.devices, options.step_s),
        truth_(unit, path, signals_of(options.devices)),
        direct_(unit, path, names_of(options, unit.description(), path)) {}

  /// As before the first step(), with the same noise.
  void restart(const ServeOptions& options) {
    sensors_ = vehicle::SignalSensors(options.devices, options.step_s);
  }

  /// After the initialisation and after every step.
  void step() {
    if (sensors_.size() > 0) sensors_.step(truth_.get());
  }

  std::vector<double> get() {
    const std::vector<double> direct = direct_.get();
    std::vector<double> out;
    for (const auto& [kind, index] : sources_) switch (kind) {
        case Kind::direct:
          out.push_back(direct[index]);
          break;
        case Kind::sensor:
          out.push_back(sensors_.value(index));
          break;
        case Kind::age:
          out.push_back(sensors_.age_s(index));
          break;
        case Kind::latitude:
          out.push_back(place_deg(index)[0]);
          break;
        case Kind::longitude:
          out.push_back(place_deg(index)[1]);
          break;
      }
    return out;
  }

 private:
  enum class Kind { direct, sensor, age, latitude, longitude };

  std::array<double, 2> place_deg(std::size_t position) const {
    const vehicle::SignalPosition& is = options_.devices.positions[position];
    return options_.to_latitude_longitude_deg(sensors_.value(is.x), sensors_.value(is.y));
  }

  static std::vector<std::string> signals_of(const vehicle::SignalSensorFile& file) {
    std::vector<std::string> out;
    for (const vehicle::SignalSensor& sensor : file.sensors) out.push_back(sensor.signal);
    return out;
  }

  static std::optional<std::pair<Kind, std::size_t>> place_of_name(const ServeOptions& options,
                                                                   const std::string& name,
                                                                   const std::string& path) {
    const auto& positions = options.devices.positions;
    for (std::size_t k = 0; k < positions.size(); ++k)
      for (const auto& [kind, ending] :
           {std::pair{Kind::latitude, ".latitude_deg"}, {Kind::longitude, ".longitude_deg"}}) {
        if (name != positions[k].name + ending) continue;
        if (!options.to_latitude_longitude_deg)
          throw base::Error(
              fmt::format("{}: {} needs a road whose header says where on the Earth it "
                          "lies (--road)",
                          path, name));
        return std::pair{kind, k};
      }
    return std::nullopt;
  }

  /// Fills sources_; gives the names that no sensor has.
  std::vector<std::string> names_of(const ServeOptions& options, const UnitDescription& unit,
                                    const std::string& path) {
    const auto& sensors = options.devices.sensors;
    for (const vehicle::SignalSensor& sensor : sensors)
      for (const std::string& name : {sensor.name, sensor.name + ".age_s"})
        if (unit.find(name) != nullptr)
          throw base::Error(fmt::format(
              "{}: the sensor {} has the name of a variable of the unit; call it otherwise", path,
              name));
    std::vector<std::string> direct;
    for (const std::string& name : options.measurements) {
      const auto sensor = std::find_if(sensors.begin(), sensors.end(), [&](const auto& one) {
        return name == one.name || name == one.name + ".age_s";
      });
      const std::optional<std::pair<Kind, std::size_t>> place = place_of_name(options, name, path);
      if (place) {
        sources_.push_back(*place);
      } else if (sensor == sensors.end()) {
        sources_.emplace_back(Kind::direct, direct.size());
        direct.push_back(name);
      } else {
        sources_.emplace_back(name == sensor->name ? Kind::sensor : Kind::age,
                              static_cast<std::size_t>(sensor - sensors.begin()));
      }
    }
    return direct;
  }

  const ServeOptions& options_;
  vehicle::SignalSensors sensors_;
  std::vector<std::pair<Kind, std::size_t>> sources_;
  Numbers truth_, direct_;
};

/// What may be commanded: numbers of the unit as they are, or as the devices' file has them.
class Commands {
 public:
  Commands(Unit& unit, const std::string& path, const ServeOptions& options)
      : numbers_(unit, path, signals_of(options)) {
    numbers_.want_settable(path);
  }

  /// As whoever commands would have said what the unit has.
  std::vector<double> get() {
    std::vector<double> values = numbers_.get();
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = are_[k].from_signal(values[k]);
    return values;
  }

  void set(std::vector<double> values) {
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = are_[k].to_signal(values[k]);
    numbers_.set(values);
  }

 private:
  /// Fills are_; gives the names of the unit.
  std::vector<std::string> signals_of(const ServeOptions& options) {
    std::vector<std::string> signals;
    for (const std::string& name : options.commands) {
      const auto& known = options.devices.commands;
      const auto found = std::find_if(known.begin(), known.end(),
                                      [&](const auto& one) { return one.name == name; });
      are_.push_back(found != known.end() ? *found : vehicle::SignalCommand{name, name});
      signals.push_back(are_.back().signal);
    }
    return signals;
  }

  std::vector<vehicle::SignalCommand> are_;
  Numbers numbers_;
};

class Server {
 public:
  Server(Unit& unit, const std::string& path, const ServeOptions& options, CommandSocket& socket,
         const std::function<void(Words)>& say)
      : unit_(unit),
        path_(path),
        options_(options),
        socket_(socket),
        say_(say),
        commands_(unit, path, options),
        measurements_(unit, path, options),
        recorded_(unit, path, options.recorded) {}

  void run() {
    asked_ = commands_.get();
    safe_ = asked_;
    for (const auto& [name, value] : options_.safe) {
      const auto found = std::find(options_.commands.begin(), options_.commands.end(), name);
      safe_[static_cast<std::size_t>(found - options_.commands.begin())] = value;
    }
    const auto steps = static_cast<std::uint64_t>(std::llround(options_.stop_s / options_.step_s));
    measurements_.step();
    measure();
    if (options_.lockstep)
      in_lockstep(steps);
    else
      in_real_time(steps);
    say_({'S', {reinterpret_cast<const char*>(&counts_), sizeof counts_}});
  }

 private:
  /// Whether the datagram is a command that counts.
  bool take(std::string_view bytes) {
    std::string why;
    const std::optional<CommandMessage> message = read_command(bytes, options_.commands, why);
    if (!message || !takes_starts(*message, why)) {
      if (++counts_.broken == 1) say_({'B', why});
      return false;
    }
    is_repeated_ = counts_.commands > 0 && message->sequence == sequence_;
    // While the safe input acts, a program that begins anew may count from anywhere.
    if (counts_.commands > 0 && message->sequence <= sequence_ && !is_safe_) {
      if (!is_repeated_) ++counts_.old;
      if (is_repeated_) socket_.answer_here();
      return false;
    }
    ++counts_.commands;
    sequence_ = message->sequence;
    is_binary_ = message->is_binary;
    is_paused_ = message->pauses.value_or(is_paused_);
    if (message->resets) reset(message->starts);
    for (std::size_t k = 0; k < asked_.size(); ++k)
      if (!std::isnan(message->values[k])) asked_[k] = message->values[k];
    counts_.asked_to_end = counts_.asked_to_end || message->ends;
    commanded_at_ = counts_.steps;
    socket_.answer_here();
    return true;
  }

  bool takes_starts(const CommandMessage& message, std::string& why) const {
    for (const auto& [name, value] : message.starts) {
      const UnitVariable* const variable = unit_.description().find(name);
      if (variable != nullptr && is_number(*variable) && variable->size == 1 &&
          (variable->is_input() || variable->causality == "parameter"))
        continue;
      why = "a start that is no number of a parameter or input of the unit";
      return false;
    }
    return true;
  }

  /// The unit begins anew at 0 s.
  void reset(const std::vector<std::pair<std::string, double>>& starts) {
    unit_.restart();
    for (const auto& [name, text] : options_.starts) set_start(unit_, path_, name, text);
    for (const auto& [name, value] : starts)
      unit_.set(*unit_.description().find(name), std::array{value});
    unit_.initialise(0.0, options_.stop_s);
    measurements_.restart(options_);
    measurements_.step();
    asked_ = commands_.get();
    acting_.clear();
    began_at_ = counts_.steps;
    was_reset_ = true;
    ++counts_.resets;
  }

  double time_s() const { return static_cast<double>(counts_.steps - began_at_) * options_.step_s; }

  /// False when the unit wants to end.
  bool step(bool is_safe) {
    is_safe_ = is_safe;
    if (is_safe) ++counts_.safe_steps;
    const std::vector<double>& acts = is_safe ? safe_ : asked_;
    if (acts != acting_) commands_.set(acting_ = acts);
    const double begin_s = now_s();
    const bool goes_on = unit_.step(time_s(), options_.step_s);
    measurements_.step();
    const double took_s = now_s() - begin_s;
    ++counts_.steps;
    counts_.step_sum_s += took_s;
    counts_.longest_step_s = std::max(counts_.longest_step_s, took_s);
    const auto bin = std::lower_bound(kStepBins_s.begin(), kStepBins_s.end(), took_s);
    ++counts_.bins[static_cast<std::size_t>(bin - kStepBins_s.begin())];
    counts_.ended_by_unit = !goes_on;
    return goes_on;
  }

  void measure() {
    last_ = {sequence_, time_s(), is_safe_, was_reset_, measurements_.get()};
    was_reset_ = false;
    std::vector<double> row{last_.time_s};
    row.insert(row.end(), last_.values.begin(), last_.values.end());
    const std::vector<double> recorded = recorded_.get();
    row.insert(row.end(), recorded.begin(), recorded.end());
    const std::vector<double>& acts = acting_.empty() ? asked_ : acting_;
    row.insert(row.end(), acts.begin(), acts.end());
    row.push_back(is_safe_ ? 1.0 : 0.0);
    row.push_back(static_cast<double>(counts_.resets));
    say_({'R', {reinterpret_cast<const char*>(row.data()), row.size() * sizeof(double)}});
  }

  void answer() { socket_.send(write_measurement(last_, options_.measurements, is_binary_)); }

  void in_lockstep(std::uint64_t steps) {
    double since_s = now_s();
    while (counts_.steps < steps) {
      const auto bytes = socket_.receive(std::min(1.0, options_.patience_s));
      if (!bytes) {
        counts_.silent = now_s() - since_s > options_.patience_s;
        if (counts_.silent) return;
        continue;
      }
      const bool counts = take(*bytes);
      if (!counts && is_repeated_) answer();
      is_repeated_ = false;
      if (!counts) continue;
      since_s = now_s();
      if (counts_.asked_to_end) return;
      // A reset is answered by what is measured at 0 s.
      const unsigned wanted = was_reset_ ? 0 : options_.every;
      for (unsigned k = 0; k < wanted && counts_.steps < steps; ++k)
        if (!step(false)) break;
      measure();
      answer();
      if (counts_.ended_by_unit) return;
    }
  }

  void in_real_time(std::uint64_t steps) {
    const RealTime real_time;
    counts_.real_time_scheduled = real_time.is_scheduled();
    const double tick_s = options_.step_s / options_.speed_up;
    double start_s = now_s();
    const auto safe_after =
        static_cast<std::uint64_t>(std::llround(options_.safe_after_s / options_.step_s));
    while (counts_.steps < steps && !counts_.asked_to_end) {
      const double due_s = start_s + static_cast<double>(counts_.steps) * tick_s;
      sleep_until(due_s);
      const double late_s = now_s() - due_s;
      counts_.latest_s = std::max(counts_.latest_s, late_s);
      if (late_s > kLate_s) ++counts_.late;
      int read = 0;
      for (; read < kMostPerStep; ++read) {
        const auto bytes = socket_.receive(0.0);
        if (!bytes) break;
        take(*bytes);
      }
      if (read == kMostPerStep) ++counts_.flooded;
      if (is_paused_) {
        start_s += tick_s;
        continue;
      }
      const bool goes_on = step(counts_.steps - commanded_at_ >= safe_after);
      if (counts_.steps % options_.every == 0 || !goes_on) {
        measure();
        answer();
      }
      if (!goes_on) return;
    }
  }

  Unit& unit_;
  const std::string& path_;
  const ServeOptions& options_;
  CommandSocket& socket_;
  const std::function<void(Words)>& say_;
  Commands commands_;
  Measurements measurements_;
  Numbers recorded_;
  ServeCounts counts_;
  std::vector<double> asked_, safe_, acting_;
  MeasurementMessage last_;
  std::uint32_t sequence_ = 0;
  std::uint64_t commanded_at_ = 0;
  std::uint64_t began_at_ = 0;  ///< step at which the unit's time was 0
  bool is_binary_ = false, is_safe_ = false, is_repeated_ = false, was_reset_ = false,
       is_paused_ = false;
};

void want_sound(const std::string& path, const ServeOptions& options) {
  const auto refuse = [&](const std::string& what) { throw base::Error(path + ": " + what); };
  if (!(options.step_s > 0.0) || !(options.stop_s > 0.0) || !(options.speed_up > 0.0) ||
      options.every == 0)
    refuse("step, stop, speed-up and the steps between measurements have to be above 0");
  if (options.measurements.empty() || options.commands.empty())
    refuse("nothing is measured or nothing is commanded; name both (--measure, --command)");
  for (const auto& [name, value] : options.safe)
    if (std::find(options.commands.begin(), options.commands.end(), name) == options.commands.end())
      refuse("the safe input " + name + " is no command of this run (--command)");
  const double rows = options.stop_s / options.step_s / options.every;
  if (!(rows * static_cast<double>(options.measurements.size() + options.recorded.size() +
                                   options.commands.size() + 3) <=
        kMostValues))
    refuse(fmt::format("{:.3g} measurements of {} values; measure fewer, or more seldom", rows,
                       options.measurements.size()));
}

}  // namespace

ServeRun serve_unit(const std::string& path, const ServeOptions& options,
                    const base::Progress& progress) {
  want_sound(path, options);
  const UnitDescription description = read_unit_description(model_description_of(path), path);
  ServeRun run;
  run.columns = {"time_s"};
  run.columns.insert(run.columns.end(), options.measurements.begin(), options.measurements.end());
  run.columns.insert(run.columns.end(), options.recorded.begin(), options.recorded.end());
  run.columns.insert(run.columns.end(), options.commands.begin(), options.commands.end());
  run.columns.emplace_back("safe");
  run.columns.emplace_back("resets");
  const UnpackedUnit files(path);
  CommandSocket socket(options.socket_path, options.udp_port);
  const SocketPath socket_path{options.socket_path};
  std::string refused;
  const std::string how = run_apart(
      [&](const std::function<void(Words)>& say) {
        Unit unit(files, description);
        for (const auto& [name, text] : options.starts) set_start(unit, path, name, text);
        unit.initialise(0.0, options.stop_s);
        Server(unit, path, options, socket, say).run();
      },
      [&] {
        std::error_code ignored;
        std::filesystem::remove_all(files.folder(), ignored);
        if (!options.socket_path.empty()) std::filesystem::remove(options.socket_path, ignored);
      },
      [&](Words words) {
        if (words.kind == 'E') refused = words.bytes;
        if (words.kind == 'B') run.first_broken = words.bytes;
        if (words.kind == 'S' && words.bytes.size() == sizeof run.counts)
          std::memcpy(&run.counts, words.bytes.data(), sizeof run.counts);
        if (words.kind != 'R' || words.bytes.size() != run.columns.size() * sizeof(double)) return;
        const std::size_t at = run.values.size();
        run.values.resize(at + run.columns.size());
        std::memcpy(run.values.data() + at, words.bytes.data(), words.bytes.size());
        if (progress) progress("steps", run.values[at] / options.stop_s);
      });
  if (!refused.empty()) throw base::Error(refused);
  want_no_crash(path, how,
                run.rows() == 0 ? std::nullopt
                                : std::optional(run.values[(run.rows() - 1) * run.columns.size()]));
  return run;
}

}  // namespace sim
