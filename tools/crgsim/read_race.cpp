#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/settings.h"
#include "commands.h"

namespace crgsim {
namespace {

constexpr std::size_t kMostCars = 16;

using base::Section, base::Setting;

/// Names are parts of the names of topics and files.
bool is_name(const std::string& name) {
  const auto letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  return !name.empty() && name.size() <= 40 && letter(name[0]) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return letter(c) || (c >= '0' && c <= '9'); });
}

/// As options of serve of the same names would have said it: a later one counts.
void read_car(const Section& said, ServeCommand& car) {
  said.allow({"unit", "command", "measure", "record", "devices", "road", "inputs", "set", "safe",
              "opponent", "every", "safe_after_s", "patience_s", "seed"});
  const std::filesystem::path folder = std::filesystem::path(said.path()).parent_path();
  const auto beside = [&](const std::string& path) { return (folder / path).string(); };
  for (const auto& [key, path] : {std::pair{"unit", &car.unit_path},
                                  {"devices", &car.devices_path},
                                  {"road", &car.road_path},
                                  {"inputs", &car.inputs_path}})
    if (said.has(key)) *path = beside(said.text(key));
  for (const auto& [key, names] : {std::pair{"command", &car.commands},
                                   {"measure", &car.measurements},
                                   {"record", &car.recorded}})
    if (said.has(key)) *names = said.words(key);
  if (said.has("opponent")) {
    car.opponents.clear();
    for (const std::string& drive : said.words("opponent")) car.opponents.push_back(beside(drive));
  }
  for (const auto& [key, values] : {std::pair{"set", &car.starts}, {"safe", &car.safe}})
    if (said.has(key))
      said.section(key).for_each([&car, values = values](const std::string& name,
                                                         const Setting& value,
                                                         const std::string& where) {
        if (value.kind != Setting::Kind::kWord)
          throw base::Error(fmt::format("{}: no value of {}", where, name.substr(0, 60)));
        if (values == &car.safe) base::to_number(value.word, where, name);
        values->push_back(name + "=" + value.word);
      });
  car.every = static_cast<unsigned>(said.number("every", car.every, 1.0, 1e6));
  car.safe_after_s = said.number("safe_after_s", car.safe_after_s, 1e-3, 1e6);
  car.patience_s = said.number("patience_s", car.patience_s, 1e-3, 1e6);
  if (said.has("seed")) car.seed = static_cast<std::uint64_t>(said.number("seed", 1.0, 0.0, 9e15));
}

}  // namespace

std::vector<RaceCar> read_race(const RaceCommand& command) {
  const Setting root = base::read_settings(command.race_path);
  const Section top(root, command.race_path, "a race");
  top.allow({"each", "cars"});
  ServeCommand each;
  each.lockstep = command.lockstep;
  each.stop_s = command.stop_s;
  each.step_s = command.step_s;
  each.speed_up = command.speed_up;
  each.dds = command.dds;
  each.domain = command.domain;
  each.limits = command.limits;
  if (top.has("each")) read_car(top.section("each"), each);
  std::vector<RaceCar> cars;
  top.section("cars").for_each(
      [&](const std::string& name, const Setting& value, const std::string& where) {
        if (!is_name(name))
          throw base::Error(fmt::format(
              "{}: '{}' is no name of a car: letters, digits and _ wanted, a letter first", where,
              name.substr(0, 60)));
        RaceCar car{name, each};
        if (value.kind != Setting::Kind::kNothing)
          read_car(Section(value, command.race_path, name), car.serve);
        if (car.serve.unit_path.empty())
          throw base::Error(
              fmt::format("{}: {} has no unit; name its file: unit: car.fmu", where, name));
        if (!command.dds && (car.serve.commands.empty() || car.serve.measurements.empty()))
          throw base::Error(fmt::format(
              "{}: {} wants lists of names, command and measure, but with --dds", where, name));
        if (!command.socket_path.empty()) car.serve.socket_path = command.socket_path + "." + name;
        if (command.udp_port != 0) {
          const std::size_t port = command.udp_port + cars.size();
          if (port > 65535)
            throw command::UsageError(fmt::format(
                "--udp {}: the ports from there are fewer than the cars", command.udp_port));
          car.serve.udp_port = static_cast<std::uint16_t>(port);
        }
        car.serve.topic_prefix = name + "/";
        cars.push_back(std::move(car));
      });
  if (cars.empty() || cars.size() > kMostCars)
    throw base::Error(
        fmt::format("{}: {} cars; 1 to {} wanted", command.race_path, cars.size(), kMostCars));
  return cars;
}

}  // namespace crgsim
