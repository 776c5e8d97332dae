#include "vehicle/tyre_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "base/read_file.h"
#include "base/text_lines.h"
#include "tyre_checks.h"
#include "tyre_words.h"
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

std::string_view without_quotes(std::string_view value) {
  const bool quoted = value.size() >= 2 && (value.front() == '\'' || value.front() == '"') &&
                      value.back() == value.front();
  return quoted ? base::trimmed(value.substr(1, value.size() - 2)) : value;
}

/// Nothing where `value` is no number, or more than one. 1.5D+3 is how Fortran writes 1.5E+3.
std::optional<double> finite_number(std::string_view value) {
  std::string text(value);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == 'd' || c == 'D'; }, 'E');
  const auto number = base::to_number<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

/// Puts a number where it belongs, or on the list of those that nothing uses.
void keep(const std::string& keyword, double number, const Entry* entry, TyreFile& file) {
  const bool known = entry != std::end(kEntries);
  if (known) file.coefficients.*(entry->member) = number;
  if (!known || std::find(std::begin(kChecked), std::end(kChecked), keyword) != std::end(kChecked))
    file.unused.push_back(keyword);
}

using Seen = std::map<std::string, double, std::less<>>;

/// A section of rows of numbers, and where it stands.
struct Curve {
  std::size_t line = 0;
  std::vector<std::pair<double, double>> rows;
};

constexpr std::string_view kLoadCurve = "DEFLECTION_LOAD_CURVE";

/// All that a walk over the lines of a file gathers; numbers in the file's units.
struct TyreLines {
  std::string name;
  TyreFile file;
  TyrePlaces places;
  Seen seen;
  TyreUnits units;
  std::vector<Curve> load_curves;
  std::string section;
  std::size_t number = 0;
  bool in_table = false;      ///< the section holds rows of bare numbers
  bool after_remark = false;  ///< the line before ends with a remark, which may go on
  int version = 0;            ///< by FITTYP
  int version_by_format = 0;

  std::string where() const { return fmt::format("{}:{}", name, number); }
};

const Entry* find_entry(std::string_view keyword) {
  return std::find_if(std::begin(kEntries), std::end(kEntries),
                      [&](const Entry& e) { return e.keyword == keyword; });
}

void open_section(std::string_view line, TyreLines& lines) {
  const std::size_t close = line.find(']');
  if (close == std::string_view::npos)
    throw Error(
        fmt::format("{}: section '{}' has no closing ']'", lines.where(), line.substr(0, 40)));
  lines.section = upper(base::trimmed(line.substr(1, close - 1)));
  lines.in_table = lines.section == "SHAPE";
  if (lines.section == kLoadCurve) {
    lines.in_table = true;
    lines.load_curves.push_back({lines.number, {}});
  }
}

/// A line without '=': a row of a table, or the rest of a remark that was wrapped.
void take_bare_line(std::string_view line, TyreLines& lines) {
  if (line.front() == '{') {  // names of columns
    lines.in_table = true;
    return;
  }
  std::string_view rest = base::trimmed(line.substr(0, line.find_first_of("$!")));
  const std::string_view first = base::take_word(rest), second = base::take_word(rest);
  const auto x = finite_number(first), y = finite_number(second);
  if (lines.in_table && x && (y || lines.section != kLoadCurve)) {
    if (lines.section != kLoadCurve) return;
    auto& rows = lines.load_curves.back().rows;
    if (rows.size() == LoadCurve::kMostPoints)
      throw Error(fmt::format("{}: the load curve has over {} points; leave some out",
                              lines.where(), LoadCurve::kMostPoints));
    rows.emplace_back(*x, *y);
    return;
  }
  const std::string keyword(tyre_keyword(upper(first)));
  const bool lacks_equals = find_entry(keyword) != std::end(kEntries) && (second.empty() || y);
  if (!lines.after_remark || lacks_equals || (lines.in_table && x))
    throw Error(fmt::format(
        "{}: '{}' is neither a section, a comment, a row of a table nor KEY = value; if it is a "
        "remark, begin it with $",
        lines.where(), line.substr(0, 40)));
}

/// A word that means something. False: the value of `keyword` is no such word.
bool take_word(const std::string& keyword, const std::string& word, TyreLines& lines) {
  TyreCoefficients& tyre = lines.file.coefficients;
  if (lines.section == "UNITS") {
    take_tyre_unit(keyword, word, lines.where(), lines.units);
  } else if (keyword == "TYRESIDE") {
    if (word != "LEFT" && word != "RIGHT" && word != "SYMMETRIC" && word != "UNKNOWN")
      throw Error(fmt::format("{}: TYRESIDE = '{}', wanted 'LEFT', 'RIGHT' or 'SYMMETRIC'",
                              lines.where(), word.substr(0, 40)));
    tyre.left_side = word == "LEFT" || word == "UNKNOWN";
    if (word == "UNKNOWN")
      lines.file.remarks.push_back(
          lines.where() +
          ": TYRESIDE = 'UNKNOWN' is taken for 'LEFT', as other programs do; "
          "write 'RIGHT' if it was measured there");
  } else if (keyword == "FE_METHOD") {
    tyre.friction_ellipse = word == "YES";
  } else if (keyword == "PROPERTY_FILE_FORMAT") {
    lines.version_by_format = tyre_version_of_format(word, lines.where());
  } else {
    return false;
  }
  return true;
}

void take_line(std::string_view line, TyreLines& lines) {
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) return take_bare_line(line, lines);
  const std::string keyword(tyre_keyword(upper(base::trimmed(line.substr(0, equals)))));
  const std::string_view value =
      without_quotes(without_comment(base::trimmed(line.substr(equals + 1))));
  if (take_word(keyword, upper(value), lines)) return;
  const Entry* const entry = find_entry(keyword);
  const bool used = entry != std::end(kEntries) || keyword == "FITTYP";
  const std::optional<double> read = finite_number(value);
  if (!read) {
    if (!used && !keyword.empty()) return;  // a tool's own key may hold anything
    throw Error(fmt::format("{}: {} = '{}', wanted a finite number", lines.where(), keyword,
                            value.substr(0, 40)));
  }
  // A keyword counts wherever it stands, but only with one value.
  const bool checked =
      std::find(std::begin(kChecked), std::end(kChecked), keyword) != std::end(kChecked);
  if (const auto before = lines.seen.find(keyword); before != lines.seen.end()) {
    if (used && !checked && before->second != *read)
      throw Error(fmt::format("{}: {} = {} contradicts line {}, which says {}; remove one",
                              lines.where(), keyword, *read, lines.places.find(keyword)->second,
                              before->second));
    return;
  }
  lines.seen.emplace(keyword, *read);
  lines.places.emplace(keyword, lines.number);
  if (keyword == "FITTYP")
    lines.version = tyre_version_of(*read, lines.where());
  else
    keep(keyword, *read, entry, lines.file);
}

void take_lines(const std::string& text, TyreLines& lines) {
  std::string_view rest = text;
  if (rest.starts_with("\xef\xbb\xbf")) rest.remove_prefix(3);
  base::Lines walk(rest);
  for (std::string_view whole; walk.next(whole);) {
    const std::string_view line = base::trimmed(whole);
    lines.number = walk.number();
    if (line.find('\0') != std::string_view::npos)
      throw Error(lines.where() + ": a zero byte; this is not a text file");
    if (line.empty()) continue;
    const bool remark = line.front() == '$' || line.front() == '!';
    if (line.front() == '[')
      open_section(line, lines);
    else if (!remark)
      take_line(line, lines);
    // A remark that goes on over lines ends where a line of another kind stands.
    lines.after_remark =
        remark || line.find_first_of("$!") != std::string_view::npos ||
        (lines.after_remark && line.find('=') == std::string_view::npos && line.front() != '[');
  }
}

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

/// The file's load curve in SI units; throws Error where it is none, or where two differ.
void take_load_curve(const TyreLines& lines, TyreCoefficients& tyre) {
  for (const Curve& curve : lines.load_curves) {
    const std::string where = fmt::format("{}:{}", lines.name, curve.line);
    const Curve& first = lines.load_curves.front();
    if (curve.rows != first.rows)
      throw Error(fmt::format(
          "{}: this [{}] contradicts that of line {}; remove the one that is not the tyre's", where,
          kLoadCurve, first.line));
    bool grows = curve.rows.size() >= 2 && curve.rows[0] == std::pair{0.0, 0.0};
    for (std::size_t i = 1; i < curve.rows.size(); ++i)
      grows = grows && curve.rows[i].first > curve.rows[i - 1].first &&
              curve.rows[i].second > curve.rows[i - 1].second;
    if (!grows)
      throw Error(
          fmt::format("{}: [{}] has {} points; wanted two or more of deflection and load, "
                      "from 0 0 on, both growing",
                      where, kLoadCurve, curve.rows.size()));
  }
  if (lines.load_curves.empty()) return;
  LoadCurve& out = tyre.load_curve;
  for (const auto& [deflection, load] : lines.load_curves.front().rows) {
    out.deflection_m[out.points] = deflection * lines.units.length;
    out.load_n[out.points++] = load * lines.units.force;
  }
}

/// VERTICAL_STIFFNESS where the file states another measure of it: its definition is the slope of
/// the load over the deflection at the nominal load.
void derive_stiffness(TyreCoefficients& tyre) {
  if (tyre.vertical_stiffness_npm != 0.0) return;
  if (tyre.load_curve.points > 0) {
    const LoadCurve& c = tyre.load_curve;
    std::size_t i = 1;
    while (i + 1 < c.points && c.load_n[i] < tyre.nominal_load_n) ++i;
    tyre.vertical_stiffness_npm =
        (c.load_n[i] - c.load_n[i - 1]) / (c.deflection_m[i] - c.deflection_m[i - 1]);
  } else if (tyre.qfz1 > 0.0) {
    tyre.vertical_stiffness_npm = tyre.nominal_load_n / tyre.unloaded_radius_m *
                                  std::sqrt(tyre.qfz1 * tyre.qfz1 + 4.0 * tyre.qfz2);
  }
}

}  // namespace

TyreFile parse_tyre(const std::string& text, const std::string& name) {
  TyreLines lines;
  lines.name = name;
  take_lines(text, lines);
  TyreFile& file = lines.file;
  TyreCoefficients& tyre = file.coefficients;
  if (lines.version == 0 && lines.version_by_format == 0)
    throw Error(name +
                ": no FITTYP in [MODEL], and no PROPERTY_FILE_FORMAT of the Magic Formula 5.2 "
                "(PAC2002, MF_05); this is not a Magic Formula tyre, or it is cut off");
  tyre.version = lines.version != 0 ? lines.version : lines.version_by_format;
  list_defaults(lines.seen, name, file);
  for (const Entry& entry : kEntries)
    if (lines.seen.contains(entry.keyword))
      tyre.*(entry.member) *= tyre_unit_of(entry.keyword, lines.units);
  take_load_curve(lines, tyre);
  derive_stiffness(tyre);
  tyre.states_rolling_radius =
      lines.seen.contains("BREFF") || lines.seen.contains("DREFF") || lines.seen.contains("FREFF");
  if (tyre.nominal_pressure_pa > 0 && tyre.pressure_pa == 0)
    tyre.pressure_pa = tyre.nominal_pressure_pa;
  check_tyre(tyre, lines.places, name);
  return std::move(file);
}

std::string with_tyre_values(const std::string& text, const std::map<std::string, double>& values) {
  std::string out, section;
  std::set<std::string> written;
  TyreUnits units;
  {
    TyreLines lines;
    take_lines(text, lines);
    units = lines.units;
  }
  const auto line_of = [&](const std::string& keyword, double value) {
    return fmt::format("{} = {:.9g}", keyword, value / tyre_unit_of(keyword, units));
  };
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
        entry ? values.find(std::string(tyre_keyword(upper(base::trimmed(line.substr(0, equals))))))
              : values.end();
    if (value != values.end()) {
      out += line_of(value->first, value->second);
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
    if (!written.contains(keyword)) out += line_of(keyword, value) + '\n';
  return out;
}

TyreFile read_tyre(const std::string& path) {
  return parse_tyre(base::read_file(path, kLargestTyreBytes), path);
}

}  // namespace vehicle
