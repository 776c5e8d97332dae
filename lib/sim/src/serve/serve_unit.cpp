#include "sim/serve_unit.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "apart.h"
#include "base/error.h"
#include "base/one_line.h"
#include "command_socket.h"
#include "dds_connection.h"
#include "sim/dds.h"
#include "sim/unit.h"
#include "sim/unpack.h"
#include "socket_connection.h"
#include "together.h"
#include "topics.h"
#include "unit_places.h"
#include "unit_server.h"

namespace sim {
namespace {

constexpr std::size_t kMostValues = 100'000'000;

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
  if (!options.keep_row &&
      !(rows * static_cast<double>(options.measurements.size() + options.recorded.size() +
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

/// A unit of a run: what it needs, its process, and what came of it.
class Served {
 public:
  Served(const std::string& path, const ServeOptions& options)
      : path_(path),
        description_(
            read_unit_description(model_description_of(path, road_of(options.starts)), path)),
        options_(options) {
    if (options_.dds_domain) {
      require_dds("topics of ROS 2");
      topics_ = plan_topics(options_, description_, path_);
    }
    // What follows a table is recorded, as what is measured is; once.
    options_.recorded.clear();
    for (const auto* const names : {&options.recorded, &options.inputs.names})
      for (const std::string& name : *names)
        if (!has(options_.recorded, name) && !has(options_.measurements, name))
          options_.recorded.push_back(name);
    want_sound(path_, options_);
    run_ = run_of(path_, options_);
    files_.emplace(path_, road_of(options_.starts));
  }

  void start(Together& together, std::size_t k) {
    std::optional<CommandSocket> socket;
    if (!options_.dds_domain) {
      socket.emplace(options_.socket_path, options_.udp_port);
      socket_path_.path = options_.socket_path;
    }
    ApartPlace place{files_->folder(), options_.limits};
    place.limits.trusted = place.limits.trusted || is_vehicle_file(path_);
    if (socket) place.keep.push_back(socket->descriptor());
    place.real_time = !options_.lockstep;
    std::optional<Connection> connection;  // of its process alone
    place.before = [&] {
      connection.emplace(options_.dds_domain
                             ? connect_dds(*options_.dds_domain, topics_, options_.lockstep)
                             : connection_by(*socket, options_));
    };
    process_.emplace(
        place,
        [&, k](const std::function<void(Words)>& say, Watch* watch) {
          const Connection by = *std::exchange(connection, {});
          std::vector<std::string> lines;  // errors are told as they come
          const auto keep = [&](const std::string& line, bool closes) {
            if (closes && lines.size() < kMostLogLines) lines.push_back(line);
          };
          std::optional<Unit> unit(std::in_place, *files_, description_, keep, watch);
          for (const auto& [name, text] : options_.starts) set_start(*unit, path_, name, text);
          unit->initialise(0.0, options_.stop_s);
          serve_by(by, *unit, path_, options_, together, k, say);
          unit.reset();
          for (const std::string& line : lines) say({'L', line});
        },
        [&] {
          std::error_code ignored;
          std::filesystem::remove_all(files_->folder(), ignored);
          if (!socket_path_.path.empty()) std::filesystem::remove(socket_path_.path, ignored);
        });
    // Only its own process has the socket now: who drives learns when that ends.
  }

  int descriptor() const { return process_->descriptor(); }

  /// The next of what its process says. False when that has ended.
  bool hear() {
    const std::optional<Words> words = process_->hear();
    if (!words) {
      const Ending ending = process_->ending();
      if (run_.failed.empty())
        run_.failed = crash_of(path_, ending,
                               run_.rows() == 0 ? std::nullopt : std::optional(run_.reached_s));
      if (!run_.failed.empty()) run_.failed += refused_to(ending);
      run_.refused = ending.refused;
      return false;
    }
    const auto& [kind, bytes] = *words;
    if (kind == 'E') run_.failed = base::visible(bytes);
    if (kind == 'G') is_ready_ = true;
    if (kind == 'B') run_.first_broken = base::visible(bytes);
    if (kind == 'K') run_.first_parked = base::visible(bytes);
    if (kind == 'P') options_.keep_sight(bytes);
    if (kind == 'M') options_.keep_remark(bytes);
    if (kind == 'L' && run_.log.size() < kMostLogLines) {
      run_.log.push_back(base::visible(bytes));
      const Remark said{"said", run_.log.back(), {}, run_.reached_s, run_.counts.resets};
      if (options_.keep_remark) options_.keep_remark(write_remark(said, false));
    }
    if (kind == 'S' && bytes.size() == sizeof run_.counts)
      std::memcpy(&run_.counts, bytes.data(), sizeof run_.counts);
    if (kind != 'R' || bytes.size() != run_.columns.size() * sizeof(double)) return true;
    row_.resize(run_.columns.size());
    std::memcpy(row_.data(), bytes.data(), bytes.size());
    ++run_.row_count;
    run_.reached_s = row_[0];
    if (run_.not_finite.empty()) run_.not_finite = not_finite_of(run_.columns, row_, row_[0]);
    if (options_.keep_row)
      options_.keep_row(run_.columns, row_);
    else
      run_.values.insert(run_.values.end(), row_.begin(), row_.end());
    return true;
  }

  bool is_ready() const { return is_ready_; }  ///< it waits for the others to begin
  ServeRun& run() { return run_; }

 private:
  std::string path_;
  UnitDescription description_;
  ServeOptions options_;
  TopicPlan topics_;
  ServeRun run_;
  std::vector<double> row_;
  bool is_ready_ = false;
  std::optional<UnpackedUnit> files_;
  SocketPath socket_path_;
  std::optional<Apart> process_;  ///< last: it uses the others
};

void want_one_clock(const std::vector<ServedUnit>& units) {
  if (units.empty() || units.size() > Together::kMost)
    throw base::Error(
        fmt::format("{} units in one run; 1 to {} wanted", units.size(), Together::kMost));
  const ServeOptions& first = units[0].options;
  for (const auto& [name, path, options] : units)
    if (options.step_s != first.step_s || options.stop_s != first.stop_s ||
        options.speed_up != first.speed_up || options.lockstep != first.lockstep)
      throw base::Error(fmt::format(
          "{}: its steps, stop, speed-up or lockstep are not those of {}; one clock for all wanted",
          name, units[0].name));
}

/// Takes what the units say until all have ended.
void hear_all(const std::vector<std::unique_ptr<Served>>& served, Together& together, double stop_s,
              const base::Progress& progress) {
  std::vector<std::size_t> running;
  for (std::size_t k = 0; k < served.size(); ++k) running.push_back(k);
  while (!running.empty()) {
    std::vector<pollfd> waiting;
    waiting.reserve(running.size());
    for (const std::size_t k : running) waiting.push_back({served[k]->descriptor(), POLLIN, 0});
    if (::poll(waiting.data(), waiting.size(), -1) <= 0) continue;
    std::vector<std::size_t> go_on;
    for (std::size_t i = 0; i < running.size(); ++i) {
      Served& unit = *served[running[i]];
      if (waiting[i].revents == 0 || unit.hear()) {
        go_on.push_back(running[i]);
        continue;
      }
      // Before the begin the others wait for it in vain.
      if (!unit.is_ready()) throw base::Error(unit.run().failed);
      together.leave(running[i]);
    }
    running = go_on;
    if (progress && !running.empty())
      progress("steps", served[running[0]]->run().reached_s / stop_s);
  }
}

}  // namespace

std::vector<ServeRun> serve_units(const std::vector<ServedUnit>& units,
                                  const base::Progress& progress) {
  want_one_clock(units);
  Together together(units.size());
  std::vector<std::unique_ptr<Served>> served;
  served.reserve(units.size());
  for (const auto& [name, path, options] : units)
    served.push_back(std::make_unique<Served>(path, options));
  for (std::size_t k = 0; k < served.size(); ++k) served[k]->start(together, k);
  hear_all(served, together, units[0].options.stop_s, progress);
  std::vector<ServeRun> runs;
  runs.reserve(served.size());
  for (const auto& one : served) runs.push_back(std::move(one->run()));
  return runs;
}

ServeRun serve_unit(const std::string& path, const ServeOptions& options,
                    const base::Progress& progress) {
  ServeRun run = std::move(serve_units({{path, path, options}}, progress)[0]);
  if (!run.failed.empty()) throw base::Error(run.failed);
  return run;
}

}  // namespace sim
