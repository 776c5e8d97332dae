#include "vehicle/tyre_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "base/read_file.h"
#include "base/text_lines.h"
#include "vehicle/error.h"

namespace vehicle {
namespace {

struct Entry {
  std::string_view keyword;
  double TyreCoefficients::*member;
  double fallback;
};

constexpr Entry kEntries[] = {
#define VEHICLE_TYRE_COEFFICIENT(member, keyword, fallback) \
  {#keyword, &TyreCoefficients::member, fallback},
#include "vehicle/tyre_coefficients.def"
#undef VEHICLE_TYRE_COEFFICIENT
};

/// Coefficients that are read, and checked where they can be wrong, but used by nothing: masses and
/// inertias are the vehicle's, the patch follows from the deflection, and only FZMAX limits.
constexpr std::string_view kChecked[] = {
    "MASS",   "IXX",    "IYY",    "Q_RA1",  "Q_RA2",  "Q_RB1",  "Q_RB2",   "FZMIN",
    "KPUMIN", "KPUMAX", "ALPMIN", "ALPMAX", "CAMMIN", "CAMMAX", "PRESMIN", "PRESMAX"};

std::string upper(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return out;
}

/// The text between quotes, or the bare word, without a trailing comment.
std::string_view without_comment(std::string_view value) {
  if (!value.empty() && (value.front() == '\'' || value.front() == '"')) {
    const std::size_t end = value.find(value.front(), 1);
    if (end != std::string_view::npos) return value.substr(0, end + 1);
  }
  return base::trimmed(value.substr(0, value.find_first_of("$!")));
}

bool is_quoted(std::string_view value) {
  return value.size() >= 2 && (value.front() == '\'' || value.front() == '"') &&
         value.back() == value.front();
}

/// Lengths in other units than metres would change what hundreds of coefficients mean; refuse.
void check_unit(std::string_view quantity, std::string_view unit, const std::string& where) {
  static constexpr struct {
    std::string_view quantity, first, second;
  } kUnits[] = {{"LENGTH", "METER", "M"},       {"FORCE", "NEWTON", "N"},
                {"ANGLE", "RADIANS", "RADIAN"}, {"MASS", "KG", "KILOGRAM"},
                {"TIME", "SECOND", "S"},        {"PRESSURE", "PASCAL", "PA"}};
  for (const auto& known : kUnits) {
    if (quantity != known.quantity) continue;
    if (unit == known.first || unit == known.second) return;
    throw Error(fmt::format("{}: unit of {} is '{}', wanted '{}'; convert the file to SI units",
                            where, quantity, unit.substr(0, 40), known.first));
  }
}

int version_of(double fit_type, const std::string& where) {
  static constexpr std::pair<int, int> kVersions[] = {{5, 52},  {6, 52},  {21, 52}, {51, 52},
                                                      {52, 52}, {60, 61}, {61, 61}, {62, 62}};
  for (const auto& [code, version] : kVersions)
    if (fit_type == code) return version;
  throw Error(
      fmt::format("{}: FITTYP = {} is no Magic Formula this program knows; wanted 5, 6, 21, 51, "
                  "52, 60, 61 or 62",
                  where, fit_type));
}

/// "file:line" of the value that settled a keyword, for errors found after the whole file is read.
using Places = std::map<std::string, std::size_t, std::less<>>;

void check_values(const TyreCoefficients& tyre, const Places& places, const std::string& name) {
  const auto where = [&](std::string_view keyword) {
    const auto found = places.find(keyword);
    return found == places.end() ? name : fmt::format("{}:{}", name, found->second);
  };
  const auto positive = [&](double value, std::string_view keyword) {
    if (!(value > 0.0))
      throw Error(
          fmt::format("{}: {} = {}, wanted a number above 0", where(keyword), keyword, value));
  };
  positive(tyre.unloaded_radius_m, "UNLOADED_RADIUS");
  positive(tyre.nominal_load_n, "FNOMIN");
  positive(tyre.vertical_stiffness_npm, "VERTICAL_STIFFNESS");
  positive(tyre.nominal_speed_mps, "LONGVL");
  positive(tyre.low_speed_mps, "VXLOW");
  positive(tyre.pcx1, "PCX1");
  positive(tyre.pdx1, "PDX1");
  positive(tyre.pkx1, "PKX1");
  positive(tyre.pcy1, "PCY1");
  positive(std::abs(tyre.pdy1), "PDY1");
  positive(std::abs(tyre.pky1), "PKY1");
  positive(std::abs(tyre.pky2), "PKY2");
  positive(tyre.lfzo, "LFZO");
  positive(tyre.fz_max_n, "FZMAX");
  const auto not_negative = [&](double value, std::string_view keyword) {
    if (!(value >= 0.0))
      throw Error(fmt::format("{}: {} = {}, wanted 0 or more", where(keyword), keyword, value));
  };
  not_negative(tyre.mass_kg, "MASS");
  not_negative(tyre.vertical_damping_nspm, "VERTICAL_DAMPING");
  not_negative(tyre.longitudinal_stiffness_npm, "LONGITUDINAL_STIFFNESS");
  not_negative(tyre.lateral_stiffness_npm, "LATERAL_STIFFNESS");
  not_negative(tyre.lmux, "LMUX");
  not_negative(tyre.lmuy, "LMUY");
  const bool uses_pressure = tyre.ppx1 != 0 || tyre.ppx2 != 0 || tyre.ppx3 != 0 || tyre.ppx4 != 0 ||
                             tyre.ppy1 != 0 || tyre.ppy2 != 0 || tyre.ppy3 != 0 || tyre.ppy4 != 0 ||
                             tyre.ppy5 != 0 || tyre.ppz1 != 0 || tyre.ppz2 != 0 || tyre.pfz1 != 0;
  if (uses_pressure) positive(tyre.nominal_pressure_pa, "NOMPRES");
  const auto ordered = [&](double low, double high, std::string_view keyword) {
    if (!(low < high))
      throw Error(fmt::format("{}: {} = {} is not above the lower end of its range, {}",
                              where(keyword), keyword, high, low));
  };
  ordered(tyre.fz_min_n, tyre.fz_max_n, "FZMAX");
  ordered(tyre.kappa_min, tyre.kappa_max, "KPUMAX");
  ordered(tyre.alpha_min_rad, tyre.alpha_max_rad, "ALPMAX");
  ordered(tyre.gamma_min_rad, tyre.gamma_max_rad, "CAMMAX");
  ordered(tyre.pressure_min_pa, tyre.pressure_max_pa, "PRESMAX");
}

/// A word in quotes, or one of the units.
void take_word(const std::string& keyword, std::string_view value, const std::string& section,
               const std::string& where, TyreCoefficients& tyre) {
  const std::string word =
      upper(is_quoted(value) ? base::trimmed(value.substr(1, value.size() - 2)) : value);
  if (section == "UNITS") check_unit(keyword, word, where);
  if (keyword == "TYRESIDE") {
    if (word != "LEFT" && word != "RIGHT" && word != "SYMMETRIC")
      throw Error(
          fmt::format("{}: TYRESIDE = '{}', wanted 'LEFT' or 'RIGHT'", where, word.substr(0, 40)));
    tyre.left_side = word == "LEFT";
  }
}

/// Nothing where `value` is no number, or more than one.
std::optional<double> finite_number(std::string_view value) {
  double number = 0.0;
  if (value.front() == '+') value.remove_prefix(1);
  const auto [stop, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || stop != value.data() + value.size() || !std::isfinite(number))
    return std::nullopt;
  return number;
}

/// Puts a number where it belongs, or on the list of those that nothing uses.
void keep(const std::string& keyword, double number, const Entry* entry, TyreFile& file) {
  const bool known = entry != std::end(kEntries);
  if (known) file.coefficients.*(entry->member) = number;
  if (!known || std::find(std::begin(kChecked), std::end(kChecked), keyword) != std::end(kChecked))
    file.unused.push_back(keyword);
}

using Seen = std::map<std::string, double, std::less<>>;

/// What the file leaves out and may; throws Error where it may not.
void list_defaults(const Seen& seen, const std::string& name, TyreFile& file) {
  for (const Entry& entry : kEntries) {
    if (seen.contains(entry.keyword)) continue;
    if (std::isnan(entry.fallback))
      throw Error(
          fmt::format("{}: {} is missing; the file is incomplete or cut off", name, entry.keyword));
    file.defaulted.emplace_back(entry.keyword);
  }
}

}  // namespace

TyreFile parse_tyre(const std::string& text, const std::string& name) {
  TyreFile file;
  Places places;
  Seen seen;
  std::string section;
  bool has_fit_type = false;

  std::size_t line_number = 0;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = rest.find('\n');
    const std::string_view line = base::trimmed(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    ++line_number;
    const std::string where = fmt::format("{}:{}", name, line_number);
    if (line.find('\0') != std::string_view::npos)
      throw Error(where + ": a zero byte; this is not a text file");
    if (line.empty() || line.front() == '$' || line.front() == '!') continue;
    if (line.front() == '[') {
      const std::size_t close = line.find(']');
      if (close == std::string_view::npos)
        throw Error(fmt::format("{}: section '{}' has no closing ']'", where, line.substr(0, 40)));
      section = upper(base::trimmed(line.substr(1, close - 1)));
      continue;
    }
    const std::size_t equals = line.find('=');
    // [SHAPE] and similar tables hold rows of bare numbers; the formula has no use for them.
    if (equals == std::string_view::npos) {
      if (section == "SHAPE") continue;
      throw Error(fmt::format("{}: '{}' is neither a section, a comment nor KEY = value", where,
                              line.substr(0, 40)));
    }
    const std::string keyword = upper(base::trimmed(line.substr(0, equals)));
    const std::string_view value = without_comment(base::trimmed(line.substr(equals + 1)));
    if (keyword.empty() || value.empty())
      throw Error(fmt::format("{}: '{}' lacks a keyword or a value", where, line.substr(0, 40)));
    if (is_quoted(value) || section == "UNITS") {
      take_word(keyword, value, section, where, file.coefficients);
      continue;
    }

    const auto* const entry = std::find_if(std::begin(kEntries), std::end(kEntries),
                                           [&](const Entry& e) { return e.keyword == keyword; });
    const bool used = entry != std::end(kEntries) || keyword == "FITTYP";
    const std::optional<double> read = finite_number(value);
    if (!read) {
      if (!used) continue;  // a tool's own key may hold anything
      throw Error(fmt::format("{}: {} = '{}', wanted a finite number", where, keyword,
                              value.substr(0, 40)));
    }
    const double number = *read;
    // MASS, for one, also is a unit; a keyword counts wherever it stands, but only with one value.
    if (const auto before = seen.find(keyword); before != seen.end()) {
      if (used && before->second != number)
        throw Error(fmt::format("{}: {} = {} contradicts line {}, which says {}; remove one", where,
                                keyword, number, places.find(keyword)->second, before->second));
      continue;
    }
    seen.emplace(keyword, number);
    places.emplace(keyword, line_number);
    if (keyword == "FITTYP") {
      file.coefficients.version = version_of(number, where);
      has_fit_type = true;
    } else {
      keep(keyword, number, entry, file);
    }
  }

  if (!has_fit_type)
    throw Error(name +
                ": no FITTYP in [MODEL]; this is not a Magic Formula tyre, or it is cut off");
  list_defaults(seen, name, file);
  TyreCoefficients& tyre = file.coefficients;
  tyre.states_rolling_radius =
      seen.contains("BREFF") || seen.contains("DREFF") || seen.contains("FREFF");
  if (tyre.nominal_pressure_pa > 0 && tyre.pressure_pa == 0)
    tyre.pressure_pa = tyre.nominal_pressure_pa;
  check_values(tyre, places, name);
  return file;
}

std::string with_tyre_values(const std::string& text, const std::map<std::string, double>& values) {
  std::string out, section;
  std::set<std::string> written;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = rest.find('\n');
    const std::string_view whole = rest.substr(0, end), line = base::trimmed(whole);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (line.starts_with('[')) section = upper(base::trimmed(line.substr(1, line.find(']') - 1)));
    const std::size_t equals = line.find('=');
    const bool entry = !line.empty() && line.front() != '$' && line.front() != '!' &&
                       line.front() != '[' && equals != std::string_view::npos &&
                       section != "UNITS";
    const auto value =
        entry ? values.find(upper(base::trimmed(line.substr(0, equals)))) : values.end();
    if (value != values.end()) {
      out += fmt::format("{} = {:.9g}", value->first, value->second);
      if (whole.ends_with('\r')) out += '\r';
      written.insert(value->first);
    } else {
      out += whole;
    }
    if (end != std::string_view::npos) out += '\n';
  }
  if (written.size() == values.size()) return out;
  if (!out.empty() && out.back() != '\n') out += '\n';
  out += "[CORRECTED]\n";
  for (const auto& [keyword, value] : values)
    if (!written.contains(keyword)) out += fmt::format("{} = {:.9g}\n", keyword, value);
  return out;
}

TyreFile read_tyre(const std::string& path) {
  return parse_tyre(base::read_file(path, kLargestTyreBytes), path);
}

}  // namespace vehicle
