#include "wish.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "live_link.h"

namespace view {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using Words = std::vector<std::string>;

// What a person drives with and sees, of the units that `crgdrive fmu` makes.
constexpr std::array kBrakes = {"input.brake.fl", "input.brake.fr", "input.brake.rl",
                                "input.brake.rr"};
constexpr std::array kDriven = {"input.steering",
                                "input.throttle",
                                "input.brake.fl",
                                "input.brake.fr",
                                "input.brake.rl",
                                "input.brake.rr",
                                "input.gear",
                                "parameter.environment.wind_mps",
                                "parameter.environment.wind_heading_rad",
                                "parameter.environment.road_grip"};
constexpr std::array kShown = {"car.x",
                               "car.y",
                               "car.yaw",
                               "car.vx",
                               "car.u",
                               "car.gear",
                               "car.engine",
                               "car.steer",
                               "car.throttle",
                               "car.z",
                               "car.roll",
                               "car.pitch",
                               "car.ax",
                               "car.ay",
                               "wheel.fl.brake",
                               "parameter.engine.limit_radps",
                               "parameter.steering.ratio"};

constexpr std::array kWheels = {"fl", "fr", "rl", "rr"};
constexpr std::array kShownOfWheel = {"fz",        "fx",        "fy",        "kappa",
                                      "tan_alpha", "contact_x", "contact_y", "contact_z"};

constexpr std::size_t kMostClouds = 1000, kMostParameters = 50;

std::string text_of(const ordered_json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::string number_of(const ordered_json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number())
    throw Refusal(400, fmt::format("{}: a number wanted", key));
  return fmt::format("{}", found->get<double>());
}

void append(Words& command, const Words& words) {
  command.insert(command.end(), words.begin(), words.end());
}

/// aalborg for tracks/aalborg/track.yaml, ring for meshes/ring.obj.
std::string name_of(const fs::path& path) {
  const fs::path stem = path.stem();
  if (stem == "track" && path.has_parent_path()) return path.parent_path().filename().string();
  return stem.string();
}

/// `below` the first folder, where nothing leads out of the folders by a link.
const std::string& checked(const Folders& folders, const std::string& below) {
  try {
    folders.check_written(below);
  } catch (const base::Error& error) {
    throw Refusal(403, error.what());
  }
  return below;
}

/// out/drives/car-2.csv where car-1.csv is there already. Its folder is made.
std::string new_file(const Folders& folders, const std::string& folder, const std::string& name,
                     const char* ending) {
  const fs::path root = folders.root(0);
  fs::create_directories(root / checked(folders, folder));
  for (int number = 1;; ++number) {
    std::string path = fmt::format("{}/{}-{}{}", folder, name, number, ending);
    if (!fs::exists(root / path)) return path;
  }
}

/// A file that is named, as seen from the first folder.
std::string path_of(const ordered_json& wish, const char* key, const Folders& folders) {
  try {
    const fs::path whole = folders.path_of(text_of(wish, key));
    const fs::path below = whole.lexically_relative(folders.root(0));
    return below.empty() || *below.begin() == ".." ? whole.string() : below.string();
  } catch (const base::Error& error) {
    throw Refusal(404, fmt::format("{}: {}", key, error.what()));
  }
}

/// Names of parameters that the person who drives may set; none that could be taken for a flag.
Words parameters_of(const ordered_json& wish) {
  const auto found = wish.find("parameters");
  if (found == wish.end()) return {};
  Words out;
  if (found->is_array() && found->size() <= kMostParameters)
    for (const ordered_json& each : *found)
      if (each.is_string()) out.push_back(each.get<std::string>());
  const bool are_names = found->is_array() && out.size() == found->size() &&
                         std::all_of(out.begin(), out.end(), [](const std::string& name) {
                           return (name.starts_with("parameter.") || name.starts_with("term.")) &&
                                  std::find(kDriven.begin(), kDriven.end(), name) == kDriven.end();
                         });
  if (!are_names)
    throw Refusal(400, fmt::format("parameters: a list of at most {} names wanted that begin with "
                                   "parameter. or term. and are no part of the weather",
                                   kMostParameters));
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

/// `devices`, where there are any, look at the road of `wish`.
Wish drive(const std::string& unit, const ordered_json& wish, const Folders& folders) {
  Wish out;
  out.unit = (fs::path(folders.root(0)) / unit).string();
  out.agreed = text_of(wish, "agreed");
  out.port = free_udp_port();
  out.result = new_file(folders, "out/drives", name_of(unit), ".csv");
  out.command = {"crgsim", "serve", unit, "--udp", std::to_string(out.port)};
  for (const char* const name : kDriven) append(out.command, {"--command", name});
  for (const char* const name : kShown) append(out.command, {"--measure", name});
  for (const char* const wheel : kWheels)
    for (const char* const what : kShownOfWheel)
      append(out.command, {"--measure", fmt::format("wheel.{}.{}", wheel, what)});
  for (const std::string& name : parameters_of(wish)) {
    append(out.command, {"--command", name});
    if (std::find(kShown.begin(), kShown.end(), name) == kShown.end())
      append(out.command, {"--measure", name});
  }
  // Nobody at the wheel: it brakes.
  for (const char* const brake : kBrakes)
    append(out.command, {"--safe", std::string(brake) + "=2e6"});
  append(out.command,
         {"--safe-after-s", "0.5", "--every", "10", "--stop-s", "3600", "-o", out.result});
  if (text_of(wish, "devices").empty()) return out;
  append(out.command,
         {"--devices", path_of(wish, "devices", folders), "--road", path_of(wish, "road", folders),
          "--sights", out.result.substr(0, out.result.size() - 4) + ".sights.jsonl"});
  return out;
}

/// The stretch alone; the mesh as it was cleaned for the whole road is taken from there.
Wish stretch(const std::string& input, const ordered_json& wish, const Folders& folders) {
  const fs::path root = folders.root(0);
  const std::string name = name_of(root / input), whole = "out/" + name;
  fs::create_directories(root / checked(folders, "out/stretches"));
  Wish out;
  out.result = "out/stretches/" + name + ".crg";
  out.command = {"crgbuild",
                 "stretch",
                 input,
                 "--u-begin-m",
                 number_of(wish, "u_begin_m"),
                 "--u-end-m",
                 number_of(wish, "u_end_m"),
                 "-o",
                 out.result};
  if (fs::is_directory(root / whole)) append(out.command, {"--build", whole});
  return out;
}

/// A lap of the built-in driver, beside the drives of persons.
Wish lap(const ordered_json& wish, const Folders& folders) {
  const fs::path vehicle = path_of(wish, "vehicle", folders);
  Wish out;
  const std::string of = fs::absolute(folders.root(0) / vehicle).parent_path().filename().string();
  out.result = new_file(folders, "out/drives", of + "-lap", ".csv");
  out.command = {"crgdrive",       "lap",    "--car",
                 vehicle.string(), "--road", path_of(wish, "road", folders)};
  if (!text_of(wish, "friction").empty())
    append(out.command, {"--grip", path_of(wish, "friction", folders)});
  append(out.command, {"-o", out.result});
  return out;
}

/// Of one cloud, or of several as one set: each is named, so that no link leads elsewhere.
Wish tiles(const ordered_json& wish, const Folders& folders) {
  const auto clouds = wish.find("clouds");
  if (clouds == wish.end() || !clouds->is_array() || clouds->empty() ||
      clouds->size() > kMostClouds)
    throw Refusal(400, fmt::format("clouds: a list of 1 to {} files wanted", kMostClouds));
  Wish out;
  out.command = {"lidar2mesh", "tiles"};
  for (const ordered_json& cloud : *clouds)
    out.command.push_back(path_of(ordered_json{{"cloud", cloud}}, "cloud", folders));
  const fs::path first = fs::path(folders.root(0)) / out.command[2];
  out.result = "out/" +
               (clouds->size() == 1 ? name_of(first) : first.parent_path().filename().string()) +
               "-tiles";
  append(out.command, {"-o", out.result});
  if (!text_of(wish, "trajectory").empty())
    append(out.command, {"--trajectory", path_of(wish, "trajectory", folders)});
  return out;
}

}  // namespace

std::string result_of(const std::string& path) { return "out/" + name_of(path); }

Wish wish_of(const ordered_json& wish, const Folders& folders, const std::string& demo) {
  if (!wish.is_object()) throw Refusal(400, "a JSON object wanted");
  const std::string what = text_of(wish, "do");
  const auto path = [&](const char* key) { return path_of(wish, key, folders); };
  Wish out;
  if (what == "preview") {
    out.command = {"crgbuild", "preview", path("input"), "-o", "-"};
    if (wish.value("raw", ordered_json()) == true) out.command.emplace_back("--raw");
  } else if (what == "build") {
    const std::string input = path("input");
    out.result = result_of((fs::path(folders.root(0)) / input).string());
    out.command = {"crgbuild", "build", input, "-o", out.result};
  } else if (what == "report") {
    const std::string road = path("road");
    out.result = "out/" + name_of(road) + "-report";
    out.command = {"crgbuild", "report", road, "-o", out.result};
    for (const char* const flag : {"mesh", "against", "cloud"})
      if (!text_of(wish, flag).empty()) append(out.command, {std::string("--") + flag, path(flag)});
  } else if (what == "keep") {
    const std::string road = path("road");
    out.result = new_file(folders, "out/kept", name_of(road), ".crg");
    out.command = {"crgbuild", "convert", road, "-o", out.result};
  } else if (what == "stretch") {
    out = stretch(path("input"), wish, folders);
  } else if (what == "tiles") {
    out = tiles(wish, folders);
  } else if (what == "demo") {
    if (demo.empty()) throw Refusal(404, "the demo circuit was not installed with this program");
    out.result = "demo";
    out.command = {"crgbuild", "synth", demo, "-o", out.result};
  } else if (what == "lap") {
    out = lap(wish, folders);
  } else if (what == "info") {
    out.command = {"crgsim", "info", path("unit"), "--json"};
  } else if (what == "drive") {
    out = drive(path("unit"), wish, folders);
  } else {
    throw Refusal(
        400, fmt::format("do: '{}' seen; preview, build, stretch, keep, report, tiles, demo, lap, "
                         "info or drive wanted",
                         what));
  }
  if (!out.result.empty()) checked(folders, out.result);
  return out;
}

}  // namespace view
