#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/sha256.h"
#include "command/exit_code.h"
#include "commands.h"
#include "vehicle/error.h"

namespace trials {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using vehicle::Error;

json read_json(const fs::path& path) {
  std::ifstream in(path);
  if (!in) throw Error(path.string() + ": cannot be opened");
  try {
    return json::parse(in);
  } catch (const json::exception& error) {
    throw Error(fmt::format("{}: {}", path.string(), error.what()));
  }
}

/// P(X <= k) of n draws at p.
double binomial_below(int k, int n, double p) {
  double sum = 0;
  for (int i = 0; i <= k; ++i)
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) +
                    i * std::log(p) + (n - i) * std::log1p(-p));
  return sum;
}

/// Exact interval of Clopper and Pearson, 95 %.
std::pair<double, double> interval(int k, int n) {
  if (n == 0) return {0, 1};
  const auto solve = [&](auto above) {
    double low = 1e-12, high = 1 - 1e-12;
    for (int i = 0; i < 100; ++i) {
      const double mid = 0.5 * (low + high);
      (above(mid) ? low : high) = mid;
    }
    return low;
  };
  const double low =
      k == 0 ? 0 : solve([&](double p) { return 1 - binomial_below(k - 1, n, p) < 0.025; });
  const double high = k == n ? 1 : solve([&](double p) { return binomial_below(k, n, p) > 0.025; });
  return {low, high};
}

struct Count {
  int hits = 0, of = 0;
  void add(bool hit) { hits += hit ? 1 : 0, ++of; }
};

double median(std::vector<double> v) {
  if (v.empty()) return NAN;
  std::sort(v.begin(), v.end());
  return v[v.size() / 2];
}

/// Share of the drop of the held-out error that taking the effect away reaches which the finding
/// reaches, in the channel where that drop is largest; NaN where no channel drops by a twentieth.
double share_of_drop(const fs::path& trial, const fs::path& twin, const json& finding) {
  const explain::Findings best = explained(trial, twin, false);
  double largest = 0.05, share = NAN;
  for (const json& h : finding.at("held_out"))
    for (const explain::HeldOut& t : best.held_out) {
      const double before = h.at("rmse_before"), after = h.at("rmse_after");
      if (t.channel != h.at("channel") || !(before > 0)) continue;
      const double drop = 1 - t.rmse_before / before;
      if (drop > largest) largest = drop, share = (before - after) / (before - t.rmse_before);
    }
  return share;
}

/// A trial that was explained, beside its truth.
struct Explained {
  fs::path folder;
  json truth, found;
  std::string verdict, kind, car;
  std::vector<std::string> names, truths;  ///< mechanism and channel, found and true
  bool first = false;                      ///< the first name is right
  bool failed = false;
  double improvement = NAN;  ///< see share_of_drop
};

struct Scores {
  int trials = 0;
  Count alarm, half, full, tied, weak, inside, wrong, tie, outside, both, both_large, both_tied,
      one, cover, listed;
  std::vector<double> overlap, error, improvement;
  std::map<std::string, Count> by_mechanism;  ///< single effects of 0.5 sd or more
  nlohmann::ordered_json failed_trials = nlohmann::ordered_json::array();
  std::string failures;
};

/// The seals first: a truth that changed since it was drawn is no truth.
void check_seals(const fs::path& folder) {
  std::ifstream sums(folder / "SHA256SUMS");
  if (!sums)
    throw Error(folder.string() + "/SHA256SUMS: cannot be opened; blind_trials make writes it");
  std::string hash, name;
  while (sums >> hash >> name)
    if (base::sha256_of_file((folder / name).string()) != hash)
      throw Error((folder / name).string() + ": is not what was sealed");
}

std::string label(const json& x) {
  const std::string channel =
      x.contains("channel") && x["channel"].is_string() ? x["channel"].get<std::string>() : "";
  return x.at("mechanism").get<std::string>() + (channel.empty() ? "" : " " + channel);
}

bool is_true(const Explained& t, const std::string& mechanism) {
  if (std::find(t.truths.begin(), t.truths.end(), mechanism) != t.truths.end()) return true;
  // Either of a pair that looks alike is right.
  return std::any_of(t.truth.at("alike").begin(), t.truth.at("alike").end(),
                     [&](const json& a) { return mechanism.starts_with(a.get<std::string>()); });
}

Explained read_trial(const fs::path& folder, const fs::path& here) {
  Explained t;
  t.folder = here;
  t.truth = read_json(folder / "sealed" / (here.filename().string() + ".json"));
  t.found = read_json(here / "findings.json");
  t.verdict = t.found.at("verdict");
  t.kind = t.truth.at("class");
  t.car = t.truth.value("car", "second");
  for (const json& f : t.found.at("findings")) t.names.push_back(label(f));
  for (const json& e : t.truth.at("effects")) t.truths.push_back(label(e));
  t.first = !t.names.empty() && is_true(t, t.names.front());
  const fs::path twin = folder / "sealed" / (here.filename().string() + ".csv");
  if (t.kind == "single" && t.first && fs::exists(twin))
    t.improvement = share_of_drop(here, twin, t.found.at("findings")[0]);
  return t;
}

void count_single(Explained& t, Scores& scores) {
  const double size = t.truth.at("effects")[0].at("size_sd");
  // Within its prior width a parameter is listed, and nothing is missing.
  const bool within = t.truths.front().starts_with("parameter.") &&
                      std::abs(t.truth["effects"][0].at("amount").get<double>()) <= 0.05;
  if (within)
    scores.inside.add(t.verdict == "none"), t.failed = t.failed || t.verdict != "none";
  else if (size >= 0.49)
    scores.half.add(t.first), t.failed = t.failed || !t.first;
  else
    scores.weak.add(t.first || t.verdict == "none"),
        t.failed = t.failed || !(t.first || t.verdict == "none");
  if (!within && size >= 0.98) scores.full.add(t.first);
  const bool among = !t.names.empty() &&
                     std::any_of(t.found["findings"][0].at("rivals").begin(),
                                 t.found["findings"][0].at("rivals").end(), [&](const json& r) {
                                   return !r.at("separable") && is_true(t, label(r));
                                 });
  if (!within && size >= 0.49) scores.tied.add(t.first || among);
  if (!within && size >= 0.49) scores.by_mechanism[t.truths.front()].add(t.first);
  if (std::isfinite(t.improvement)) scores.improvement.push_back(t.improvement);
}

/// Of a finding: what it could not be told from.
bool is_tied_with(const json& finding, const std::string& effect) {
  return std::any_of(finding.at("rivals").begin(), finding.at("rivals").end(), [&](const json& r) {
    return !r.at("separable").get<bool>() && label(r) == effect;
  });
}

void count_two(Explained& t, Scores& scores) {
  int right = 0, tied = 0;
  for (const std::string& effect : t.truths) {
    const bool named = std::find(t.names.begin(), t.names.end(), effect) != t.names.end();
    right += named ? 1 : 0;
    tied += named || std::any_of(t.found["findings"].begin(), t.found["findings"].end(),
                                 [&](const json& f) { return is_tied_with(f, effect); })
                ? 1
                : 0;
  }
  scores.both.add(right == 2);
  scores.both_tied.add(tied == 2);
  if (std::all_of(t.truth["effects"].begin(), t.truth["effects"].end(),
                  [](const json& e) { return e.at("size_sd").get<double>() >= 0.49; }))
    scores.both_large.add(right == 2);
  scores.one.add(right >= 1);
  t.failed = t.failed || right < 2;
}

void count_kind(Explained& t, Scores& scores) {
  ++scores.trials;
  if (t.verdict == kFailedVerdict) t.failed = true;
  if (t.kind == "none")
    scores.alarm.add(t.verdict != "none"), t.failed = t.failed || t.verdict != "none";
  if (t.kind == "single") count_single(t, scores);
  if (t.kind == "alike")
    scores.tie.add(t.verdict == "tie"), t.failed = t.failed || t.verdict != "tie";
  if (t.kind == "outside")
    scores.outside.add(t.verdict == "none" || t.verdict == "unknown"),
        t.failed = t.failed || (t.verdict != "none" && t.verdict != "unknown");
  if (t.kind == "two") count_two(t, scores);
  const bool misnamed = t.verdict == "explained" && !t.first;
  scores.wrong.add(misnamed);
  t.failed = t.failed || misnamed;
}

/// Place and amount of an effect against those of the finding that names it.
void compare(const json& e, const json& f, const json& found, Scores& scores) {
  if (e.contains("where") && f.at("where").is_array()) {
    const double a = e["where"][0], b = e["where"][1], x = f["where"][0]["u_begin_m"],
                 y = f["where"][0]["u_end_m"];
    scores.overlap.push_back(std::max(0.0, std::min(b, y) - std::max(a, x)) /
                             (std::max(b, y) - std::min(a, x)));
  }
  // Amounts that mean the same on both sides.
  const std::string m = e.at("mechanism");
  const bool parameter = m.starts_with("parameter.");
  const bool road = m == "road.banking" || m == "road.grade" || m == "road.vertical_curvature";
  if (m.starts_with("sensor.") || m.ends_with("dead_time") || m == "vehicle.steering_lag" ||
      m == "vehicle.fuel_burn" || m == "vehicle.aero_drag" || m == "vehicle.aero_downforce" ||
      parameter) {
    double wanted = e.at("amount");
    const json& p = f.at("parameters")[0];
    if (parameter) {
      // The truth in the parameter's unit: the stated value times one plus the deviation.
      if (p.at("name") != e.at("name")) return;
      double stated = NAN;
      for (const json& q : found.at("parameters"))
        if (q.at("name") == e.at("name")) stated = q.at("stated");
      const double value = p.at("value");
      scores.error.push_back(std::abs((value / stated - 1) / wanted - 1));
      wanted = stated * (1 + wanted);
    } else {
      scores.error.push_back(std::abs(p.at("value").get<double>() / wanted - 1));
    }
    scores.cover.add(p["ci90"][0] <= wanted && p["ci90"][1] >= wanted);
  } else if (road) {
    // The mean over a stretch whose flanks take 15 % at either end is 0.85 of its top.
    scores.error.push_back(std::abs(f.at("parameters")[0].at("value").get<double>() /
                                        (0.85 * e.at("amount").get<double>()) -
                                    1));
  }
}

/// Every parameter that is listed, against what the car really has.
void compare_listed(const Explained& t, Scores& scores) {
  for (const json& p : t.found.value("parameters", json::array()))
    for (const json& q : t.truth.at("parameters")) {
      if (p.at("name") != q.at("name")) continue;
      const double is = p.at("stated").get<double>() * (1 + q.at("deviation").get<double>());
      scores.listed.add(p["ci90"][0] <= is && p["ci90"][1] >= is);
    }
}

void tell_failure(const Explained& t, Scores& scores) {
  const auto join = [](const std::vector<std::string>& v) {
    std::string out;
    for (const std::string& s : v) out += (out.empty() ? "" : ", ") + s;
    return out.empty() ? std::string("nothing") : out;
  };
  double size = 0;
  for (const json& e : t.truth.at("effects")) size = std::max(size, e.at("size_sd").get<double>());
  scores.failed_trials.push_back(t.folder.filename().string());
  scores.failures +=
      fmt::format("| {} | {} | {} | {} ({:.2g} sd) | {} | {} |\n", t.folder.filename().string(),
                  t.car, t.kind, join(t.truths), size, t.verdict, join(t.names));
}

using Json = nlohmann::ordered_json;

void tell(const char* what, const Count& k, const char* floor, std::string& text, Json& metrics) {
  const auto [low, high] = interval(k.hits, k.of);
  text += fmt::format("| {} | {} of {} | {:.0f} % | {:.0f} to {:.0f} % | {} |\n", what, k.hits,
                      k.of, k.of ? 100.0 * k.hits / k.of : 0.0, 100 * low, 100 * high, floor);
  metrics.push_back({{"metric", what},
                     {"hits", k.hits},
                     {"of", k.of},
                     {"interval", {low, high}},
                     {"floor", floor}});
}

void tell_median(const char* what, const std::vector<double>& values, double scale,
                 const char* unit, const char* floor, std::string& text, Json& metrics) {
  text += fmt::format(
      "| {}, median of {} | | {} | | {} |\n", what, values.size(),
      values.empty() ? ""
                     : fmt::format("{:.{}f}{}", scale * median(values), scale == 1 ? 2 : 0, unit),
      floor);
  metrics.push_back(
      {{"metric", what}, {"of", values.size()}, {"median", median(values)}, {"floor", floor}});
}

/// The table of all metrics, and the same as JSON.
std::pair<std::string, Json> metrics_of(const Scores& scores) {
  std::string text =
      "| metric | count | share | exact 95 % interval | floor |\n|---|---|---|---|---|\n";
  Json metrics = Json::array();
  const auto line = [&](const char* what, const Count& k, const char* floor) {
    tell(what, k, floor, text, metrics);
  };
  line("false alarm when nothing is missing", scores.alarm, "at most 5 %");
  line("right name first, effect of 0.5 sd or more", scores.half, "80 %");
  line("right name first, effect of 1 sd or more", scores.full, "90 %");
  line("the same, 0.5 sd or more, or among those that it could not be told from", scores.tied, "");
  line("effect below 0.5 sd: none, or its name first", scores.weak, "");
  line("parameter off within its prior width: none", scores.inside, "");
  line("wrong name stated as explained, all trials", scores.wrong, "at most 5 %");
  line("pairs that look alike reported as tie", scores.tie, "80 %");
  line("not in the library: unknown or none", scores.outside, "80 %");
  line("two at once: both named", scores.both, "60 %");
  line("the same, both of 0.5 sd or more", scores.both_large, "");
  line("the same, or among those that it could not be told from", scores.both_tied, "");
  line("two at once: at least one named", scores.one, "90 %");
  line("90 % intervals that hold the truth", scores.cover, "80 to 97 %");
  line("the same, of all parameters that are listed", scores.listed, "");
  const auto middle = [&](const char* what, const std::vector<double>& values, double scale,
                          const char* unit, const char* floor) {
    tell_median(what, values, scale, unit, floor, text, metrics);
  };
  middle("intersection over union of road findings", scores.overlap, 1, "", "0.6");
  middle("error of the amount", scores.error, 100, " %", "at most 15 %");
  middle("held-out improvement over what taking the effect away reaches", scores.improvement, 100,
         " %", "70 %");
  return {text, metrics};
}

/// What each car's trials make of it, side by side, where more than one car drove.
std::string side_by_side(const Json& cars) {
  if (cars.size() < 2) return "";
  std::string text = "\n| car |", rule = "\n|---|", trials = "\n| trials |";
  for (const auto& [car, of] : cars.items()) {
    text += " " + car + " |", rule += "---|";
    trials += fmt::format(" {} |", of.at("trials").get<int>());
  }
  text += rule + trials;
  const Json& first = cars.begin()->at("metrics");
  for (std::size_t k = 0; k < first.size(); ++k) {
    text += "\n| " + first[k].at("metric").get<std::string>() + " |";
    for (const Json& of : cars) {
      const Json& m = of.at("metrics")[k];
      if (m.contains("hits"))
        text += fmt::format(" {} of {} |", m["hits"].get<int>(), m["of"].get<int>());
      else
        text += m["of"] == 0 ? " |" : fmt::format(" {:.2f} |", m["median"].get<double>());
    }
  }
  return text + "\n";
}

void print(const Scores& scores, const std::map<std::string, Scores>& by_car, Terminal& terminal) {
  auto [text, metrics] = metrics_of(scores);
  Json named = Json::object(), cars = Json::object();
  for (const auto& [car, of] : by_car)
    cars[car] = {{"trials", of.trials}, {"metrics", metrics_of(of).second}};
  text += side_by_side(cars);
  text += "\n| single effect of 0.5 sd or more | named first |\n|---|---|\n";
  for (const auto& [mechanism, count] : scores.by_mechanism) {
    text += fmt::format("| {} | {} of {} |\n", mechanism, count.hits, count.of);
    named[mechanism] = {{"first", count.hits}, {"of", count.of}};
  }
  text += fmt::format(
      "\n| trial | car | class | truth | verdict | named |\n|---|---|---|---|---|---|\n{}",
      scores.failures);
  terminal.print(terminal.json ? base::json_text(Json{{"metrics", metrics},
                                                      {"cars", cars},
                                                      {"single_effects", named},
                                                      {"failures", scores.failed_trials}})
                               : text);
}

}  // namespace

int score(const ScoreCommand& command, Terminal& terminal) {
  const fs::path folder(command.folder);
  check_seals(folder);
  Scores scores;
  std::map<std::string, Scores> by_car;
  for (const fs::path& here : folders(folder)) {
    Explained t = read_trial(folder, here);
    for (Scores* of : {&scores, &by_car[t.car]}) {
      count_kind(t, *of);
      compare_listed(t, *of);
      for (const json& e : t.truth.at("effects"))
        for (const json& f : t.found.at("findings"))
          if (label(e) == label(f)) compare(e, f, t.found, *of);
    }
    if (t.failed) tell_failure(t, scores);
  }
  print(scores, by_car, terminal);
  return command::kOk;
}

}  // namespace trials
