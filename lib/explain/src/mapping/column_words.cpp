#include "column_words.h"

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <iterator>
#include <map>
#include <numbers>
#include <string_view>

#include "base/letters.h"
#include "base/text_lines.h"

namespace explain {
namespace {

struct Unit {
  const char* quantity;
  const char* name;
  double scale;
  double zero = 0.0;
};
constexpr Unit kUnits[] = {{"time", "s", 1},
                           {"time", "unixtime", 1},
                           {"time", "ms", 1e-3},
                           {"time", "us", 1e-6},
                           {"time", "ns", 1e-9},
                           {"time", "min", 60},
                           {"time", "h", 3600},
                           {"length", "m", 1},
                           {"length", "mm", 1e-3},
                           {"length", "km", 1e3},
                           {"length", "ft", 0.3048},
                           {"angle", "rad", 1},
                           {"angle", "deg", kDegree},
                           {"angle", "degrees", kDegree},
                           {"angle", "°", kDegree},
                           {"rate", "°/s", kDegree},
                           {"speed", "kmh", 1 / 3.6},
                           {"acceleration", "m/s/s", 1},
                           {"pressure", "mbar", 100.0},
                           {"turn", "revs/min", std::numbers::pi / 30},
                           {"turn", "min-1", std::numbers::pi / 30},
                           {"turn", "r/min", std::numbers::pi / 30},
                           {"speed", "m/s", 1},
                           {"speed", "mps", 1},
                           {"speed", "km/h", 1 / 3.6},
                           {"speed", "kmph", 1 / 3.6},
                           {"speed", "kph", 1 / 3.6},
                           {"speed", "mm/s", 1e-3},
                           {"speed", "ft/s", 0.3048},
                           {"speed", "mph", 0.44704},
                           {"speed", "knots", 1852.0 / 3600},
                           {"speed", "kn", 1852.0 / 3600},
                           {"rate", "rad/s", 1},
                           {"rate", "dps", kDegree},
                           {"rate", "deg/sec", kDegree},
                           {"rate", "radps", 1},
                           {"rate", "deg/s", kDegree},
                           {"rate", "degps", kDegree},
                           {"acceleration", "m/s^2", 1},
                           {"acceleration", "m/s2", 1},
                           {"acceleration", "m/s²", 1},
                           {"acceleration", "mps2", 1},
                           {"acceleration", "g", 9.80665},
                           {"share", "%", 0.01},
                           {"share", "1", 1},
                           {"pressure", "pa", 1},
                           {"pressure", "kpa", 1e3},
                           {"pressure", "mpa", 1e6},
                           {"pressure", "bar", 1e5},
                           {"pressure", "psi", 6894.757},
                           {"turn", "rad/s", 1},
                           {"turn", "radps", 1},
                           {"turn", "rpm", std::numbers::pi / 30},
                           {"turn", "1/min", std::numbers::pi / 30},
                           {"temperature", "k", 1},
                           {"temperature", "kelvin", 1},
                           {"temperature", "c", 1, 273.15},
                           {"temperature", "degc", 1, 273.15},
                           {"temperature", "celsius", 1, 273.15},
                           {"temperature", "°c", 1, 273.15},
                           {"temperature", "f", 5.0 / 9, 273.15 - 32 * 5.0 / 9},
                           {"temperature", "degf", 5.0 / 9, 273.15 - 32 * 5.0 / 9},
                           {"temperature", "°f", 5.0 / 9, 273.15 - 32 * 5.0 / 9},
                           {"time", "sec", 1},
                           {"time", "second", 1},
                           {"time", "seconds", 1},
                           {"time", "msec", 1e-3},
                           {"time", "milliseconds", 1e-3},
                           {"time", "usec", 1e-6},
                           {"time", "nsec", 1e-9},
                           {"angle", "degree", kDegree},
                           {"angle", "degrees", kDegree},
                           {"angle", "radians", 1},
                           {"speed", "meters/second", 1},
                           {"speed", "metres/second", 1},
                           {"speed", "m/sec", 1},
                           {"speed", "km/hr", 1 / 3.6},
                           {"speed", "miles/hour", 0.44704},
                           {"speed", "knot", 1852.0 / 3600},
                           {"speed", "kts", 1852.0 / 3600},
                           {"rate", "rads^-1", 1},
                           {"rate", "degrees/s", kDegree},
                           {"rate", "degrees/sec", kDegree},
                           {"rate", "degrees/second", kDegree},
                           {"acceleration", "ms^-2", 1},
                           {"share", "pct", 0.01},
                           {"share", "percent", 0.01}};

std::vector<Alias> aliases_of_places_and_speeds() {
  return {
      {"time_s", "time", {"time",        "t",           "ts",
                          "timestamp",   "times",       "logtime",
                          "sessiontime", "elapsedtime", "zeit",
                          "temps",       "tiempo",      "tempo",
                          "utc",         "timeutc",     "utctime",
                          "unixtime",    "epoch",       "gpstime",
                          "instime",     "metatime",    "rosbagtimestamp",
                          "zeitstempel", "xtime",       "tow",
                          "gpstow",      "itow",        "devicetime",
                          "timestamps",  "timestampms", "runtime",
                          "seconds",     "cts",         "timems",
                          "offset",      "interval",    "utctimeinms"}},
      {"x_m",
       "length",
       {"x", "tx", "posx", "xposition", "positionx", "worldpositionx", "locationx", "east",
        "easting"}},
      {"y_m",
       "length",
       {"y", "ty", "posy", "yposition", "positiony", "worldpositiony", "locationy", "north",
        "northing"}},
      {"latitude_rad",
       "angle",
       {"latitude", "lat", "latitudens", "gpslatitude", "gpslat", "vboxlatmin", "breitengrad"}},
      {"longitude_rad",
       "angle",
       {"longitude", "long", "lon", "longitudeew", "lng", "gpslongitude", "vboxlongminutes",
        "lngengrad", "laengengrad", "longtitude", "gpslong", "gpslon", "gpslng"}},
      {"z_m",
       "length",
       {"z", "tz", "posz", "positionz", "worldpositionz", "altitude", "height", "alt",
        "gpsaltitude"}},
      {"yaw_rad",
       "angle",
       {"yaw", "phi", "psi", "heading", "yawnorth", "gierwinkel", "orientationyaw"}},
      {"vx_mps",
       "speed",
       {"vx",
        "velx",
        "linearx",
        "speed",
        "vlong",
        "velocityx",
        "velocity",
        "groundspeed",
        "speedo",
        "gpsspeed",
        "speedoverground",
        "vehiclespeed",
        "geschwindigkeit",
        "vitesse",
        "velocita",
        "velocidad",
        "gspeed",
        "vfzg",
        "vss",
        "vss1",
        "kph",
        "kmh",
        "mph",
        "carspeed",
        "spd",
        "vel",
        "gps2dspeed"}},
      {"vx_mps", "speed", {"speedx", "vego", "velocidadedoveculo", "velocidaddelvehculo"}},
      {"vy_mps", "speed", {"vy", "vely", "lineary", "vlat", "velocityy", "speedy"}},
      {"yaw_rate_radps",
       "rate",
       {"yawrate", "omega", "r", "gyroz", "omegaz", "wz", "angularz", "angularvelocityz",
        "gyroyawvelocity", "yawvelocity", "gpsgyro", "gyroscopez", "gierrate",
        "giergeschwindigkeit"}},
      {"roll_rate_radps",
       "rate",
       {"rollrate", "gyrox", "gyroscopex", "angularx", "angularvelocityx"}},
      {"pitch_rate_radps",
       "rate",
       {"pitchrate", "gyroy", "gyroscopey", "angulary", "angularvelocityy"}},
  };
}

std::vector<Alias> aliases_of_accelerations_and_controls() {
  return {
      {"ax_mps2",
       "acceleration",
       {"ax", "accx", "linearaccelerationx", "accelerationx", "along", "accelx", "longacc",
        "gforcelong", "longitudinalacc", "longitudinalacceleration", "longaccel", "inlineacc",
        "lonacc"}},
      {"ax_mps2",
       "acceleration",
       {"longitudinal", "inline", "linealg", "longitudinalg", "longg", "gforcex",
        "gforcelongitudinal", "glong", "glon", "gpslonacc", "gpslongacc", "lngsbeschleunigung",
        "laengsbeschleunigung"}},
      {"ay_mps2",
       "acceleration",
       {"ay",       "accy",      "linearaccelerationy", "accelerationy", "alat",
        "accely",   "latacc",    "gforcelat",           "lateralacc",    "lateralacceleration",
        "lataccel", "gpslatacc", "querbeschleunigung",  "lateral",       "lateralg",
        "latg",     "gforcey",   "gforcelateral",       "glat",          "aqfzg"}},
      {"az_mps2",
       "acceleration",
       {"az", "accz", "linearaccelerationz", "accelerationz", "accelz", "vertaccel", "gforcevert",
        "verticalacc"}},
      {"steer_rad",
       "angle",
       {"delta", "steer", "steering", "roadwheelangle", "steerangle", "steeredangle",
        "steeringangle", "steeringwheelangle", "lenkwinkel", "volant"}},
      {"steer_command_rad", "angle", {"steercmd", "steercommand", "deltacmd"}},
      {"throttle",
       "share",
       {"throttle", "throttlepos", "throttleposition", "tps", "tps1", "aps", "pps", "drosselklappe",
        "thrtl", "throttleopeningangle", "absolutethrottleposition", "tp", "tpmain"}},
      {"throttle_command",
       "share",
       {"throttlecommand", "gas", "throttlecmd", "throttlepedcmd", "throttlepedalcmd", "pedal",
        "accelerator", "accelposition", "accelpedalposition", "throttlepedal", "acceleratorpos",
        "acceleratorposition", "gaspedal", "fahrpedal"}},
      {"brake_pa", "pressure", {"brake", "brakepressure", "brakepress"}},
      {"brake_command_pa",
       "pressure",
       {"brakecommand", "brakecmd", "brakepedcmd", "brakepedalcmd"}},
      {"gear",
       "none",
       {"gear", "ngear", "currentgear", "gearposition", "gang", "marcia", "rapport"}},
      {"engine_radps",
       "turn",
       {"engine", "rpm", "rpms", "engspeed", "currentenginerpm", "enginespeed", "enginerpm", "nmot",
        "motordrehzahl", "drehzahl", "regime", "giri", "rpmdomotor", "rpmdelmotor"}},
      {"fuel_kg", "none", {"fuel", "fuelmass"}},
      // Of M Laptimer, and of a game's MoTeC files.
      {"latitude_rad", "angle", {"latitudeyposition"}},
      {"longitude_rad", "angle", {"longitudexposition"}},
      {"ax_mps2", "acceleration", {"accelerationgs"}},
      {"ay_mps2", "acceleration", {"lateralgs"}},
      {"throttle_command", "share", {"driverthrottlepos"}},
  };
}

}  // namespace

const std::vector<Alias>& aliases() {
  static const std::vector<Alias> list = [] {
    std::vector<Alias> out = aliases_of_places_and_speeds();
    for (const Alias& alias : aliases_of_accelerations_and_controls()) out.push_back(alias);
    return out;
  }();
  return list;
}

namespace {

std::string lower_of(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// "yaw_rate_degps" is "yaw_rate" in "deg/s".
std::pair<std::string, std::string> split_ending(const std::string& column) {
  static const std::map<std::string, const char*, std::less<>> units{
      {"mps2", "m/s2"}, {"mps", "m/s"},  {"radps", "rad/s"}, {"degps", "deg/s"}, {"rad", "rad"},
      {"deg", "deg"},   {"kmh", "km/h"}, {"kph", "km/h"},    {"mph", "mph"},     {"g", "g"},
      {"rpm", "rpm"},   {"bar", "bar"},  {"kpa", "kpa"},     {"psi", "psi"},     {"m", "m"},
      {"mm", "mm"},     {"s", "s"},      {"sec", "s"},       {"seconds", "s"},   {"ms", "ms"},
      {"us", "us"},     {"ns", "ns"},    {"pct", "%"},       {"kmph", "km/h"}};
  for (const auto& [ending, unit] :
       std::initializer_list<std::pair<std::string, const char*>>{{"_m_s", "m/s"},
                                                                  {"_km_h", "km/h"},
                                                                  {"_rad_s", "rad/s"},
                                                                  {"_deg_s", "deg/s"},
                                                                  {"_m_s2", "m/s2"}})
    if (column.size() > ending.size() && column.ends_with(ending))
      return {column.substr(0, column.size() - ending.size()), unit};
  const std::string lower = lower_of(column);
  const std::size_t at = column.rfind('_');
  if (at == std::string::npos || at == 0) {  // "SpeedMPH"
    const auto glued = lower.starts_with("speed") ? units.find(lower.substr(5)) : units.end();
    return glued != units.end() && unit_scale("speed", glued->second)
               ? std::pair{column.substr(0, 5), std::string(glued->second)}
               : std::pair{column, std::string()};
  }
  const auto unit = units.find(lower.substr(at + 1));
  return unit == units.end() ? std::pair{column, std::string()}
                             : std::pair{column.substr(0, at), std::string(unit->second)};
}

/// Where a signal comes from or stands for, behind its name: "latacc-calc", "ax_cg", "speed_can".
std::string without_origin(const std::string& stem) {
  for (const std::string ending :
       {"calc", "can", "obd", "gps", "cg", "cog", "imu", "ins", "gyro", "meas", "measured"}) {
    const std::size_t at = stem.size() - std::min(stem.size(), ending.size());
    if (at < 2 || (stem[at - 1] != '_' && stem[at - 1] != '-' && stem[at - 1] != ' ')) continue;
    if (lower_of(stem.substr(at)) == ending) return stem.substr(0, at - 1);
  }
  return stem;
}

}  // namespace

std::pair<std::string, std::string> split_unit(const std::string& column) {
  const std::size_t first = column.find_first_of("([");
  if (first == std::string::npos || first == 0) return split_ending(column);
  // "velocity[0]" is an element, and its own name.
  if (column.size() > first + 2 && column.back() == ']' &&
      column.find_first_not_of("0123456789", first + 1) == column.size() - 1)
    return {column, ""};
  const std::string stem(base::trimmed(std::string_view(column).substr(0, first)));
  std::string unit;
  // "Speed (OBD)(km/h)": the last one that is a unit, else the first.
  for (std::size_t open = first; open != std::string::npos;) {
    const std::size_t close = std::min(column.find_first_of(")]", open), column.size());
    std::string lower = lower_of(column.substr(open + 1, close - open - 1));
    std::erase(lower, ' ');
    if (open == first || is_unit(lower)) unit = lower;
    open = column.find_first_of("([", close);
  }
  return {stem, unit};
}

std::optional<double> unit_scale(const std::string& quantity, const std::string& unit) {
  for (const Unit& u : kUnits)
    if (quantity == u.quantity && unit == u.name) return u.scale;
  return std::nullopt;
}

double unit_zero(const std::string& quantity, const std::string& unit) {
  for (const Unit& u : kUnits)
    if (quantity == u.quantity && unit == u.name) return u.zero;
  return 0.0;
}

bool is_unit(const std::string& unit) {
  return std::any_of(std::begin(kUnits), std::end(kUnits),
                     [&](const Unit& u) { return unit == u.name; });
}

std::string unit_by_word(const std::string& word) {
  const auto is_one_of = [&](std::initializer_list<const char*> names) {
    return std::any_of(names.begin(), names.end(), [&](const char* name) { return word == name; });
  };
  if (word.starts_with("gforce") ||
      is_one_of({"lateralg", "latg", "linealg", "longitudinalg", "longg", "glong", "glon", "glat",
                 "lateralgs", "accelerationgs"}))
    return "g";
  if (is_one_of(
          {"rpm", "rpms", "enginerpm", "currentenginerpm", "nmot", "motordrehzahl", "drehzahl"}))
    return "rpm";
  if (is_one_of({"kph", "kmh"})) return "km/h";
  if (word == "mph") return "mph";
  if (word.starts_with("linearacceleration")) return "m/s2";  // of ROS and Android
  if (is_one_of({"timestampms", "timems", "cts"})) return "ms";
  return word == "seconds" ? "s" : "";
}

std::vector<std::string> words_of(const std::string& stem) {
  // Fields of a topic: "/odom.pose.position.x", "field.position.x", or of its messages alone.
  const bool of_topic = stem.starts_with('/') || stem.starts_with("field.") ||
                        stem.starts_with("pose.") || stem.starts_with("twist.");
  const std::size_t last = stem.rfind('.');
  if (!of_topic || last == std::string::npos) {
    std::vector<std::string> out{base::letters_and_digits_of(stem)};
    if (const std::string shorter = without_origin(stem); shorter != stem)
      out.push_back(base::letters_and_digits_of(shorter));
    // Of a bus with its message, of a program's variables: "ABS::CarSpeed", "m_speed".
    if (const std::size_t colons = stem.rfind("::"); colons != std::string::npos)
      out.push_back(base::letters_and_digits_of(stem.substr(colons)));
    // What an engine's controller has at its top: "engine/rpm", "sensors/gear".
    for (const std::string_view group : {"m_", "engine/", "sensors/", "vehicle/", "gps/", "imu/"})
      if (stem.starts_with(group))
        out.push_back(base::letters_and_digits_of(stem.substr(group.size())));
    return out;
  }
  std::vector<std::string> out;
  if (const std::size_t before = stem.rfind('.', last - 1); before != std::string::npos)
    out.push_back(base::letters_and_digits_of(stem.substr(before)));
  if (const std::string word = base::letters_and_digits_of(stem.substr(last)); word.size() > 1)
    out.push_back(word);
  return out;
}

}  // namespace explain
