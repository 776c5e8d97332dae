#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "command/signals.h"
#include "commands.h"
#include "crg/file.h"
#include "explain/explain.h"
#include "base/json_text.h"
#include "base/parallel.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "vehicle/error.h"

namespace crgexplain {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using vehicle::Error;

constexpr const char* kFailedVerdict = "failed";  ///< of a recording that could not be explained

std::vector<fs::path> folders(const fs::path& folder) {
  std::vector<fs::path> out;
  if (!fs::is_directory(folder)) throw Error(fmt::format("{}: no such folder", folder.string()));
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && fs::exists(entry.path() / "run.csv")) out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  if (out.empty()) throw Error(fmt::format("{}: holds no trials; crgexplain trials make draws some", folder.string()));
  return out;
}

json read_json(const fs::path& path) {
  std::ifstream in(path);
  if (!in) throw Error(path.string() + ": cannot be opened");
  try {
    return json::parse(in);
  } catch (const json::exception& error) {
    throw Error(fmt::format("{}: {}", path.string(), error.what()));
  }
}

/// Runs a program to its end; what it prints goes to standard error. Throws Error.
void run_program(std::vector<std::string> words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const auto refuse = [&](int reason) {
    throw Error(
        fmt::format("{}: cannot be started: {}; give the program make_trials of the tests "
                    "with --generator",
                    words[0], std::strerror(reason)));
  };
  int told[2];  // closed by a program that starts; otherwise the reason comes through
  if (::pipe2(told, O_CLOEXEC) != 0) refuse(errno);
  const pid_t child = ::fork();
  int reason = errno;
  if (child == 0) {
    command::end_with_parent();
    ::dup2(STDERR_FILENO, STDOUT_FILENO);
    ::execv(argv[0], argv.data());
    reason = errno;
    (void)!::write(told[1], &reason, sizeof reason);
    ::_exit(1);
  }
  ::close(told[1]);
  const bool started = child > 0 && ::read(told[0], &reason, sizeof reason) == 0;
  ::close(told[0]);
  int status = 0;
  if (child > 0) ::waitpid(child, &status, 0);
  if (!started) refuse(reason);
  if (WIFSIGNALED(status))
    throw Error(fmt::format("{}: was ended by signal {} ({})", words[0], WTERMSIG(status),
                            strsignal(WTERMSIG(status))));
  if (WEXITSTATUS(status) != 0)
    throw Error(fmt::format("{}: failed with exit code {}; what it says is above", words[0],
                            WEXITSTATUS(status)));
}

int make(const TrialsCommand& c, Terminal& terminal) {
  fs::create_directories(c.folder);
  if (!fs::is_empty(c.folder)) throw Error(c.folder + ": is not empty; trials want a folder of their own");
  std::vector<std::string> words{c.generator, std::to_string(c.count), std::to_string(c.seed), c.folder};
  if (c.waves) words.insert(words.begin() + 1, "--waves");
  run_program(words);
  std::string sums;
  std::vector<fs::path> sealed;
  for (const auto& entry : fs::directory_iterator(fs::path(c.folder) / "sealed")) sealed.push_back(entry.path());
  std::sort(sealed.begin(), sealed.end());
  for (const fs::path& path : sealed) sums += base::sha256_of_file(path.string()) + "  sealed/" + path.filename().string() + "\n";
  base::write_file(c.folder + "/SHA256SUMS", sums);
  const std::string seal = base::sha256_of_file(c.folder + "/SHA256SUMS");
  const std::size_t count = folders(c.folder).size();
  terminal.print(terminal.json ? base::json_text(json{{"trials", count}, {"seal", seal}})
                               : fmt::format("{} trials; seal of all truths: {}\n", count, seal));
  return 0;
}

/// A trial's recording explained with what the simulation knows.
explain::Findings explained(const fs::path& trial, const fs::path& recording, bool mechanisms) {
  const std::string here = trial.string();
  const vehicle::Vehicle car = vehicle::read_vehicle(here + "/vehicle.yaml");
  const crg::Surface surface(crg::read(here + "/track.crg"));
  const vehicle::Table table = vehicle::read_table(recording.string());
  std::vector<explain::Signals> logs;
  logs.push_back(explain::make_signals(table, explain::identity_mapping(table), surface, recording.string()));
  explain::ExplainOptions options;
  options.threads = 1;
  options.mechanisms = mechanisms;
  // Without mechanisms only the refit and its proof are asked for.
  if (!mechanisms) return explain::explain_relations(logs, car, options);
  return explain::explain(
      {logs, {{&table, &logs.front()}}, explain::identity_mapping(table), surface, car}, options);
}

/// Whether a run before this one explained it; one that failed is tried again.
bool is_explained(const fs::path& trial) {
  std::ifstream in(trial / "findings.json");
  const json found = json::parse(in, nullptr, false);
  return found.is_object() && found.contains("verdict") && found["verdict"] != kFailedVerdict;
}

int run_all(const TrialsCommand& c, Terminal& terminal) {
  const std::vector<fs::path> all = folders(c.folder);
  std::atomic<std::size_t> done{0};
  std::vector<std::string> failures(all.size());  ///< why; empty: none
  const base::Progress progress = terminal.progress();
  base::parallel_for(all.size(), 1, c.threads, [&](std::size_t k, std::size_t) {
    const std::string here = all[k].string();
    if (is_explained(all[k])) return;  // a run that was stopped goes on
    std::string result;
    try {
      result = explain::findings_json(explained(all[k], here + "/run.csv", true));
    } catch (const std::exception& error) {
      failures[k] = error.what();
      result = base::json_text(
          json{{"verdict", kFailedVerdict}, {"error", failures[k]}, {"findings", json::array()}},
          1);
    }
    base::write_file(here + "/findings.json", result);
    progress("trials", static_cast<double>(++done) / static_cast<double>(all.size()));
  });
  const auto is_failure = [](const std::string& why) { return !why.empty(); };
  const auto failed =
      static_cast<std::size_t>(std::count_if(failures.begin(), failures.end(), is_failure));
  terminal.print(terminal.json
                     ? base::json_text(json{{"recordings", all.size()}, {"failed", failed}})
                     : fmt::format("{} recordings explained\n", all.size() - failed));
  if (failed > 0)
    throw command::NotValid(fmt::format(
        "{}: {} of {} recordings could not be explained, the first because: {}; findings.json of "
        "each says why, and 'trials run' tries them again",
        c.folder, failed, all.size(), *std::find_if(failures.begin(), failures.end(), is_failure)));
  return kOk;
}

/// P(X <= k) of n draws at p.
double binomial_below(int k, int n, double p) {
  double sum = 0;
  for (int i = 0; i <= k; ++i)
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) + i * std::log(p) + (n - i) * std::log1p(-p));
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
  const double low = k == 0 ? 0 : solve([&](double p) { return 1 - binomial_below(k - 1, n, p) < 0.025; });
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

int score(const TrialsCommand& c, Terminal& terminal) {
  nlohmann::ordered_json failed_trials = nlohmann::ordered_json::array();
  const fs::path folder(c.folder);
  // The seals first: a truth that changed since it was drawn is no truth.
  std::ifstream sums(folder / "SHA256SUMS");
  if (!sums) throw Error(c.folder + "/SHA256SUMS: cannot be opened; crgexplain trials make writes it");
  std::string hash, name;
  while (sums >> hash >> name)
    if (base::sha256_of_file((folder / name).string()) != hash) throw Error((folder / name).string() + ": is not what was sealed");
  Count alarm, half, full, tied, weak, inside, wrong, tie, outside, both, both_large, one, cover;
  std::vector<double> overlap, error, improvement;
  std::map<std::string, Count> by_mechanism;  ///< single effects of 0.5 sd or more
  std::string failures;
  for (const fs::path& here : folders(folder)) {
    const json truth = read_json(folder / "sealed" / (here.filename().string() + ".json"));
    const json found = read_json(here / "findings.json");
    const std::string verdict = found.at("verdict"), kind = truth.at("class");
    std::vector<std::string> names, truths;
    const auto label = [](const json& x) {
      const std::string channel = x.contains("channel") && x["channel"].is_string() ? x["channel"].get<std::string>() : "";
      return x.at("mechanism").get<std::string>() + (channel.empty() ? "" : " " + channel);
    };
    for (const json& f : found.at("findings")) names.push_back(label(f));
    for (const json& e : truth.at("effects")) truths.push_back(label(e));
    bool failed = false;
    const auto is_true = [&](const std::string& mechanism) {
      if (std::find(truths.begin(), truths.end(), mechanism) != truths.end()) return true;
      // Either of a pair that looks alike is right.
      return std::any_of(truth.at("alike").begin(), truth.at("alike").end(), [&](const json& a) { return mechanism.starts_with(a.get<std::string>()); });
    };
    const bool first = !names.empty() && is_true(names.front());
    if (verdict == kFailedVerdict) failed = true;
    if (kind == "none") alarm.add(verdict != "none"), failed = failed || verdict != "none";
    if (kind == "single") {
      const double size = truth.at("effects")[0].at("size_sd");
      // Within its prior width a parameter is listed, and nothing is missing.
      const bool within = truths.front().starts_with("parameter.") && std::abs(truth["effects"][0].at("amount").get<double>()) <= 0.05;
      if (within) inside.add(verdict == "none"), failed = failed || verdict != "none";
      else if (size >= 0.49) half.add(first), failed = failed || !first;
      else weak.add(first || verdict == "none"), failed = failed || !(first || verdict == "none");
      if (!within && size >= 0.98) full.add(first);
      const bool among = !names.empty() && std::any_of(found["findings"][0].at("rivals").begin(), found["findings"][0].at("rivals").end(),
                                                       [&](const json& r) { return !r.at("separable") && is_true(label(r)); });
      if (!within && size >= 0.49) tied.add(first || among);
      if (!within && size >= 0.49) by_mechanism[truths.front()].add(first);
      const fs::path twin = folder / "sealed" / (here.filename().string() + ".csv");
      if (first && fs::exists(twin)) {
        const double share = share_of_drop(here, twin, found.at("findings")[0]);
        if (std::isfinite(share)) improvement.push_back(share);
      }
    }
    if (kind == "alike") tie.add(verdict == "tie"), failed = failed || verdict != "tie";
    if (kind == "outside") outside.add(verdict == "none" || verdict == "unknown"), failed = failed || (verdict != "none" && verdict != "unknown");
    if (kind == "two") {
      int right = 0;
      for (const std::string& t : truths) right += std::find(names.begin(), names.end(), t) != names.end() ? 1 : 0;
      both.add(right == 2);
      if (std::all_of(truth["effects"].begin(), truth["effects"].end(), [](const json& e) { return e.at("size_sd").get<double>() >= 0.49; })) both_large.add(right == 2);
      one.add(right >= 1);
      failed = failed || right < 2;
    }
    const bool misnamed = verdict == "explained" && !first;
    wrong.add(misnamed);
    failed = failed || misnamed;
    for (const json& e : truth.at("effects"))
      for (const json& f : found.at("findings")) {
        if (label(e) != label(f)) continue;
        if (e.contains("where") && f.at("where").is_array()) {
          const double a = e["where"][0], b = e["where"][1], x = f["where"][0]["u_begin_m"], y = f["where"][0]["u_end_m"];
          overlap.push_back(std::max(0.0, std::min(b, y) - std::max(a, x)) / (std::max(b, y) - std::min(a, x)));
        }
        // Amounts that mean the same on both sides.
        const std::string m = e.at("mechanism");
        const bool parameter = m.starts_with("parameter.");
        const bool road = m == "road.banking" || m == "road.grade" || m == "road.vertical_curvature";
        if (m.starts_with("sensor.") || m.ends_with("dead_time") || m == "vehicle.steering_lag" || m == "vehicle.fuel_burn" || m == "vehicle.aero_drag" ||
            m == "vehicle.aero_downforce" || parameter) {
          double wanted = e.at("amount");
          const json& p = f.at("parameters")[0];
          if (parameter) {
            // The truth in the parameter's unit: the stated value times one plus the deviation.
            if (p.at("name") != e.at("name")) continue;
            double stated = NAN;
            for (const json& q : found.at("parameters"))
              if (q.at("name") == e.at("name")) stated = q.at("stated");
            const double value = p.at("value");
            error.push_back(std::abs((value / stated - 1) / wanted - 1));
            wanted = stated * (1 + wanted);
          } else {
            error.push_back(std::abs(p.at("value").get<double>() / wanted - 1));
          }
          cover.add(p["ci90"][0] <= wanted && p["ci90"][1] >= wanted);
        } else if (road) {
          // The mean over a stretch whose flanks take 15 % at either end is 0.85 of its top.
          error.push_back(std::abs(f.at("parameters")[0].at("value").get<double>() / (0.85 * e.at("amount").get<double>()) - 1));
        }
      }
    if (failed) {
      const auto join = [](const std::vector<std::string>& v) {
        std::string out;
        for (const std::string& s : v) out += (out.empty() ? "" : ", ") + s;
        return out.empty() ? std::string("nothing") : out;
      };
      double size = 0;
      for (const json& e : truth.at("effects")) size = std::max(size, e.at("size_sd").get<double>());
      failed_trials.push_back(here.filename().string());
      failures += fmt::format("| {} | {} | {} ({:.2g} sd) | {} | {} |\n", here.filename().string(), kind, join(truths), size, verdict, join(names));
    }
  }
  std::string text = "| metric | count | share | exact 95 % interval | floor |\n|---|---|---|---|---|\n";
  nlohmann::ordered_json metrics = nlohmann::ordered_json::array(), named = nlohmann::ordered_json::object();
  const auto line = [&](const char* what, const Count& k, const char* floor) {
    const auto [low, high] = interval(k.hits, k.of);
    text += fmt::format("| {} | {} of {} | {:.0f} % | {:.0f} to {:.0f} % | {} |\n", what, k.hits, k.of, k.of ? 100.0 * k.hits / k.of : 0.0, 100 * low, 100 * high, floor);
    metrics.push_back({{"metric", what}, {"hits", k.hits}, {"of", k.of}, {"interval", {low, high}}, {"floor", floor}});
  };
  line("false alarm when nothing is missing", alarm, "at most 5 %");
  line("right name first, effect of 0.5 sd or more", half, "80 %");
  line("right name first, effect of 1 sd or more", full, "90 %");
  line("the same, 0.5 sd or more, or among those that it could not be told from", tied, "");
  line("effect below 0.5 sd: none, or its name first", weak, "");
  line("parameter off within its prior width: none", inside, "");
  line("wrong name stated as explained, all trials", wrong, "at most 5 %");
  line("pairs that look alike reported as tie", tie, "80 %");
  line("not in the library: unknown or none", outside, "80 %");
  line("two at once: both named", both, "60 %");
  line("the same, both of 0.5 sd or more", both_large, "");
  line("two at once: at least one named", one, "90 %");
  line("90 % intervals that hold the truth", cover, "80 to 97 %");
  const auto middle = [&](const char* what, const std::vector<double>& values, double scale, const char* unit, const char* floor) {
    text += fmt::format("| {}, median of {} | | {} | | {} |\n", what, values.size(), values.empty() ? "" : fmt::format("{:.{}f}{}", scale * median(values), scale == 1 ? 2 : 0, unit), floor);
    metrics.push_back({{"metric", what}, {"of", values.size()}, {"median", median(values)}, {"floor", floor}});
  };
  middle("intersection over union of road findings", overlap, 1, "", "0.6");
  middle("error of the amount", error, 100, " %", "at most 15 %");
  middle("held-out improvement over what taking the effect away reaches", improvement, 100, " %", "70 %");
  text += "\n| single effect of 0.5 sd or more | named first |\n|---|---|\n";
  for (const auto& [mechanism, count] : by_mechanism) {
    text += fmt::format("| {} | {} of {} |\n", mechanism, count.hits, count.of);
    named[mechanism] = {{"first", count.hits}, {"of", count.of}};
  }
  text += fmt::format("\n| trial | class | truth | verdict | named |\n|---|---|---|---|---|\n{}", failures);
  terminal.print(
      terminal.json
          ? base::json_text(nlohmann::ordered_json{
                {"metrics", metrics}, {"single_effects", named}, {"failures", failed_trials}})
          : text);
  return kOk;
}

}  // namespace

int trials(const TrialsCommand& command, Terminal& terminal) {
  if (command.what == "make") return make(command, terminal);
  if (command.what == "run") return run_all(command, terminal);
  return score(command, terminal);
}

}  // namespace crgexplain
