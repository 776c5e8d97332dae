// The tour: every other program once, on a circuit that comes with them.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <system_error>

#include "base/error.h"
#include "base/json_text.h"
#include "base/read_file.h"
#include "base/sha256.h"
#include "base/shell_word.h"
#include "base/write_file.h"
#include "command/exit_code.h"
#include "commands.h"
#include "verbs.h"

namespace kerbstone {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Words = std::vector<std::string>;

/// What the recorded car has otherwise than its file states.
struct Effect {
  const char *parameter, *what, *unit;
  double stated, factor;
};
constexpr std::array kEffects = {
    Effect{"aero.drag_area_m2", "drag area", "m2", 0.95, 1.2},
    Effect{"front.lift_area_m2", "downforce area in front", "m2", 1.1, 0.8},
    Effect{"engine.torque", "engine torque (factor)", "", 1.0, 0.88},
};

constexpr const char* kWordsOfSteps = "steps.txt";

/// Runs a program in `folder`; what it says goes behind what the others said. Throws Error where it
/// fails.
void run_step(const fs::path& folder, Words words) {
  const std::string said = folder / kWordsOfSteps;
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  ::posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, 1, kWordsOfSteps, O_RDWR | O_APPEND, 0);
  ::posix_spawn_file_actions_adddup2(&actions, 1, 2);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = -1;
  const int problem =
      ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (problem != 0)
    throw base::Error(
        fmt::format("{} cannot be started: {}; install it beside kerbstone, or where "
                    "PATH leads",
                    words[0], std::generic_category().message(problem)));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || (WEXITSTATUS(status) != 0 && WEXITSTATUS(status) != command::kNotValid))
    throw base::Error(fmt::format("{} failed; the last lines of {} say why", words[0], said));
}

/// A number of a JSON file that a step wrote.
Json json_of(const fs::path& path) { return base::parse_json<Json>(base::read_file(path)); }

/// Prints a step as somebody would type it, and runs it.
class Tour {
 public:
  Tour(fs::path folder, command::Terminal& terminal)
      : folder_(std::move(folder)), terminal_(terminal) {}

  void say(const std::string& line) const {
    if (terminal_.json || terminal_.quiet) return;
    terminal_.print(line + "\n");
    terminal_.finish();  // at once
  }
  /// `hidden`: runs with them too, and does not show them.
  void step(const std::string& what, Words words, const Words& hidden = {}) const {
    std::string shown;
    for (const std::string& word : words)
      shown += (shown.empty() ? "" : " ") + base::shell_word(word);
    say(fmt::format("\n{}\n  $ {}{}", what, shown, hidden.empty() ? "" : " ..."));
    words.insert(words.end(), hidden.begin(), hidden.end());
    run_step(folder_, std::move(words));
  }
  void result(const std::string& line) const { say("  " + line); }
  const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
  command::Terminal& terminal_;
};

std::string answer_of(const Effect& effect, unsigned seed) {
  return fmt::format("{}: {:.4g} {} where the file states {:.4g}; seed {}", effect.what,
                     effect.stated * effect.factor, effect.unit, effect.stated, seed);
}

std::string amount_of(const Json& finding) {
  std::string out = finding.at("mechanism").get<std::string>();
  for (const Json& p : finding.at("parameters"))
    if (p.at("value").is_number())
      out += fmt::format(", {} {:.4g} {}", p.at("name").get<std::string>(),
                         p.at("value").get<double>(), p.at("unit").get<std::string>());
  return out;
}

}  // namespace

int try_it(const TryCommand& command, command::Terminal& terminal) {
  const std::string own = own_folder();
  make_tools_found(own);
  const std::string circuit = example_file(own, "tracks/kerbstone-ring/circuit.yaml"),
                    car = example_file(own, "vehicles/open_wheel/vehicle.yaml");
  if (circuit.empty() || car.empty())
    throw base::Error(
        "the examples of kerbstone are not there: install them (share/doc/kerbstone/examples), or "
        "start kerbstone from the tree in which it was built");
  const auto begin = std::chrono::steady_clock::now();
  fs::create_directories(command.output);
  const Tour tour(fs::absolute(command.output), terminal);
  base::write_file(tour.folder() / kWordsOfSteps, "");

  tour.say("In " + tour.folder().string() + ":");
  tour.step("A mesh, as a simulator has it", {"crgbuild", "synth", circuit, "-o", "mesh"});
  tour.step("The mesh becomes a road",
            {"crgbuild", "build", "mesh/kerbstone-ring.obj", "-o", "road"});
  const Json road = json_of(tour.folder() / "road/summary.json");
  tour.result(fmt::format("{:.0f} m of road in road/kerbstone-ring.crg, a page in road/report.html",
                          road.at("reference_line").at("length_m").get<double>()));

  tour.step("Scans of a stretch, as a car with a LiDAR brings them",
            {"lidar2mesh", "synth", circuit, "-o", "scans", "--u-begin-m", "380", "--u-end-m",
             "440", "--laps", "1", "--cars", "0"});
  tour.step("The road is refined by the scans",
            {"lidar2mesh", "map", "scans", "--trajectory", "scans/trajectory.csv", "--road",
             "road/kerbstone-ring.crg", "-o", "refined"});

  const unsigned seed = command.seed.value_or(std::random_device{}());
  const Effect& effect = kEffects[seed % kEffects.size()];
  const std::string answer = answer_of(effect, seed);
  tour.say(
      fmt::format("\nNow one number of the car is changed, and recorded with. The answer is "
                  "sealed:\n  SHA-256 {}",
                  base::sha256(answer)));
  tour.step("A car drives two laps",
            {"crgdrive", "lap", "--car", car, "--road", "road/kerbstone-ring.crg", "--laps", "2",
             "--rate-hz", "50", "-o", "recording.csv"},
            {"--set", fmt::format("{}={}", effect.parameter, effect.stated * effect.factor)});
  tour.step("Why do the recording and the simulation of the car's file differ?",
            {"crgexplain", "run", "--road", "road/kerbstone-ring.crg", "--car", car, "--log",
             "recording.csv", "--skip-simulation", "-o", "found"});
  const Json found = json_of(tour.folder() / "found/findings.json");
  const auto verdict = found.at("verdict").get<std::string>();
  tour.result("verdict: " + verdict);
  for (const Json& finding : found.at("findings")) tour.result("found: " + amount_of(finding));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  tour.say(
      fmt::format("\nThe seal is broken:\n  {}\n\nPages: road/report.html, refined/report.html, "
                  "found/report.html in {}; what the programs said: {}. {:.0f} s",
                  answer, tour.folder().string(), kWordsOfSteps, seconds));
  if (terminal.json)
    terminal.print(base::json_text(Json{{"folder", tour.folder().string()},
                                        {"sealed_sha256", base::sha256(answer)},
                                        {"answer", answer},
                                        {"hidden", effect.stated * effect.factor},
                                        {"verdict", verdict},
                                        {"findings", found.at("findings")},
                                        {"seconds", seconds}}));
  terminal.finish();
  if (!command.no_open) open_browser((tour.folder() / "found/report.html").string());
  return command::kOk;
}

}  // namespace kerbstone
