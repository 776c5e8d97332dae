#include "topics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "message_types.h"
#include "readers.h"

namespace recording {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kLatestNs = std::int64_t{1} << 62;  // differences of two stay within 64 bits
constexpr std::int64_t kSecond = 1000000000;
constexpr std::int64_t kSameClockNs = 10 * kSecond;

using Column = Topic::Column;

using Index = std::unordered_map<std::string, std::size_t>;

Index index_of(const Topic& topic) {
  Index out;
  for (std::size_t c = 0; c < topic.columns.size(); ++c) out.emplace(topic.columns[c].path, c);
  return out;
}

const Column* find(const Topic& topic, const Index& index, const std::string& path) {
  const auto found = index.find(path);
  return found == index.end() ? nullptr : &topic.columns[found->second];
}

/// The path without a last part of that name, or nothing.
std::optional<std::string> stem_of(const std::string& path, std::string_view last) {
  if (!path.ends_with(last)) return std::nullopt;
  std::string stem = path.substr(0, path.size() - last.size());
  if (stem.empty()) return stem;
  if (stem.back() != '.') return std::nullopt;
  stem.pop_back();
  return stem;
}

std::string under(const std::string& stem, const char* last) {
  return stem.empty() ? std::string(last) : stem + '.' + last;
}

std::optional<std::int64_t> nanoseconds(double sec, double nsec) {
  if (!(std::abs(sec) < 4e9) || !(nsec >= 0 && nsec < 1e9)) return std::nullopt;
  return static_cast<std::int64_t>(sec) * kSecond + static_cast<std::int64_t>(nsec);
}

std::int64_t middle_of(std::vector<std::int64_t> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Takes the stamps as the topic's times where they go on at the logger's pace; says what was done
/// where that is not plain.
std::string use_stamps(const std::vector<std::int64_t>& stamps, Topic& topic) {
  std::size_t on = 0;
  for (std::size_t i = 1; i < stamps.size(); ++i) on += stamps[i] > stamps[i - 1] ? 1 : 0;
  if (stamps.size() < 2 || 2 * on < stamps.size() - 1) return {};
  const std::int64_t logged = topic.times_ns.back() - topic.times_ns.front(),
                     stamped = stamps.back() - stamps.front();
  if (std::abs(stamped - logged) > kSecond + logged / 10)
    return topic.name + ": stamps at another pace than the logger's clock, not used";
  std::vector<std::int64_t> late(stamps.size());
  for (std::size_t i = 0; i < late.size(); ++i) late[i] = topic.times_ns[i] - stamps[i];
  const std::int64_t shift = middle_of(late);
  const bool other = shift > kSameClockNs || shift < -kSameClockNs;
  for (std::size_t i = 0; i < stamps.size(); ++i)
    topic.times_ns[i] = stamps[i] + (other ? shift : 0);
  if (!other) return {};
  return topic.name + ": stamped by a clock of its own, moved onto the logger's by the median";
}

/// Seconds and nanoseconds into one column; a header's become the topic's times.
void merge_stamps(Topic& topic, std::vector<std::string>& notes) {
  const Index index = index_of(topic);
  const std::vector<std::int64_t> logged = topic.times_ns;
  std::vector<Column> kept;
  std::vector<char> gone(topic.columns.size(), 0);
  for (Column& seconds : topic.columns) {
    const auto stem = stem_of(seconds.path, "sec");
    if (!stem) continue;
    const Column* fraction = nullptr;
    for (const char* last : {"nanosec", "nsec", "nsecs"})
      if (fraction == nullptr) fraction = find(topic, index, under(*stem, last));
    if (fraction == nullptr) continue;
    std::vector<std::int64_t> stamps;
    for (std::size_t i = 0; i < logged.size(); ++i) {
      const auto ns = nanoseconds(seconds.values[i], fraction->values[i]);
      seconds.values[i] = ns ? 1e-9 * static_cast<double>(*ns) : kNaN;
      if (ns && *ns > 0) stamps.push_back(*ns);
    }
    seconds.path = stem->empty() ? "stamp" : *stem;
    seconds.unit = "s";
    gone[static_cast<std::size_t>(fraction - topic.columns.data())] = 1;
    const bool header =
        seconds.path == "header.stamp" || seconds.path == "timestamp" || seconds.path == "stamp";
    if (!header || stamps.size() != logged.size() || topic.times_ns != logged) continue;
    if (std::string note = use_stamps(stamps, topic); !note.empty())
      notes.push_back(std::move(note));
  }
  for (std::size_t c = 0; c < gone.size(); ++c)
    if (gone[c] == 0) kept.push_back(std::move(topic.columns[c]));
  topic.columns = std::move(kept);
}

/// Roll, pitch and yaw beside every quaternion, by z-y-x as everywhere in this project.
void add_angles(Topic& topic) {
  const Index index = index_of(topic);
  std::vector<Column> angles;
  for (const Column& w : topic.columns) {
    const auto stem = stem_of(w.path, "w");
    if (!stem || find(topic, index, under(*stem, "yaw")) != nullptr) continue;
    const Column *x = find(topic, index, under(*stem, "x")),
                 *y = find(topic, index, under(*stem, "y")),
                 *z = find(topic, index, under(*stem, "z"));
    if (x == nullptr || y == nullptr || z == nullptr) continue;
    Column roll{under(*stem, "roll"), "rad", {}}, pitch{under(*stem, "pitch"), "rad", {}},
        yaw{under(*stem, "yaw"), "rad", {}};
    bool any = false;
    for (std::size_t i = 0; i < topic.times_ns.size(); ++i) {
      const double qw = w.values[i], qx = x->values[i], qy = y->values[i], qz = z->values[i];
      const bool turns = std::abs(qw * qw + qx * qx + qy * qy + qz * qz - 1.0) < 0.01;
      any = any || turns;
      const auto put = [&](Column& to, double angle) { to.values.push_back(turns ? angle : kNaN); };
      put(roll, std::atan2(2 * (qw * qx + qy * qz), 1 - 2 * (qx * qx + qy * qy)));
      put(pitch, std::asin(std::clamp(2 * (qw * qy - qz * qx), -1.0, 1.0)));
      put(yaw, std::atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)));
    }
    if (any)
      for (Column* angle : {&roll, &pitch, &yaw}) angles.push_back(std::move(*angle));
  }
  for (Column& angle : angles) topic.columns.push_back(std::move(angle));
}

void sort_by_time(Topic& topic) {
  if (std::is_sorted(topic.times_ns.begin(), topic.times_ns.end())) return;
  std::vector<std::size_t> order(topic.times_ns.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return topic.times_ns[a] < topic.times_ns[b];
  });
  const auto sorted = [&](auto& values) {
    auto out = values;
    for (std::size_t i = 0; i < order.size(); ++i) out[i] = values[order[i]];
    values = std::move(out);
  };
  sorted(topic.times_ns);
  for (Column& column : topic.columns) sorted(column.values);
}

/// Elements of long arrays, whose number no schema told: "ranges.0" where there is a "ranges.64".
void drop_long_arrays(Topic& topic) {
  std::vector<std::string> long_ones;
  const std::string beyond = '.' + std::to_string(kMostElements);
  for (const Column& column : topic.columns)
    for (std::size_t at = column.path.find(beyond); at != std::string::npos;
         at = column.path.find(beyond, at + 1)) {
      const std::size_t end = at + beyond.size();
      if (end == column.path.size() || column.path[end] == '.')
        long_ones.push_back(column.path.substr(0, at + 1));
    }
  std::sort(long_ones.begin(), long_ones.end());
  long_ones.erase(std::unique(long_ones.begin(), long_ones.end()), long_ones.end());
  std::erase_if(topic.columns, [&](const Column& column) {
    return std::any_of(long_ones.begin(), long_ones.end(), [&](const std::string& stem) {
      return column.path.starts_with(stem) && column.path.size() > stem.size() &&
             column.path[stem.size()] >= '0' && column.path[stem.size()] <= '9';
    });
  });
}

void append(Topic& topic, std::int64_t begin_ns, Log& log) {
  std::vector<double> clock;
  for (const std::int64_t t : topic.times_ns)
    clock.push_back(1e-9 * static_cast<double>(t - begin_ns));
  Log one{"", {}, false, {}, {}};
  for (Column& column : topic.columns) {
    Channel channel;
    channel.name = column.path.empty()  ? topic.name
                   : topic.name.empty() ? column.path
                                        : topic.name + '.' + column.path;
    channel.unit = std::move(column.unit);
    channel.values = std::move(column.values);
    channel.clock = log.clocks.size();
    one.channels.push_back(std::move(channel));
  }
  set_rates(one, clock);
  for (Channel& channel : one.channels) log.channels.push_back(std::move(channel));
  log.clocks.push_back(std::move(clock));
}

}  // namespace

bool Topic::begin_message(std::uint64_t logged_ns) {
  if (logged_ns >= static_cast<std::uint64_t>(kLatestNs)) return false;
  times_ns.push_back(static_cast<std::int64_t>(logged_ns));
  return true;
}

std::size_t Topic::slot(std::string_view path, std::string_view unit) {
  const auto found = known_.find(std::string(path));
  if (found != known_.end()) return found->second;
  if (columns.size() >= kMostFields) return kNone;
  known_.emplace(std::string(path), columns.size());
  if (unit.empty()) unit = standard_unit(schema_name, path);
  columns.push_back({std::string(path), std::string(unit), {}});
  return columns.size() - 1;
}

std::size_t Topic::slot_near(std::size_t guess, std::string_view path) {
  if (guess < columns.size() && columns[guess].path == path) return guess;
  return slot(path);
}

void Topic::put(std::size_t slot, double value) {
  if (slot == kNone) return;
  std::vector<double>& values = columns[slot].values;
  if (values.size() < times_ns.size()) values.resize(times_ns.size(), kNaN);
  values.back() = std::isfinite(value) ? value : kNaN;
}

void Topic::append(Topic later) {
  const std::size_t before = times_ns.size();
  times_ns.insert(times_ns.end(), later.times_ns.begin(), later.times_ns.end());
  for (const Column& column : later.columns) {
    const std::size_t at = slot(column.path, column.unit);
    if (at == kNone || column.values.empty()) continue;
    std::vector<double>& values = columns[at].values;
    values.resize(before, kNaN);
    values.insert(values.end(), column.values.begin(), column.values.end());
  }
  damaged += later.damaged;
}

void append_topics(std::vector<Topic>& topics, std::vector<Topic> later) {
  // A name that comes twice in a file is two topics, in this order.
  std::unordered_map<std::string, std::vector<std::size_t>> known;
  for (std::size_t k = 0; k < topics.size(); ++k) known[topics[k].name].push_back(k);
  std::unordered_map<std::string, std::size_t> taken;
  for (Topic& topic : later) {
    const std::vector<std::size_t>& places = known[topic.name];
    const std::size_t which = taken[topic.name]++;
    if (which < places.size())
      topics[places[which]].append(std::move(topic));
    else
      topics.push_back(std::move(topic));
  }
}

Log log_of_file(FileTopics file, const std::string& format, const std::string& name) {
  Log log = log_of_topics(std::move(file.topics), format, name);
  log.notes.insert(log.notes.begin(), file.notes.begin(), file.notes.end());
  if (log.channels.empty())
    throw base::Error(fmt::format("{}: {} without a number that can be read{}{}", name, format,
                                  log.notes.empty() ? "" : ": ",
                                  log.notes.empty() ? "" : log.notes.front()));
  return log;
}

Log log_of_topics(std::vector<Topic> topics, std::string format, const std::string& name) {
  Log log{std::move(format), {}, false, {}, {}};
  std::size_t cells = 0;
  for (Topic& topic : topics) {
    // What no message had a value of is no channel.
    std::erase_if(topic.columns, [](const Column& column) { return column.values.empty(); });
    if (topic.damaged > 0)
      log.notes.push_back(fmt::format("{}: {} of {} messages contradict their schema", topic.name,
                                      topic.damaged, topic.times_ns.size()));
    drop_long_arrays(topic);
    cells += (topic.columns.size() + 1) * topic.times_ns.size();
    if (cells > kMostCells)
      throw base::Error(name + ": more than 2 GB of samples; cut the log or the file is damaged");
    for (Column& column : topic.columns) column.values.resize(topic.times_ns.size(), kNaN);
    merge_stamps(topic, log.notes);
    add_angles(topic);
    sort_by_time(topic);
  }
  std::erase_if(topics, [](const Topic& topic) { return topic.columns.empty(); });
  std::int64_t begin_ns = kLatestNs;
  for (const Topic& topic : topics) begin_ns = std::min(begin_ns, topic.times_ns.front());
  for (Topic& topic : topics) append(topic, begin_ns, log);
  number_names(log.channels);
  return log;
}

}  // namespace recording
