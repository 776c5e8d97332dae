#include "wheel_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "recording/channels.h"

namespace explain {
namespace {

using Words = std::vector<const char*>;
constexpr const char* kPressure = "pressure";

/// What is measured, by its name without the wheel. Letters with accents are left out of names,
/// because their encoding is not known.
struct AtWheel {
  const char* form;      ///< of the channel
  const char* quantity;  ///< of its unit
  Words names;
};
const std::array<AtWheel, 3> kMeasured{
    {{"brake_disc_{}_k",
      "temperature",
      {"braketemp",
       "braketemperature",
       "brakedisctemp",
       "brakedisctemperature",
       "disctemp",
       "disctemperature",
       "brakerotortemp",
       "rotortemp",
       "rotortemperature",
       "bremstemperatur",
       "bremstemp",
       "bremsentemperatur",
       "bremsscheibentemperatur",
       "scheibentemperatur",
       "temperaturefrein",
       "tempraturefrein",
       "tempfrein",
       "temperaturedisque",
       "tempraturedisque",
       "tempdisque",
       "temperaturafreno",
       "tempfreno",
       "temperaturadisco",
       "tempdisco"}},
     {"suspension_{}_m",
      "length",
      {"susppos",
       "suspensionpos",
       "suspensionposition",
       "susptravel",
       "suspensiontravel",
       "suspension",
       "wheeltravel",
       "damperpos",
       "damperposition",
       "dampertravel",
       "damperdisplacement",
       "damper",
       "shockdefl",
       "shockdeflection",
       "shockpos",
       "shockposition",
       "shocktravel",
       "federweg",
       "einfederung",
       "daempferweg",
       "dmpferweg",
       "debattement",
       "dbattement",
       "courseamortisseur",
       "coursesuspension",
       "corsaammortizzatore",
       "corsasospensione",
       "recorridosuspension",
       "recorridosuspensin",
       "recorridoamortiguador"}},
     {"brake_{}_pa",
      kPressure,
      {"pbrake", "brakepressure", "brakepress", "brakepres", "brakelinepress", "brakelinepressure",
       "bremsdruck", "pressionfrein", "pressionefreno", "pressionefreni", "presionfreno",
       "presinfreno"}}}};

/// How a wheel or an axle is called; wheels as in recording::kWheelNames.
struct WheelPlace {
  std::vector<std::size_t> wheels;
  Words names;
};
const std::array<WheelPlace, 6> kPlaceNames{
    {{{0},
      {"fl", "lf", "frontleft", "leftfront", "vl", "vornelinks", "vornlinks", "avg", "avantgauche",
       "as", "antsx", "anterioresinistra", "anterioresinistro", "di", "delanteraizquierda",
       "delanteroizquierdo"}},
     {{1},
      {"fr", "rf", "frontright", "rightfront", "vr", "vornerechts", "vornrechts", "avd",
       "avantdroit", "ad", "antdx", "anterioredestra", "anterioredestro", "dd", "delanteraderecha",
       "delanteroderecho"}},
     {{2},
      {"rl", "lr", "rearleft", "leftrear", "hl", "hintenlinks", "arg", "arrieregauche",
       "arriregauche", "ps", "postsx", "posterioresinistra", "posterioresinistro", "ti",
       "traseraizquierda", "traseroizquierdo"}},
     {{3},
      {"rr", "rearright", "rightrear", "hr", "hintenrechts", "ard", "arrieredroit", "arriredroit",
       "pd", "postdx", "posterioredestra", "posterioredestro", "td", "traseraderecha",
       "traseroderecho"}},
     {{0, 1},
      {"front", "frt", "f", "vorne", "vorn", "va", "vorderachse", "avant", "av", "anteriore",
       "anteriori", "ant", "delantero", "delantera"}},
     {{2, 3},
      {"rear", "r", "hinten", "ha", "hinterachse", "arriere", "arrire", "ar", "posteriore",
       "posteriori", "post", "trasero", "trasera"}}}};

/// Whether the name is one of these with the place somewhere in it.
bool is_one_of(const std::string& name, const Words& measured, const std::string& place) {
  for (std::size_t at = name.find(place); at != std::string::npos; at = name.find(place, at + 1)) {
    const std::string rest = name.substr(0, at) + name.substr(at + place.size());
    if (std::any_of(measured.begin(), measured.end(),
                    [&](const char* word) { return rest == word; }))
      return true;
  }
  return false;
}

}  // namespace

std::optional<WheelWord> wheel_word(const std::string& name) {
  for (const AtWheel& measured : kMeasured)
    for (const WheelPlace& place : kPlaceNames)
      for (const char* const called : place.names) {
        // One sensor at an axle tells the pressure of both wheels; travels and temperatures differ.
        if (place.wheels.size() > 1 && measured.quantity != kPressure) continue;
        if (!is_one_of(name, measured.names, called)) continue;
        WheelWord out;
        out.quantity = measured.quantity;
        for (const std::size_t wheel : place.wheels)
          out.channels.push_back(
              fmt::format(fmt::runtime(measured.form), recording::kWheelNames[wheel]));
        return out;
      }
  return std::nullopt;
}

}  // namespace explain
