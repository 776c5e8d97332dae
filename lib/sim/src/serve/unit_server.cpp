#include "unit_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/one_line.h"
#include "command_check.h"
#include "input_writer.h"
#include "opponent_inputs.h"
#include "others_on_road.h"
#include "real_time.h"
#include "road_devices.h"
#include "served_values.h"
#include "teller.h"
#include "unit_places.h"

namespace sim {
namespace {

constexpr double kLate_s = 0.002;
constexpr int kMostPerStep = 64;

class Server {
 public:
  Server(const Connection& connection, Unit& unit, const std::string& path,
         const ServeOptions& options, Together& together, std::size_t own,
         const std::function<void(Words)>& say)
      : unit_(unit),
        path_(path),
        options_(options),
        connection_(connection),
        together_(together),
        own_(own),
        commands_(unit, path, options),
        measurements_(unit, path, options),
        inputs_(options.inputs, unit.description(), path),
        opponents_(options.opponents, OthersOnRoad::inputs_for(unit, together), unit.description(),
                   path),
        recorded_(unit, path, options.recorded),
        pose_(unit, path, pose_names(options)),
        others_(unit, path, together, own, options.lockstep),
        road_devices_(options.road, options.devices.road, options.devices.seed, options.step_s,
                      options.lockstep),
        teller_(say, !options.lockstep) {}

  void run() {
    inputs_.write(unit_, 0.0);
    asked_ = commands_.get();
    commands_.restart();
    safe_ = asked_;
    for (const auto& [name, value] : options_.safe) {
      const auto found = std::find(options_.commands.begin(), options_.commands.end(), name);
      safe_[static_cast<std::size_t>(found - options_.commands.begin())] = value;
    }
    std::string clipped, wrong = commands_.bring_within(safe_, clipped);
    if (!wrong.empty() || !clipped.empty())
      throw base::Error(path_ + ": of the safe input: " + (wrong.empty() ? clipped : wrong));
    const auto steps = static_cast<std::uint64_t>(std::llround(options_.stop_s / options_.step_s));
    measurements_.step();
    look();
    measure();
    teller_.tell('G', {});
    counts_.tells_its_place = others_.tells_its_place();
    counts_.others_seen = opponents_.others();
    std::optional<RealTime> real_time;
    if (!options_.lockstep) counts_.real_time_scheduled = real_time.emplace().is_scheduled();
    const double begin_s = together_.begin();
    if (options_.lockstep)
      in_lockstep(steps);
    else
      in_real_time(steps, begin_s);
    together_.leave(own_);
    counts_.late_sights = road_devices_.late();
    counts_.left_out_sights = road_devices_.left_out();
    teller_.tell('S', {reinterpret_cast<const char*>(&counts_), sizeof counts_});
    teller_.finish();
  }

 private:
  /// Into the log of the record.
  void log(const Remark& remark) {
    if (options_.keep_remark && remarks_++ < kMostRemarks)
      teller_.tell('M', write_remark(remark, false));
  }

  bool refuse(const Received& received, const std::string& why) {
    const Remark remark{"refused", why, received.sequence, time_s(), counts_.resets};
    connection_.refuse(remark);
    log(remark);
    is_refused_ = received.sequence.has_value();  // what has a number is of somebody who drives
    return false;
  }
  bool refuse_as_broken(const Received& received, const std::string& why) {
    if (++counts_.broken == 1) teller_.tell('B', why);
    return refuse(received, why);
  }

  /// Whether it is a command that counts.
  bool take(const Received& received) {
    if (received.watches) return false;
    if (!received.command) return refuse_as_broken(received, received.why);
    CommandMessage message = *received.command;
    std::string clipped, why = wrong_with(message, unit_);
    if (why.empty()) why = commands_.bring_within(message.values, clipped);
    if (!why.empty()) return refuse_as_broken(received, why);
    is_repeated_ = counts_.commands > 0 && message.sequence == sequence_;
    // While the safe input acts, a program that begins anew may count from anywhere.
    if (counts_.commands > 0 && message.sequence <= sequence_ && !is_safe_) {
      if (is_repeated_) {
        connection_.answer_here();
        return false;
      }
      ++counts_.old;
      return refuse(received,
                    fmt::format("the sequence number {} came after {}; a larger one wanted",
                                message.sequence, sequence_));
    }
    try {
      if (!message.save.empty()) save(message.save);
      if (message.resets && message.state.empty()) reset(message.starts);
      if (message.resets && !message.state.empty()) go_back(message.state);
    } catch (const base::Error& error) {
      if (!unit_.is_there()) park(error.what());
      return refuse_as_broken(received, error.what());
    }
    ++counts_.commands;
    sequence_ = message.sequence;
    if (message.pauses) together_.pause(*message.pauses);
    for (std::size_t k = 0; k < asked_.size(); ++k)
      if (!std::isnan(message.values[k])) asked_[k] = message.values[k];
    counts_.asked_to_end = counts_.asked_to_end || message.ends;
    commanded_at_ = counts_.steps;
    connection_.answer_here();
    if (!clipped.empty()) {
      ++counts_.clipped;
      log({"clipped", clipped, sequence_, time_s(), counts_.resets});
      clipped_ = clipped;
    }
    if (message.plan) show(tell_sight(Plan{sequence_, time_s(), *message.plan}));
    if (message.resets && message.state.empty()) look();
    return true;
  }

  /// To whoever drives, and into the record.
  void show(const ToldSight& seen) {
    connection_.show(seen);
    if (options_.keep_sight) teller_.tell('P', seen.line);
  }

  void look() {
    if (road_devices_.empty()) return;
    const std::vector<double> pose = pose_.get();
    Pose now{};
    std::copy_n(pose.begin(), now.size(), now.begin());
    road_devices_.step(now);
    for (const ToldSight& seen : road_devices_.arrived()) show(seen);
  }

  /// What changes beside the unit.
  struct Kept {
    vehicle::SignalSensors sensors;
    Commands::Moving moving;
    RoadDevices::Progress road_devices;
    OpponentInputs opponents;
    std::vector<double> asked;
    std::uint64_t steps;  ///< since the unit's time was 0
  };

  void save(const std::string& name) {
    unit_.save(name);
    kept_.insert_or_assign(
        name, Kept{measurements_.sensors(), commands_.moving(), road_devices_.progress(),
                   opponents_, asked_, counts_.steps - began_at_});
  }

  /// As it was when it was saved; sensors go on from there.
  void go_back(const std::string& name) {
    const Kept& kept = kept_.at(name);
    unit_.restore(name);
    measurements_.restore(kept.sensors);
    commands_.restore(kept.moving);
    road_devices_.restore(kept.road_devices);
    opponents_ = kept.opponents;
    asked_ = kept.asked;
    inputs_.restart();
    began_at_ = counts_.steps - kept.steps;
    go_on_from_there();
  }

  /// The unit begins anew at 0 s. Throws Error, with nothing changed, where it does not take that.
  void reset(const std::vector<std::pair<std::string, double>>& starts) {
    unit_.begin_anew([&] {
      for (const auto& [name, text] : options_.starts) set_start(unit_, path_, name, text);
      for (const auto& [name, value] : starts)
        unit_.set(*unit_.description().find(name), std::array{value});
      unit_.initialise(0.0, options_.stop_s);
    });
    measurements_.restart();
    measurements_.step();
    road_devices_.restart();
    inputs_.restart();
    inputs_.write(unit_, 0.0);
    asked_ = commands_.get();
    commands_.restart();
    began_at_ = counts_.steps;
    go_on_from_there();
  }

  void go_on_from_there() {
    acting_.clear();
    was_reset_ = true;
    ++counts_.resets;
    parked_.clear();
    counts_.is_parked = false;
    recorded_at_.reset();
  }

  /// The unit stands as it was before the step that failed.
  void park(const std::string& why) {
    if (parked_.empty()) {
      try {
        measure();                    // what it did since the last time
      } catch (const base::Error&) {  // it tells nothing any more: the last that it told stays
      }
    }
    parked_ = base::one_line(why);
    counts_.is_parked = true;
    if (++counts_.parked == 1) teller_.tell('K', parked_);
    log({"parked", parked_, sequence_, time_s(), counts_.resets});
  }

  double time_s() const { return static_cast<double>(counts_.steps - began_at_) * options_.step_s; }

  /// False when the unit wants to end, or nobody drives any of the run.
  bool step(bool is_safe) {
    if (!others_.see(counts_.steps, !counts_.silent, !parked_.empty())) return false;
    is_safe_ = is_safe;
    if (is_safe) ++counts_.safe_steps;
    bool goes_on = true;
    if (parked_.empty()) try {
        goes_on = step_unit(is_safe ? safe_ : asked_);
      } catch (const base::Error& error) {
        park(error.what());
      }
    ++counts_.steps;
    if (!parked_.empty()) ++began_at_;  // its time stands still too
    counts_.ended_by_unit = !goes_on;
    if (parked_.empty()) look();
    return goes_on;
  }

  bool step_unit(const std::vector<double>& acts) {
    acting_ = acts;
    if (const std::string why = commands_.act(acts); !why.empty()) {
      acting_ = asked_ = commands_.get();
      const Remark remark{"refused", base::one_line(why), sequence_, time_s(), counts_.resets};
      connection_.refuse(remark);
      log(remark);
    }
    const double begin_s = now_s();
    inputs_.write(unit_, time_s());
    opponents_.write(unit_, time_s(), others_.places());
    const bool goes_on = unit_.step(time_s(), options_.step_s);
    measurements_.step();
    count_step(counts_, now_s() - begin_s);
    return goes_on;
  }

  /// What is infinite or no number is told to nobody: the unit stands, as after an error.
  void measure() {
    std::vector<double> values = parked_.empty() ? measurements_.get() : last_.values;
    const std::string wrong = not_finite_of(options_.measurements, values, time_s());
    if (!wrong.empty() && last_.values.empty()) throw base::Error(path_ + ": " + wrong);
    if (!wrong.empty()) park(parked_ = path_ + ": " + wrong);
    if (!wrong.empty()) values = last_.values;
    last_ = {sequence_,
             time_s(),
             is_safe_,
             std::exchange(was_reset_, false),
             std::move(values),
             std::exchange(clipped_, {}),
             parked_};
    if (parked_.empty() && recorded_at_ != last_.time_s) record();
  }

  void record() {
    recorded_at_ = last_.time_s;
    const std::vector<double> row =
        row_of(last_, recorded_.get(), acting_.empty() ? asked_ : acting_, counts_.resets);
    teller_.tell('R', {reinterpret_cast<const char*>(row.data()), row.size() * sizeof(double)});
  }

  void answer(bool again = false) { connection_.send(last_, again); }

  /// The next command that counts. False when none came in time.
  bool wait_for_command() {
    double since_s = now_s();
    while (now_s() - since_s <= options_.patience_s) {
      const auto received = connection_.receive(std::min(1.0, options_.patience_s));
      // Who only watches does not drive.
      if (received && take(*received)) return true;
      if (is_repeated_) answer(true);
      if (is_repeated_ || is_refused_) since_s = now_s();
      is_repeated_ = is_refused_ = false;
    }
    return false;
  }

  void in_lockstep(std::uint64_t steps) {
    while (counts_.steps < steps) {
      // Who stayed out is not waited for again: the same bytes, however long that took.
      if (!counts_.silent) counts_.silent = !wait_for_command();
      is_repeated_ = false;
      if (counts_.asked_to_end) return;
      // A reset is answered by what is measured at 0 s.
      const std::uint64_t last = std::min(steps, counts_.steps + (was_reset_ ? 0 : options_.every));
      bool goes_on = true;
      while (goes_on && counts_.steps < last) goes_on = step(counts_.silent);
      if (!goes_on && !counts_.ended_by_unit) return;
      measure();
      if (!counts_.silent) answer();
      if (counts_.ended_by_unit) return;
    }
  }

  void in_real_time(std::uint64_t steps, double start_s) {
    const double tick_s = options_.step_s / options_.speed_up;
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
      if (together_.is_paused()) {
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
  Together& together_;
  const std::size_t own_;  ///< of together_
  Commands commands_;
  Measurements measurements_;
  InputWriter inputs_;
  OpponentInputs opponents_;
  Numbers recorded_, pose_;
  OthersOnRoad others_;
  RoadDevices road_devices_;
  ServeCounts counts_;
  std::vector<double> asked_, safe_, acting_;
  std::map<std::string, Kept> kept_;
  MeasurementMessage last_;
  std::uint32_t sequence_ = 0;
  std::uint64_t commanded_at_ = 0;
  std::uint64_t began_at_ = 0;  ///< step at which the unit's time was 0
  bool is_safe_ = false, is_repeated_ = false, is_refused_ = false, was_reset_ = false;
  std::string clipped_, parked_;       ///< to be told; why the unit stands still
  std::optional<double> recorded_at_;  ///< time of the last row of this run from a reset on
  std::uint64_t remarks_ = 0;
  Teller teller_;
};

}  // namespace

void serve_by(const Connection& connection, Unit& unit, const std::string& path,
              const ServeOptions& options, Together& together, std::size_t k,
              const std::function<void(Words)>& say) {
  Server(connection, unit, path, options, together, k, say).run();
}

}  // namespace sim
