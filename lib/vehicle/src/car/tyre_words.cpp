#include "tyre_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "vehicle/error.h"

namespace vehicle {
namespace {

struct UnitName {
  std::string_view quantity, name;
  double factor;
};

constexpr double kPound = 0.45359237, kGravity = 9.80665, kInch = 0.0254;
constexpr double kPoundForce = kPound * kGravity;
constexpr UnitName kTyreUnits[] = {
    {"LENGTH", "METER", 1.0},
    {"LENGTH", "METRE", 1.0},
    {"LENGTH", "METERS", 1.0},
    {"LENGTH", "M", 1.0},
    {"LENGTH", "MM", 1e-3},
    {"LENGTH", "MILLIMETER", 1e-3},
    {"LENGTH", "CM", 1e-2},
    {"LENGTH", "CENTIMETER", 1e-2},
    {"LENGTH", "KM", 1e3},
    {"LENGTH", "KILOMETER", 1e3},
    {"LENGTH", "IN", kInch},
    {"LENGTH", "INCH", kInch},
    {"LENGTH", "FT", 12.0 * kInch},
    {"LENGTH", "FOOT", 12.0 * kInch},
    {"FORCE", "NEWTON", 1.0},
    {"FORCE", "NEWTONS", 1.0},
    {"FORCE", "N", 1.0},
    {"FORCE", "KN", 1e3},
    {"FORCE", "KNEWTON", 1e3},
    {"FORCE", "KILONEWTON", 1e3},
    {"FORCE", "POUND_FORCE", kPoundForce},
    {"FORCE", "LBF", kPoundForce},
    {"FORCE", "KG_FORCE", kGravity},
    {"FORCE", "KILOGRAM_FORCE", kGravity},
    {"FORCE", "KGF", kGravity},
    {"MASS", "KG", 1.0},
    {"MASS", "KILOGRAM", 1.0},
    {"MASS", "GRAM", 1e-3},
    {"MASS", "G", 1e-3},
    {"MASS", "POUND_MASS", kPound},
    {"MASS", "LBM", kPound},
    {"MASS", "SLUG", kPoundForce / (12.0 * kInch)},
    {"TIME", "SECOND", 1.0},
    {"TIME", "SECONDS", 1.0},
    {"TIME", "SEC", 1.0},
    {"TIME", "S", 1.0},
    {"TIME", "MILLI", 1e-3},
    {"TIME", "MILLISECOND", 1e-3},
    {"TIME", "MS", 1e-3},
    {"TIME", "MIN", 60.0},
    {"TIME", "MINUTE", 60.0},
    {"TIME", "HOUR", 3600.0},
    {"PRESSURE", "PASCAL", 1.0},
    {"PRESSURE", "PA", 1.0},
    {"PRESSURE", "KPASCAL", 1e3},
    {"PRESSURE", "KPA", 1e3},
    {"PRESSURE", "BAR", 1e5},
    {"PRESSURE", "PSI", kPoundForce / (kInch * kInch)},
    {"ANGLE", "RADIANS", 1.0},
    {"ANGLE", "RADIAN", 1.0},
    {"ANGLE", "RAD", 1.0},
};

}  // namespace

void take_tyre_unit(std::string_view quantity, std::string_view unit, const std::string& where,
                    TyreUnits& units) {
  double* const factor = quantity == "LENGTH"     ? &units.length
                         : quantity == "FORCE"    ? &units.force
                         : quantity == "MASS"     ? &units.mass
                         : quantity == "TIME"     ? &units.time
                         : quantity == "PRESSURE" ? &units.pressure
                                                  : nullptr;
  if (factor == nullptr && quantity != "ANGLE") return;
  std::string known;
  for (const UnitName& one : kTyreUnits) {
    if (one.quantity != quantity) continue;
    if (one.name == unit) {
      if (factor != nullptr) *factor = one.factor;
      return;
    }
    known += (known.empty() ? "" : ", ") + std::string(one.name);
  }
  // Hundreds of coefficients are per radian, or per radian squared.
  throw Error(fmt::format("{}: unit of {} is '{}', wanted one of {}; convert the file's values",
                          where, quantity, unit.substr(0, 40), known));
}

double tyre_unit_of(std::string_view keyword, const TyreUnits& u) {
  const std::pair<std::string_view, double> kinds[] = {
      {"UNLOADED_RADIUS", u.length},
      {"LONGVL", u.length / u.time},
      {"VXLOW", u.length / u.time},
      {"FNOMIN", u.force},
      {"FZMIN", u.force},
      {"FZMAX", u.force},
      {"VERTICAL_STIFFNESS", u.force / u.length},
      {"LONGITUDINAL_STIFFNESS", u.force / u.length},
      {"LATERAL_STIFFNESS", u.force / u.length},
      {"VERTICAL_DAMPING", u.force * u.time / u.length},
      {"INFLPRES", u.pressure},
      {"NOMPRES", u.pressure},
      {"PRESMIN", u.pressure},
      {"PRESMAX", u.pressure},
      {"MASS", u.mass},
      {"IXX", u.mass * u.length * u.length},
      {"IYY", u.mass * u.length * u.length}};
  for (const auto& [name, factor] : kinds)
    if (name == keyword) return factor;
  return 1.0;
}

std::string_view tyre_keyword(std::string_view keyword) {
  static constexpr std::pair<std::string_view, std::string_view> kSame[] = {
      {"IP", "INFLPRES"}, {"IP_NOM", "NOMPRES"}, {"LKYG", "LKYC"}, {"LKZG", "LKZC"},
      {"QPX1", "PPMX1"},  {"QPZ1", "PPZ1"},      {"QPZ2", "PPZ2"}, {"QPFZ1", "PFZ1"},
      {"QFZ1", "Q_FZ1"},  {"QFZ2", "Q_FZ2"}};
  for (const auto& [other, name] : kSame)
    if (other == keyword) return name;
  return keyword;
}

int tyre_version_of(double fit_type, const std::string& where) {
  static constexpr std::pair<int, int> kVersions[] = {{5, 52},  {6, 52},  {21, 52}, {51, 52},
                                                      {52, 52}, {60, 61}, {61, 61}, {62, 62}};
  for (const auto& [code, version] : kVersions)
    if (fit_type == code) return version;
  throw Error(
      fmt::format("{}: FITTYP = {} is no Magic Formula this program knows; wanted 5, 6, 21, 51, "
                  "52, 60, 61 or 62",
                  where, fit_type));
}

int tyre_version_of_format(std::string_view format, const std::string& where) {
  static constexpr std::string_view kMagicFormula52[] = {
      "PAC2002", "MF_05", "MF05", "MF_5", "MF52", "MF_52", "MF5.2", "MF-TYRE 5.2", "MFTYRE52"};
  if (std::find(std::begin(kMagicFormula52), std::end(kMagicFormula52), format) !=
      std::end(kMagicFormula52))
    return 52;
  static constexpr std::string_view kOthers[] = {
      "FIALA",    "UA",      "UAGL",     "UATIRE", "521",        "5.2.1",  "521_FORCE",
      "PAC89",    "PAC94",   "PAC_MC",   "PACMC",  "PAC-MC",     "MF_MC",  "MF-MCTYRE",
      "PAC_TIME", "PACTIME", "PAC-TIME", "FTIRE",  "SWIFT-TYRE", "RMOD-K", "TMEASY",
      "TM-EASY",  "TM_EASY", "BRUSH",    "LUGRE",  "CDTIRE",     "HARTY",  "SOFTSOIL"};
  if (std::find(std::begin(kOthers), std::end(kOthers), format) != std::end(kOthers))
    throw Error(fmt::format(
        "{}: the tyre model is '{}'; only the Magic Formula 5.2 (PAC2002), 6.1 and 6.2 are known; "
        "fit one of these to measured forces (crgidentify tyre)",
        where, format.substr(0, 40)));
  return 0;
}

}  // namespace vehicle
