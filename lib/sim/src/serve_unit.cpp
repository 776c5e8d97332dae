#include "sim/serve_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>

#include "apart.h"
#include "base/error.h"
#include "command_socket.h"
#include "connection.h"
#include "dds_connection.h"
#include "input_writer.h"
#include "opponent_inputs.h"
#include "real_time.h"
#include "road_devices.h"
#include "served_values.h"
#include "sim/dds.h"
#include "sim/message.h"
#include "sim/unit.h"
#include "sim/unpack.h"
#include "socket_connection.h"
#include "topics.h"
#include "unit_places.h"
#include "worker.h"

namespace sim {
namespace {

constexpr double kLate_s = 0.002;
constexpr int kMostPerStep = 64;
constexpr std::size_t kMostValues = 100'000'000;
constexpr std::size_t kMostUntold = 1u << 28;  ///< bytes that wait for the process of the record

class Server {
 public:
  Server(Unit& unit, const std::string& path, const ServeOptions& options,
         const Connection& connection, const std::function<void(Words)>& say)
      : unit_(unit),
        path_(path),
        options_(options),
        connection_(connection),
        say_(say),
        commands_(unit, path, options),
        measurements_(unit, path, options),
        inputs_(options.inputs, unit.description(), path),
        opponents_(options.opponents, unit.description(), path),
        recorded_(unit, path, options.recorded),
        pose_(unit, path, pose_names(options)),
        road_devices_(options.road, options.devices.road, options.devices.seed, options.step_s,
                      options.lockstep) {
    if (!options.lockstep) teller_.emplace();
  }

  void run() {
    inputs_.write(unit_, 0.0);
    asked_ = commands_.get();
    safe_ = asked_;
    for (const auto& [name, value] : options_.safe) {
      const auto found = std::find(options_.commands.begin(), options_.commands.end(), name);
      safe_[static_cast<std::size_t>(found - options_.commands.begin())] = value;
    }
    const auto steps = static_cast<std::uint64_t>(std::llround(options_.stop_s / options_.step_s));
    measurements_.step();
    look();
    measure();
    if (options_.lockstep)
      in_lockstep(steps);
    else
      in_real_time(steps);
    counts_.late_sights = road_devices_.late();
    counts_.left_out_sights = road_devices_.left_out();
    tell('S', {reinterpret_cast<const char*>(&counts_), sizeof counts_});
    if (teller_) teller_->finish();
  }

 private:
  /// To the process that keeps the record; in real time beside the loop: its pipe may be full.
  void tell(char kind, std::string_view bytes) {
    if (!teller_) return say_({kind, bytes});
    if (untold_bytes_ > kMostUntold) teller_->finish();
    untold_bytes_ += bytes.size();
    teller_->give([this, kind, kept = std::string(bytes)] {
      say_({kind, kept});
      untold_bytes_ -= kept.size();
    });
  }

  /// Whether it is a command that counts.
  bool take(const Received& received) {
    if (received.watches) return false;
    const std::optional<CommandMessage>& message = received.command;
    std::string why = received.why;
    if (!message || !takes_starts(*message, why)) {
      if (++counts_.broken == 1) tell('B', why);
      return false;
    }
    is_repeated_ = counts_.commands > 0 && message->sequence == sequence_;
    // While the safe input acts, a program that begins anew may count from anywhere.
    if (counts_.commands > 0 && message->sequence <= sequence_ && !is_safe_) {
      if (!is_repeated_) ++counts_.old;
      if (is_repeated_) connection_.answer_here();
      return false;
    }
    ++counts_.commands;
    sequence_ = message->sequence;
    is_paused_ = message->pauses.value_or(is_paused_);
    if (message->resets) reset(message->starts);
    for (std::size_t k = 0; k < asked_.size(); ++k)
      if (!std::isnan(message->values[k])) asked_[k] = message->values[k];
    counts_.asked_to_end = counts_.asked_to_end || message->ends;
    commanded_at_ = counts_.steps;
    connection_.answer_here();
    if (message->plan) show(tell_sight(Plan{sequence_, time_s(), *message->plan}));
    if (message->resets) look();
    return true;
  }

  /// To whoever drives, and into the record.
  void show(const ToldSight& seen) {
    connection_.show(seen);
    if (options_.keep_sight) tell('P', seen.line);
  }

  void look() {
    if (road_devices_.empty()) return;
    const std::vector<double> pose = pose_.get();
    Pose now{};
    std::copy_n(pose.begin(), now.size(), now.begin());
    road_devices_.step(now);
    for (const ToldSight& seen : road_devices_.arrived()) show(seen);
  }

  static std::vector<std::string> pose_names(const ServeOptions& options) {
    const auto& names = options.devices.road.pose;
    if (options.devices.road.empty()) return {};
    return {names.begin(), names.end()};
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
    measurements_.restart();
    measurements_.step();
    road_devices_.restart();
    inputs_.restart();
    inputs_.write(unit_, 0.0);
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
    inputs_.write(unit_, time_s());
    opponents_.write(unit_, time_s());
    const bool goes_on = unit_.step(time_s(), options_.step_s);
    measurements_.step();
    const double took_s = now_s() - begin_s;
    ++counts_.steps;
    counts_.step_sum_s += took_s;
    counts_.longest_step_s = std::max(counts_.longest_step_s, took_s);
    const auto bin = std::lower_bound(kStepBins_s.begin(), kStepBins_s.end(), took_s);
    ++counts_.bins[static_cast<std::size_t>(bin - kStepBins_s.begin())];
    counts_.ended_by_unit = !goes_on;
    look();
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
    tell('R', {reinterpret_cast<const char*>(row.data()), row.size() * sizeof(double)});
  }

  void answer(bool again = false) { connection_.send(last_, again); }

  void in_lockstep(std::uint64_t steps) {
    double since_s = now_s();
    while (counts_.steps < steps) {
      const auto received = connection_.receive(std::min(1.0, options_.patience_s));
      const bool counts = received && take(*received);
      if (counts || is_repeated_) since_s = now_s();
      if (!counts && is_repeated_) answer(true);
      is_repeated_ = false;
      if (!counts) {
        // Who only watches does not drive.
        counts_.silent = now_s() - since_s > options_.patience_s;
        if (counts_.silent) return;
        continue;
      }
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
        const auto received = connection_.receive(0.0);
        if (!received) break;
        take(*received);
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
  const Connection& connection_;
  const std::function<void(Words)>& say_;
  Commands commands_;
  Measurements measurements_;
  InputWriter inputs_;
  OpponentInputs opponents_;
  Numbers recorded_, pose_;
  RoadDevices road_devices_;
  ServeCounts counts_;
  std::vector<double> asked_, safe_, acting_;
  MeasurementMessage last_;
  std::uint32_t sequence_ = 0;
  std::uint64_t commanded_at_ = 0;
  std::uint64_t began_at_ = 0;  ///< step at which the unit's time was 0
  bool is_safe_ = false, is_repeated_ = false, was_reset_ = false, is_paused_ = false;
  std::atomic<std::size_t> untold_bytes_ = 0;
  std::optional<Worker> teller_;  ///< in real time; last: it uses the others
};

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void want_sound(const std::string& path, const ServeOptions& options) {
  const auto refuse = [&](const std::string& what) { throw base::Error(path + ": " + what); };
  if (!(options.step_s > 0.0) || !(options.stop_s > 0.0) || !(options.speed_up > 0.0) ||
      options.every == 0)
    refuse("step, stop, speed-up and the steps between measurements have to be above 0");
  if (options.measurements.empty() || options.commands.empty())
    refuse("nothing is measured or nothing is commanded; name both (--measure, --command)");
  for (const auto& [name, value] : options.safe)
    if (!has(options.commands, name))
      refuse("the safe input " + name + " is no command of this run (--command)");
  for (const std::string& name : options.inputs.names)
    if (has(options.commands, name))
      refuse(name + " is a command of this run and follows a table too; one of both");
  const double rows = options.stop_s / options.step_s / options.every;
  if (!(rows * static_cast<double>(options.measurements.size() + options.recorded.size() +
                                   options.commands.size() + 3) <=
        kMostValues))
    refuse(fmt::format("{:.3g} measurements of {} values; measure fewer, or more seldom", rows,
                       options.measurements.size()));
}

/// With the columns of its table. A command that is measured or recorded too, which is what the
/// unit has, is NAME.commanded there. Throws Error where two columns would have one name.
ServeRun run_of(const std::string& path, const ServeOptions& options) {
  ServeRun run;
  run.columns = {"time_s", "safe", "resets"};
  const auto add = [&](const std::string& name) {
    if (has(run.columns, name))
      throw base::Error(fmt::format(
          "{}: the record would have two columns {}; name it once (--measure, --command; "
          "time_s, safe and resets are columns of its own)",
          path, name));
    run.columns.insert(run.columns.end() - 2, name);
  };
  for (const auto* const names : {&options.measurements, &options.recorded})
    std::for_each(names->begin(), names->end(), add);
  for (const std::string& name : options.commands)
    add(has(options.measurements, name) || has(options.recorded, name) ? name + ".commanded"
                                                                       : name);
  return run;
}

}  // namespace

ServeRun serve_unit(const std::string& path, const ServeOptions& wanted,
                    const base::Progress& progress) {
  const UnitDescription description = read_unit_description(model_description_of(path), path);
  ServeOptions options = wanted;
  TopicPlan topics;
  if (options.dds_domain) {
    require_dds("topics of ROS 2");
    topics = plan_topics(options, description, path);
  }
  // What follows a table is recorded, as what is measured is; once.
  options.recorded.clear();
  for (const auto* const names : {&wanted.recorded, &wanted.inputs.names})
    for (const std::string& name : *names)
      if (!has(options.recorded, name) && !has(options.measurements, name))
        options.recorded.push_back(name);
  want_sound(path, options);
  ServeRun run = run_of(path, options);
  const UnpackedUnit files(path);
  std::optional<CommandSocket> socket;
  if (!options.dds_domain) socket.emplace(options.socket_path, options.udp_port);
  const SocketPath socket_path{options.dds_domain ? "" : options.socket_path};
  std::string refused;
  const std::string how = run_apart(
      [&](const std::function<void(Words)>& say) {
        Unit unit(files, description);
        for (const auto& [name, text] : options.starts) set_start(unit, path, name, text);
        unit.initialise(0.0, options.stop_s);
        const Connection connection =
            options.dds_domain ? connect_dds(*options.dds_domain, topics, options.lockstep)
                               : connection_by(*socket, options);
        Server(unit, path, options, connection, say).run();
      },
      [&] {
        std::error_code ignored;
        std::filesystem::remove_all(files.folder(), ignored);
        if (!socket_path.path.empty()) std::filesystem::remove(socket_path.path, ignored);
      },
      [&](Words words) {
        if (words.kind == 'E') refused = words.bytes;
        if (words.kind == 'B') run.first_broken = words.bytes;
        if (words.kind == 'P') options.keep_sight(words.bytes);
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
