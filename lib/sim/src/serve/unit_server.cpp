#include "unit_server.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "input_writer.h"
#include "opponent_inputs.h"
#include "real_time.h"
#include "road_devices.h"
#include "served_values.h"
#include "unit_places.h"
#include "worker.h"

namespace sim {
namespace {

constexpr double kLate_s = 0.002;
constexpr int kMostPerStep = 64;
constexpr std::size_t kMostUntold = 1u << 28;  ///< bytes that wait for the process of the record

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
        say_(say),
        commands_(unit, path, options),
        measurements_(unit, path, options),
        inputs_(options.inputs, unit.description(), path),
        opponents_(options.opponents, others_of(unit, together), unit.description(), path),
        recorded_(unit, path, options.recorded),
        pose_(unit, path, pose_names(options)),
        place_(unit, path, place_names(unit, together)),
        road_devices_(options.road, options.devices.road, options.devices.seed, options.step_s,
                      options.lockstep) {
    if (!options.lockstep) teller_.emplace();
  }

  void run() {
    inputs_.write(unit_, 0.0);
    asked_ = commands_.get();
    commands_.restart();
    safe_ = asked_;
    for (const auto& [name, value] : options_.safe) {
      const auto found = std::find(options_.commands.begin(), options_.commands.end(), name);
      safe_[static_cast<std::size_t>(found - options_.commands.begin())] = value;
    }
    const auto steps = static_cast<std::uint64_t>(std::llround(options_.stop_s / options_.step_s));
    measurements_.step();
    look();
    measure();
    tell('G', {});
    counts_.tells_its_place = !place_.empty();
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
    if (!message || !takes_starts(*message, why) || !takes_states(*message, why)) {
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
    if (message->pauses) together_.pause(*message->pauses);
    if (!message->save.empty()) save(message->save);
    if (message->resets && message->state.empty()) reset(message->starts);
    if (message->resets && !message->state.empty()) go_back(message->state);
    for (std::size_t k = 0; k < asked_.size(); ++k)
      if (!std::isnan(message->values[k])) asked_[k] = message->values[k];
    counts_.asked_to_end = counts_.asked_to_end || message->ends;
    commanded_at_ = counts_.steps;
    connection_.answer_here();
    if (message->plan) show(tell_sight(Plan{sequence_, time_s(), *message->plan}));
    if (message->resets && message->state.empty()) look();
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

  /// As many as share the road, where the unit has inputs for them.
  static std::size_t others_of(const Unit& unit, const Together& together) {
    return OpponentInputs::are_of(unit.description()) ? together.size() - 1 : 0;
  }

  /// Where it is on the map, where others want to know and it can tell.
  static std::vector<std::string> place_names(const Unit& unit, const Together& together) {
    const std::vector<std::string> names{"car.x", "car.y"};
    const bool tells = together.size() > 1 &&
                       std::all_of(names.begin(), names.end(), [&](const std::string& name) {
                         return unit.description().find(name) != nullptr;
                       });
    return tells ? names : std::vector<std::string>{};
  }

  /// Puts the others where they are at the begin of this step. False when nobody drives any more.
  bool see_others() {
    Standing own;
    own.is_driven = !counts_.silent;
    if (!place_.empty()) {
      const std::vector<double> at = place_.get();
      own = {std::isfinite(at[0]) && std::isfinite(at[1]), at[0], at[1], own.is_driven};
    }
    const std::span<const Standing> all = options_.lockstep
                                              ? together_.meet(own_, counts_.steps, own)
                                              : together_.look(own_, counts_.steps, own);
    others_.clear();
    bool is_driven = false;
    for (std::size_t k = 0; k < all.size(); ++k) {
      is_driven = is_driven || all[k].is_driven;
      if (k == own_) continue;
      others_.emplace_back();
      if (all[k].is_there) others_.back() = vehicle::OpponentPlace{all[k].x_m, all[k].y_m};
    }
    return is_driven;
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

  bool takes_states(const CommandMessage& message, std::string& why) const {
    if (!message.save.empty() && !unit_.description().keeps_states)
      why = "a state to save, which this unit cannot (its description says so)";
    else if (!message.save.empty() && !unit_.has_saved(message.save) &&
             unit_.saved_states() >= kMostSavedStates)
      why = "a 17th state to save; save under a name that is there already";
    else if (!message.state.empty() && !unit_.has_saved(message.state))
      why = "a state that was not saved";
    else
      return true;
    return false;
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
    acting_.clear();
    began_at_ = counts_.steps - kept.steps;
    was_reset_ = true;
    ++counts_.resets;
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
    commands_.restart();
    acting_.clear();
    began_at_ = counts_.steps;
    was_reset_ = true;
    ++counts_.resets;
  }

  double time_s() const { return static_cast<double>(counts_.steps - began_at_) * options_.step_s; }

  /// False when the unit wants to end, or nobody drives any of the run.
  bool step(bool is_safe) {
    if (!see_others()) return false;
    is_safe_ = is_safe;
    if (is_safe) ++counts_.safe_steps;
    const std::vector<double>& acts = is_safe ? safe_ : asked_;
    commands_.act(acting_ = acts);
    const double begin_s = now_s();
    inputs_.write(unit_, time_s());
    opponents_.write(unit_, time_s(), others_);
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

  /// The next command that counts. False when none came in time.
  bool wait_for_command() {
    double since_s = now_s();
    while (now_s() - since_s <= options_.patience_s) {
      const auto received = connection_.receive(std::min(1.0, options_.patience_s));
      // Who only watches does not drive.
      if (received && take(*received)) return true;
      if (is_repeated_) {
        since_s = now_s();
        answer(true);
      }
      is_repeated_ = false;
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
  const std::function<void(Words)>& say_;
  Commands commands_;
  Measurements measurements_;
  InputWriter inputs_;
  OpponentInputs opponents_;
  Numbers recorded_, pose_, place_;
  std::vector<std::optional<vehicle::OpponentPlace>> others_;
  RoadDevices road_devices_;
  ServeCounts counts_;
  std::vector<double> asked_, safe_, acting_;
  std::map<std::string, Kept> kept_;
  MeasurementMessage last_;
  std::uint32_t sequence_ = 0;
  std::uint64_t commanded_at_ = 0;
  std::uint64_t began_at_ = 0;  ///< step at which the unit's time was 0
  bool is_safe_ = false, is_repeated_ = false, was_reset_ = false;
  std::atomic<std::size_t> untold_bytes_ = 0;
  std::optional<Worker> teller_;  ///< in real time; last: it uses the others
};

}  // namespace

void serve_by(const Connection& connection, Unit& unit, const std::string& path,
              const ServeOptions& options, Together& together, std::size_t k,
              const std::function<void(Words)>& say) {
  Server(connection, unit, path, options, together, k, say).run();
}

}  // namespace sim
