#include "vehicle/data_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>

#include "base/settings.h"
#include "tyre_size.h"
#include "vehicle/error.h"
#include "vehicle/parameters.h"

namespace vehicle {
namespace {

/// A number of the sheet: what is plausible, and what it is.
struct SheetNumber {
  const char* key;
  double low, high;
  const char* what;
};

constexpr SheetNumber kSheetNumbers[] = {
    {"mass_kg", 60, 6000, "kg, ready to drive, with driver, without fuel"},
    {"wheelbase_m", 0.7, 5, "m, front to rear axle"},
    {"front_weight", 0.25, 0.75, "share of the weight on the front axle, 0.53 for 53 %"},
    {"track_m", 0.6, 2.5, "m, between the middles of the tyres"},
    {"cog_height_m", 0.1, 1.2, "m, centre of mass above the ground"},
    {"power_kw", 1, 1500, "kW, greatest power of the engine"},
    {"power_rpm", 1000, 25000, "rpm of the greatest power"},
    {"torque_nm", 5, 3000, "N m, greatest torque of the engine"},
    {"torque_rpm", 300, 25000, "rpm of the greatest torque"},
    {"limit_rpm", 1000, 25000, "rpm, the limiter"},
    {"gears", 0.2, 20, "ratio of a gear"},
    {"final_drive", 0.5, 20, "ratio of the final drive, primary drive included"},
    {"grip", 0.4, 2.5, "peak friction of the tyres at the load of the standing car"},
    {"drag_area_m2", 0.1, 5, "m2, drag coefficient times frontal area"},
    {"downforce_area_m2", -1, 8, "m2 at this axle, lift coefficient times area, downwards"},
    {"brake_disc_m", 0.08, 0.5, "m, diameter of the discs"},
    {"ride_hz", 0.7, 12, "Hz, the body on its springs"},
    {"top_speed_kmh", 40, 500, "km/h, as published"},
    {"to_100_kmh_s", 1, 60, "s from standstill to 100 km/h, as published"},
};

const SheetNumber& sheet_number(std::string_view key) {
  return *std::find_if(std::begin(kSheetNumbers), std::end(kSheetNumbers),
                       [&](const SheetNumber& n) { return n.key == key; });
}

/// The sheet's keys with what complaints need.
class Sheet {
 public:
  Sheet(const base::Setting& root, const std::string& path) : top_(root, path, "a data sheet") {
    top_.allow({"name",         "kind",         "mass_kg",
                "wheelbase_m",  "front_weight", "track_m",
                "tyres",        "power_kw",     "power_rpm",
                "torque_nm",    "torque_rpm",   "torque_points",
                "limit_rpm",    "turbo",        "gears",
                "final_drive",  "differential", "cog_height_m",
                "grip",         "drag_area_m2", "downforce_area_m2",
                "brake_disc_m", "ride_hz",      "top_speed_kmh",
                "to_100_kmh_s"});
  }

  const base::Section& top() const { return top_; }
  std::string where(std::string_view key) const { return top_.where(*top_.find(key)); }

  /// The number that a word is, or what is wrong with it.
  double plausible(const char* key, const std::string& word, const std::string& at) const {
    const SheetNumber& n = sheet_number(key);
    const double value = base::to_number(word, at, key);
    if (!(value >= n.low && value <= n.high))
      throw Error(fmt::format("{}: {} = {}, plausible is {:g} to {:g}: {}", at, key, value, n.low,
                              n.high, n.what));
    return value;
  }

  std::optional<double> number(const char* key) const {
    if (!top_.has(key)) return std::nullopt;
    return plausible(key, top_.text(key), where(key));
  }

  double needed(const char* key) const {
    if (!top_.has(key))
      throw Error(fmt::format("{}: '{}' is missing: {}, plausible is {:g} to {:g}", top_.path(),
                              key, sheet_number(key).what, sheet_number(key).low,
                              sheet_number(key).high));
    return *number(key);
  }

  /// Front and rear: two numbers, or one for both.
  std::optional<std::array<double, 2>> both(const char* key) const {
    const base::Setting* const at = top_.find(key);
    if (at == nullptr) return std::nullopt;
    if (at->kind == base::Setting::Kind::kWord) return std::array{*number(key), *number(key)};
    const std::vector<std::string> words = top_.words(key);
    if (words.size() != 2)
      throw Error(
          fmt::format("{}: '{}' has {} numbers, wanted two, front and rear, or one for both",
                      where(key), key, words.size()));
    return std::array{plausible(key, words[0], where(key)), plausible(key, words[1], where(key))};
  }

  std::array<double, 2> needed_both(const char* key) const {
    return top_.has(key) ? *both(key) : std::array{needed(key), 0.0};  // which throws
  }

  template <class Value>
  Value word(const char* key, std::initializer_list<std::pair<const char*, Value>> words) const {
    const std::string seen = top_.text(key);
    std::string known;
    for (const auto& [name, value] : words) {
      if (seen == name) return value;
      known += (known.empty() ? "" : ", ") + std::string(name);
    }
    throw Error(fmt::format("{}: {} = '{}', wanted one of: {}", where(key), key, seen.substr(0, 40),
                            known));
  }

 private:
  base::Section top_;
};

double watts_to_nm(double watts, double rpm) { return watts / (rpm * std::numbers::pi / 30.0); }

/// Torque rises to its peak, stays between the speeds of the peak, and falls to that of the
/// greatest power as a parabola.
void read_sheet_curve(const Sheet& sheet, DataSheet& out) {
  const double power_w = 1000.0 * sheet.needed("power_kw");
  out.power_rpm = sheet.needed("power_rpm");
  const double at_power_nm = watts_to_nm(power_w, out.power_rpm);
  // Without a peak stated: 10 % above, at 70 % of the speed, as usual of engines that breathe.
  out.curve_guessed = !sheet.top().has("torque_nm") || !sheet.top().has("torque_rpm");
  const double peak_nm = sheet.number("torque_nm").value_or(1.1 * at_power_nm);
  const std::array<double, 2> peak_rpm =
      sheet.both("torque_rpm").value_or(std::array{0.7 * out.power_rpm, 0.7 * out.power_rpm});
  const auto refuse = [&](const char* key, const std::string& why) {
    throw Error(fmt::format("{}: {}; check power_kw, power_rpm, torque_nm and torque_rpm",
                            sheet.where(sheet.top().has(key) ? key : "power_kw"), why));
  };
  if (at_power_nm > 1.03 * peak_nm)
    refuse("torque_nm", fmt::format("{:g} kW at {:g} rpm are {:.0f} N m, but torque_nm = {:g}",
                                    power_w / 1000.0, out.power_rpm, at_power_nm, peak_nm));
  if (!(peak_rpm[0] <= peak_rpm[1] && peak_rpm[1] <= out.power_rpm))
    refuse("torque_rpm", fmt::format("torque_rpm = {:g} to {:g}, wanted ascending and at most "
                                     "power_rpm = {:g}",
                                     peak_rpm[0], peak_rpm[1], out.power_rpm));
  if (peak_nm * peak_rpm[1] > 1.03 * at_power_nm * out.power_rpm)
    refuse("torque_rpm",
           fmt::format("{:.0f} N m at {:g} rpm are {:.0f} kW, but power_kw = {:g}", peak_nm,
                       peak_rpm[1], peak_nm * peak_rpm[1] * std::numbers::pi / 30000.0,
                       power_w / 1000.0));
  const double limit_rpm = out.limit_rpm.value_or(1.07 * out.power_rpm);
  const auto torque_nm = [&](double rpm) {
    if (rpm > out.power_rpm) {  // the power falls, as it rose
      const double beyond = rpm / out.power_rpm - 1.0;
      return std::max(0.0, watts_to_nm(power_w * (1.0 - 4.0 * beyond * beyond), rpm));
    }
    if (rpm < peak_rpm[0]) {
      const double share = 1.0 - rpm / peak_rpm[0];
      return peak_nm * (1.0 - 0.45 * share * share);
    }
    if (rpm <= peak_rpm[1] || out.power_rpm - peak_rpm[1] < 1.0) return peak_nm;
    const double share = (rpm - peak_rpm[1]) / (out.power_rpm - peak_rpm[1]);
    return peak_nm - (peak_nm - at_power_nm) * share * share;
  };
  constexpr int kPoints = 16;
  for (int i = 0; i <= kPoints; ++i) {
    const double rpm = 1.05 * limit_rpm * i / kPoints;
    out.torque.emplace_back(rpm, torque_nm(rpm));
  }
}

void read_sheet_points(const Sheet& sheet, DataSheet& out) {
  for (const char* key : {"power_kw", "power_rpm", "torque_nm", "torque_rpm"})
    if (sheet.top().has(key))
      throw Error(fmt::format("{}: {} stands beside torque_points, which tell it; leave one out",
                              sheet.where(key), key));
  double most = 0.0;
  sheet.top()
      .section("torque_points")
      .for_each([&](const std::string& key, const base::Setting& value, const std::string& where) {
        const double rpm = base::to_number(key, where, "rpm of torque_points");
        if (value.kind != base::Setting::Kind::kWord)
          throw Error(where + ": torque_points are rpm: N m, one number each");
        const double nm = base::to_number(value.word, where, "torque at " + key + " rpm");
        if (!(rpm >= 0.0 && rpm <= 25000.0 && nm >= 0.0 && nm <= 3000.0))
          throw Error(fmt::format(
              "{}: torque_points has {:g}: {:g}, plausible are 0 to 25000 rpm and 0 to 3000 N m",
              where, rpm, nm));
        if (!out.torque.empty() && !(rpm > out.torque.back().first))
          throw Error(fmt::format("{}: torque_points has {:g} behind {:g} rpm, wanted ascending",
                                  where, rpm, out.torque.back().first));
        out.torque.emplace_back(rpm, nm);
        if (rpm * nm > most) out.power_rpm = rpm;
        most = std::max(most, rpm * nm);
      });
  if (out.torque.size() < 2 || !(most > 0.0))
    throw Error(sheet.where("torque_points") + ": torque_points has fewer than two, or no torque");
}

void read_sheet_gears(const Sheet& sheet, DataSheet& out) {
  out.final_drive = sheet.number("final_drive");
  const base::Setting* const gears = sheet.top().find("gears");
  if (gears == nullptr) return;
  const std::string at = sheet.where("gears");
  if (gears->kind == base::Setting::Kind::kWord) {
    const double count = base::to_number(gears->word, at, "gears");
    if (!(count >= 1.0 && count <= kMostGears && count == std::round(count)))
      throw Error(
          fmt::format("{}: gears = {:g}, wanted 1 to {}, or their ratios", at, count, kMostGears));
    out.gear_count = count;
    return;
  }
  for (const std::string& word : sheet.top().words("gears"))
    out.gear_ratios.push_back(sheet.plausible("gears", word, at));
  if (out.gear_ratios.empty() || out.gear_ratios.size() > kMostGears)
    throw Error(
        fmt::format("{}: gears has {} ratios, wanted 1 to {}; of more gears, leave out some "
                    "between the first and the last",
                    at, out.gear_ratios.size(), kMostGears));
  for (std::size_t i = 1; i < out.gear_ratios.size(); ++i)
    if (!(out.gear_ratios[i] < out.gear_ratios[i - 1]))
      throw Error(
          fmt::format("{}: gears has {:g} behind {:g}, wanted ratios that fall from the "
                      "first gear on",
                      at, out.gear_ratios[i], out.gear_ratios[i - 1]));
  if (!out.final_drive)
    throw Error(fmt::format("{}: gears has ratios, but final_drive is missing: {}", at,
                            sheet_number("final_drive").what));
}

void read_sheet_tyres(const Sheet& sheet, DataSheet& out) {
  if (!sheet.top().has("tyres"))
    throw Error(sheet.top().path() +
                ": 'tyres' is missing: their sizes, as [215/40R18, 215/40R18]");
  const base::Setting& tyres = *sheet.top().find("tyres");
  std::vector<std::string> names;
  if (tyres.kind == base::Setting::Kind::kWord)
    names = {tyres.word, tyres.word};
  else
    names = sheet.top().words("tyres");
  if (names.size() != 2)
    throw Error(fmt::format("{}: tyres has {} sizes, wanted two, front and rear, or one for both",
                            sheet.where("tyres"), names.size()));
  for (std::size_t a = 0; a < 2; ++a) {
    base::Answer<TyreSize> size = tyre_size(names[a]);
    if (!size) throw Error(sheet.where("tyres") + ": " + size.refusal().message);
    out.tyre[a] = *size;
    out.tyre_name[a] = names[a];
  }
}

/// Numbers that are plausible each, but not together.
void check_together(const Sheet& sheet, const DataSheet& out) {
  const double limit = out.limit_rpm.value_or(1e9);
  if (!(limit >= out.power_rpm))
    throw Error(fmt::format("{}: limit_rpm = {:g} lies below the speed of the greatest power, {:g}",
                            sheet.where("limit_rpm"), limit, out.power_rpm));
  for (std::size_t a = 0; a < 2; ++a) {
    if (!(out.track_m[a] > out.tyre[a].width_m + 0.2))
      throw Error(fmt::format("{}: track_m = {:g} m, but the tyre alone is {:.3f} m wide",
                              sheet.where("track_m"), out.track_m[a], out.tyre[a].width_m));
    if (out.brake_disc_m && !((*out.brake_disc_m)[a] < out.tyre[a].rim_m))
      throw Error(fmt::format("{}: brake_disc_m = {:g} m, but the rim of {} has {:.3f} m",
                              sheet.where("brake_disc_m"), (*out.brake_disc_m)[a], out.tyre_name[a],
                              out.tyre[a].rim_m));
  }
  if (!(out.wheelbase_m > out.tyre[0].radius_m + out.tyre[1].radius_m))
    throw Error(fmt::format("{}: wheelbase_m = {:g} m, but the tyres would touch at {:.3f} m",
                            sheet.where("wheelbase_m"), out.wheelbase_m,
                            out.tyre[0].radius_m + out.tyre[1].radius_m));
}

}  // namespace

DataSheet read_data_sheet(const std::string& path) {
  const base::Setting root = base::read_settings(path);
  const Sheet sheet(root, path);
  const base::Section& top = sheet.top();
  DataSheet out;
  out.path = path;
  out.name = top.text("name");
  out.kind = sheet.word<CarKind>("kind", {{"road", CarKind::kRoad},
                                          {"race", CarKind::kRace},
                                          {"formula", CarKind::kFormula},
                                          {"kart", CarKind::kKart}});
  out.mass_kg = sheet.needed("mass_kg");
  out.wheelbase_m = sheet.needed("wheelbase_m");
  out.front_weight = sheet.needed("front_weight");
  out.track_m = sheet.needed_both("track_m");
  read_sheet_tyres(sheet, out);
  out.limit_rpm = sheet.number("limit_rpm");
  top.has("torque_points") ? read_sheet_points(sheet, out) : read_sheet_curve(sheet, out);
  out.turbo = top.flag("turbo", false);
  read_sheet_gears(sheet, out);
  if (top.has("differential"))
    out.differential =
        sheet.word<Differential>("differential", {{"open", Differential::kOpen},
                                                  {"limited_slip", Differential::kLimitedSlip},
                                                  {"locked", Differential::kLocked}});
  out.cog_height_m = sheet.number("cog_height_m");
  out.grip = sheet.number("grip");
  out.drag_area_m2 = sheet.number("drag_area_m2");
  out.downforce_area_m2 = sheet.both("downforce_area_m2");
  out.brake_disc_m = sheet.both("brake_disc_m");
  out.ride_hz = sheet.both("ride_hz");
  out.top_speed_kmh = sheet.number("top_speed_kmh");
  out.to_100_kmh_s = sheet.number("to_100_kmh_s");
  check_together(sheet, out);
  return out;
}

std::string example_data_sheet() {
  return R"(# A car's data sheet: change the numbers, then 'crgdrive new my_car.yaml -o my_car'.
# What is behind a # may stay away: it is guessed then, by the kind of car.
name: my_car
kind: road                     # road, race (closed, on slicks), formula (also prototypes) or kart
mass_kg: 1350                  # ready to drive, with driver, without fuel
wheelbase_m: 2.575
front_weight: 0.53             # share of the weight on the front axle
track_m: [1.52, 1.55]          # front, rear; one number for both
tyres: [215/40R18, 215/40R18]  # or 325/705R18 (mm, mm, inch) or 18x7.5-10 (inches)
power_kw: 173                  # the greatest, and the speed where it is
power_rpm: 7000
# torque_nm: 250               # the greatest, and where: one speed, or from and to
# torque_rpm: 3700
# torque_points: {1000: 150, 3700: 250, 7000: 236}   # rpm: N m, in place of these four
# limit_rpm: 7500
# turbo: true                  # half of the torque comes late
# gears: [3.626, 2.188, 1.541, 1.213, 1.0, 0.767]    # ratios, or how many: 1 to 10
# final_drive: 4.1
# differential: limited_slip   # open, limited_slip or locked; driven are the rear wheels
# cog_height_m: 0.46           # centre of mass above the ground
# grip: 1.0                    # peak friction of the tyres: road 0.9 to 1.1, slicks 1.4 to 1.8
# drag_area_m2: 0.6            # drag coefficient times frontal area
# downforce_area_m2: [0, 0]    # lift coefficient times area, downwards, front and rear
# brake_disc_m: [0.30, 0.29]   # diameters
# ride_hz: [1.6, 1.8]          # the body on its springs, front and rear
# top_speed_kmh: 226           # as published: what the car does is compared with them
# to_100_kmh_s: 6.3
)";
}

}  // namespace vehicle
