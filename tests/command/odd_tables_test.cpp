// Tables as people and their programs write them, through every command that reads one: each has
// one meaning, then the outcome is that of the same table written plainly, or none, then it is
// refused with its place.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <regex>
#include <sstream>

#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace odd_tables_test {

using cli::Folder;
using support::run_tool, support::ToolRun;
using Words = std::vector<std::string>;

struct Sheet {
  Words names;
  std::vector<Words> rows;
};

/// How a sheet is written.
struct Style {
  char separator = ',', mark = '.';
  bool quoted_names = false, quoted_cells = false;
  std::string end = "\n", behind_names{}, behind_cells{}, before_names{};
};

std::string text(const Sheet& sheet, const Style& style = {}) {
  const auto line = [&](const Words& cells, bool quoted) {
    std::string out;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      out += c > 0 ? std::string(1, style.separator) : "";
      out += quoted ? '"' + cells[c] + '"' : cells[c];
    }
    return out;
  };
  std::string out =
      style.before_names + line(sheet.names, style.quoted_names) + style.behind_names + style.end;
  for (Words row : sheet.rows) {
    for (std::string& cell : row) std::replace(cell.begin(), cell.end(), '.', style.mark);
    out += line(row, style.quoted_cells) + style.behind_cells + style.end;
  }
  return out;
}

enum class Kind { table, log, cloud };

/// A command that reads a table. Of its words, T is the table and O a folder for what it writes.
struct Reader {
  std::string name, tool;
  Words call;
  Sheet plain;
  Kind kind = Kind::table;
  std::size_t hurt = 1;       ///< the column whose cells are written in odd ways
  bool gaps = false;          ///< an empty cell of it means that there is no value
  bool others = true;         ///< columns that it does not know are passed over
  bool by_name = true;        ///< columns may come in another order
  bool none_is_some = false;  ///< a header alone says that there are none
  bool may_lack = false;      ///< without the column it is another table
  std::optional<std::size_t> clock = std::nullopt;  ///< which may hold moments; it begins with 0
};

enum class Meaning {
  one,  ///< that of the plain table
  gap,  ///< that of the plain table without the cell, where this means something
  cut,  ///< that of the plain table without its last row
  none
};
enum class Place { file, line, cell };

struct Variant {
  std::string name, bytes;
  Meaning meaning = Meaning::one;
  Place place = Place::file;  ///< that is said where it is refused
  std::size_t line = 0;
};

/// A sheet with another text in the middle of the column that is hurt.
Sheet with_cell(const Reader& reader, const std::string& cell) {
  Sheet sheet = reader.plain;
  sheet.rows[sheet.rows.size() / 2][reader.hurt] = cell;
  return sheet;
}
std::size_t line_hurt(const Reader& reader) { return 2 + reader.plain.rows.size() / 2; }

std::string replaced(std::string text, const std::string& from, const std::string& to,
                     std::size_t most = std::string::npos) {
  for (std::size_t at = text.find(from); at != std::string::npos && most > 0;
       at = text.find(from, at + to.size()), --most)
    text.replace(at, from.size(), to);
  return text;
}

std::string utf16(const std::string& text, bool mark) {
  std::string out = mark ? "\xFF\xFE" : "";
  for (const char c : text) (out += c) += '\0';
  return out;
}

/// Every number of the column by `write`.
template <class Write>
Sheet rewritten(Sheet sheet, std::size_t column, const Write& write) {
  for (Words& row : sheet.rows) row[column] = write(row[column]);
  return sheet;
}

/// Ways to write what has one meaning.
std::vector<Variant> plain_ways(const Reader& reader) {
  const Sheet& sheet = reader.plain;
  const std::string plain = text(sheet);
  const std::size_t half = plain.find('\n', plain.size() / 2) + 1;
  const auto every = [&](const auto& write) { return text(rewritten(sheet, reader.hurt, write)); };
  std::vector<Variant> out{
      {"semicolons", text(sheet, {.separator = ';'})},
      {"tabs", text(sheet, {.separator = '\t'})},
      {"semicolons and decimal commas", text(sheet, {.separator = ';', .mark = ','})},
      {"tabs and decimal commas", text(sheet, {.separator = '\t', .mark = ','})},
      {"quoted names", text(sheet, {.quoted_names = true})},
      {"all quoted", text(sheet, {.quoted_names = true, .quoted_cells = true})},
      {"all quoted, decimal commas",
       text(sheet, {.separator = ';', .mark = ',', .quoted_names = true, .quoted_cells = true})},
      {"all quoted, decimal commas between commas",
       text(sheet, {.mark = ',', .quoted_names = true, .quoted_cells = true})},
      {"mark of byte order", "\xEF\xBB\xBF" + plain},
      {"mark of byte order, CR LF", "\xEF\xBB\xBF" + text(sheet, {.end = "\r\n"})},
      {"CR LF", text(sheet, {.end = "\r\n"})},
      {"semicolons, CR LF, decimal commas",
       text(sheet, {.separator = ';', .mark = ',', .end = "\r\n"})},
      {"CR alone", text(sheet, {.end = "\r"})},
      {"UTF-16", utf16(plain, true)},
      {"UTF-16 without its mark", utf16(plain, false)},
      {"no last newline", plain.substr(0, plain.size() - 1)},
      {"blank lines", replaced(plain, "\n", "\n\n")},
      {"blank lines before", "\n \n" + plain},
      {"remark before", "# made by hand, on a Sunday\n" + plain},
      {"remark between", plain.substr(0, half) + "# a remark; of words\n" + plain.substr(half)},
      {"remark of a megabyte",
       plain.substr(0, half) + "# " + std::string(1 << 20, 'x') + "\n" + plain.substr(half)},
      {"separators behind all lines", text(sheet, {.behind_names = ",", .behind_cells = ","})},
      {"separators behind the rows", text(sheet, {.behind_cells = ","})},
      {"separators behind the names", text(sheet, {.behind_names = ",,"})},
      {"# before the names", text(sheet, {.before_names = "#"})},
      {"# and a blank before the names", text(sheet, {.before_names = "# "})},
      {"blanks around cells", replaced(plain, ",", " , ")},
      {"many blanks", replaced(plain, ",", "," + std::string(5000, ' '), 40)},
      {"a plus",
       every([](const std::string& cell) { return cell.starts_with('-') ? cell : "+" + cell; })},
      {"powers of ten",
       every([](const std::string& cell) { return fmt::format("{:.17e}", std::stod(cell)); })},
      {"more decimals", every([](const std::string& cell) {
         return cell.find('.') == std::string::npos ? cell + ".000" : cell + "000";
       })},
  };
  Sheet units = sheet;
  units.rows.insert(units.rows.begin(), Words(sheet.names.size(), "m"));
  for (std::size_t c = 0; c < sheet.names.size(); ++c) {
    const std::string& name = sheet.names[c];
    if (const std::size_t open = name.find(" ["); open != std::string::npos) {
      units.names[c] = name.substr(0, open);
      units.rows[0][c] = name.substr(open + 2, name.size() - open - 3);
    }
  }
  bool all_apart = true;
  for (std::size_t c = 0; c < sheet.names.size(); ++c)
    all_apart = all_apart && units.names[c] != sheet.names[c];
  if (all_apart || reader.kind == Kind::table) out.push_back({"a row of units", text(units)});
  if (reader.by_name) {
    Sheet turned = sheet;
    std::reverse(turned.names.begin(), turned.names.end());
    for (Words& row : turned.rows) std::reverse(row.begin(), row.end());
    out.push_back({"columns in another order", text(turned)});
  }
  if (reader.others)
    for (const auto& [name, cell] : {std::pair<std::string, std::string>{"other", "7.5"},
                                     {"said by", "a person"},
                                     {"quoted, \"\"twice\"\"", "\"one, two; three\""},
                                     {std::string(100000, 'n'), "1"}}) {
      Sheet wide = sheet;
      wide.names.push_back(name.find(',') == std::string::npos ? name : '"' + name + '"');
      for (Words& row : wide.rows) row.push_back(cell);
      if (name.size() < 1000 || reader.kind != Kind::log)
        out.push_back({"another column, " + name.substr(0, 20), text(wide)});
    }
  if (reader.clock)
    for (const auto& [name, date, zone] : {std::tuple{"dates with times", "2026-01-02T03:", "Z"},
                                           {"dates with times, no zone", "2026-01-02 23:", ""},
                                           {"times of day", "12:", ""},
                                           {"times of day around midnight", "23:", ""}}) {
      const auto moment = [&, date = std::string(date), zone = std::string(zone),
                           midnight =
                               std::string(name).ends_with("night")](const std::string& cell) {
        const double time_s = std::stod(cell);
        const int from_s = midnight ? 3598 : 600;
        const int whole_s = from_s + static_cast<int>(time_s);
        const std::string hour = whole_s < 3600 ? date : midnight ? "00:" : "13:";
        const std::string part = fmt::format("{:.6f}", time_s - std::floor(time_s));
        return fmt::format("{}{:02}:{:02}{}{}", hour, whole_s / 60 % 60, whole_s % 60,
                           part.substr(1), zone);
      };
      out.push_back({name, text(rewritten(sheet, *reader.clock, moment))});
    }
  return out;
}

/// Cells that are no number, and rows and headers that fit nothing.
std::vector<Variant> faults(const Reader& reader) {
  const Sheet& sheet = reader.plain;
  const std::string plain = text(sheet);
  const bool log = reader.kind == Kind::log, cloud = reader.kind == Kind::cloud;
  const std::size_t r = sheet.rows.size() / 2, line = line_hurt(reader);
  const std::string& cell = sheet.rows[r][reader.hurt];
  const auto comma = [](const std::string& number) {
    return replaced(number.find('.') == std::string::npos ? number + ".5" : number, ".", ",");
  };
  std::vector<Variant> out;
  const auto cell_fault = [&](const std::string& name, const std::string& odd, Meaning meaning,
                              const Style& style = {}) {
    out.push_back({name, text(with_cell(reader, odd), style), meaning, Place::cell, line});
  };
  for (const auto& [name, odd] :
       std::vector<std::pair<std::string, std::string>>{{"a word", "abc"},
                                                        {"two numbers", "1 2"},
                                                        {"two points", "1.2.3"},
                                                        {"hex", "0x10"},
                                                        {"a unit behind", cell + "m"},
                                                        {"an open quote", "\"" + cell},
                                                        {"infinite", "inf"},
                                                        {"too large", "1e400"},
                                                        {"a Unicode minus", "\u22121.5"},
                                                        {"no number", "nan"},
                                                        {"N/A", "N/A"},
                                                        {"a dash", "-"}})
    cell_fault(name, odd,
               log || odd == "nan" || (cloud && (odd == "inf" || odd == "1e400")) ? Meaning::gap
                                                                                  : Meaning::none);
  const Meaning empty = cloud ? Meaning::none : Meaning::gap;
  cell_fault("an empty cell", "", empty);
  cell_fault("a quoted empty cell", "\"\"", empty);
  cell_fault("NUL bytes", std::string("1\0005", 3), log ? Meaning::gap : Meaning::none);
  if (log) out.back().place = Place::file;
  cell_fault("thousands between commas", "\"1,234.5\"", Meaning::none);
  cell_fault("thousands beside semicolons", "1,234.5", Meaning::none, {.separator = ';'});
  cell_fault("one decimal comma beside points", comma(cell), Meaning::none, {.separator = ';'});
  cell_fault("a quoted decimal comma between commas", "\"" + comma(cell) + "\"", Meaning::none);
  {
    Sheet mixed = rewritten(sheet, reader.hurt, comma);
    const std::string bytes = text(mixed, {.separator = ';'});
    out.push_back({"a column of decimal commas beside points", bytes, Meaning::none, Place::line});
    out.push_back(
        {"the same between tabs", replaced(bytes, ";", "\t"), Meaning::none, Place::line});
  }
  out.push_back(
      {"decimal commas between commas", text(sheet, {.mark = ','}), Meaning::none, Place::line});
  const auto row_fault = [&](const std::string& name, const Words& row) {
    Sheet odd = sheet;
    odd.rows[r] = row;
    out.push_back({name, text(odd), Meaning::none, Place::line, line});
  };
  const Words& row = sheet.rows[r];
  row_fault("a short row", Words(row.begin(), row.end() - 1));
  Words longer = row;
  longer.push_back("7");
  row_fault("a long row", longer);
  longer.back() = "";
  longer.push_back("7");
  row_fault("a long row behind a gap", longer);
  row_fault("a row of a million cells", Words(1000000, "1"));
  if (!log) row_fault("the header again", sheet.names);
  out.push_back({"names between semicolons, rows between commas",
                 replaced(plain, ",", ";", sheet.names.size() - 1),
                 cloud ? Meaning::one : Meaning::none, Place::line});
  if (log) {
    const std::size_t cut = plain.rfind(',');
    out.push_back({"a last row that was cut off", plain.substr(0, cut), Meaning::cut});
    out.push_back({"a last row that is too long, cut off", plain.substr(0, plain.size() - 1) + ",8",
                   Meaning::none, Place::line, 1 + sheet.rows.size()});
  }
  if (reader.by_name) {
    Sheet twice = sheet;
    twice.names.push_back(sheet.names[reader.hurt]);
    for (Words& one : twice.rows) one.push_back("8.5");
    out.push_back({"a name twice", text(twice), Meaning::none, cloud ? Place::file : Place::line,
                   cloud ? 0u : 1u});
    if (!log && !reader.may_lack) {
      Sheet less = sheet;
      less.names.erase(less.names.begin() + static_cast<std::ptrdiff_t>(reader.hurt));
      for (Words& one : less.rows)
        one.erase(one.begin() + static_cast<std::ptrdiff_t>(reader.hurt));
      out.push_back({"a column less", text(less), Meaning::none, Place::file});
    }
  }
  out.push_back({"empty", "", Meaning::none, Place::file});
  out.push_back({"blank", "\n\n \n", Meaning::none, Place::file});
  out.push_back({"a remark alone", "# nothing\n", Meaning::none, Place::file});
  if (!reader.none_is_some)
    out.push_back(
        {"a header alone", plain.substr(0, plain.find('\n') + 1), Meaning::none, Place::file});
  if (!log && reader.clock == std::nullopt && reader.hurt != 0)
    cell_fault("a moment", "2026-01-02T03:04:05.678Z", Meaning::none);
  return out;
}

/// What a command made of a table, without what it says of the bytes that it read.
struct Outcome {
  int code = -1;
  std::string made, err;
  bool operator==(const Outcome& other) const { return code == other.code && made == other.made; }
};

/// A text without sums of what was read and without the count of words in place of numbers.
std::string without_asides(std::string text) {
  for (std::size_t at; (at = text.find(" are no numbers: taken as empty")) != std::string::npos;) {
    const std::size_t begin = text.rfind('\n', at) + 1;
    text.erase(begin, text.find('\n', at) + 1 - begin);
  }
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find_first_not_of("0123456789abcdef", at), text.size());
    if (end - at < 16) out.append(text, at, end - at);
    if (end < text.size()) out += text[end];
    at = end + 1;
  }
  return out;
}

Outcome outcome(const Reader& reader, const Folder& folder, const std::string& bytes) {
  const std::string table = folder / "t.csv", out = folder / "o";
  std::filesystem::remove_all(out);
  std::filesystem::create_directory(out);
  cli::write(table, bytes);
  Words words;
  for (const std::string& word : reader.call)
    words.push_back(word == "T"              ? table
                    : word.starts_with("O/") ? out + word.substr(1)
                                             : replaced(word, "T@", table + "@"));
  const ToolRun ran = run_tool(reader.tool, words);
  Outcome found{ran.code, ran.out, ran.err};
  if (!ran.out.starts_with('{')) found.made.clear();
  if (ran.code != 0) return found;
  // Of a mapping, what was mapped: a row of units tells apart what is one word in the plain table.
  if (found.made.find("\"channel_of_column\"") != std::string::npos) {
    const nlohmann::json said = nlohmann::json::parse(found.made);
    nlohmann::json mapped{said["rows"], said["channel_of_column"]};
    for (const auto& channel : said["channels"])
      if (!channel["channel"].get<std::string>().empty())
        mapped[2][channel["channel"].get<std::string>()] = {channel["samples"], channel["rate_hz"],
                                                            channel["least"], channel["greatest"]};
    return {found.code, mapped.dump(), found.err};
  }
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(out))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const std::filesystem::path& file : files)
    if (const std::string ending = file.extension();
        ending == ".csv" || ending == ".crg" || ending == ".yaml" || ending == ".tir" ||
        ending == ".txt" || ending == ".tiles" || file.filename() == "page.html" ||
        file.filename() == "findings.json")
      found.made += file.filename().string() + "\n" + without_asides(cli::read(file)) + "\n";
  return found;
}

/// What is wrong with how a table was refused; nothing, if it was as it should.
std::string fault_of_refusal(const Outcome& found, const Reader& reader, const Variant& variant) {
  if (found.code != 1 && found.code != 2) return fmt::format("exit code {}", found.code);
  if (std::count(found.err.begin(), found.err.end(), '\n') != 1) return "not one line";
  if (found.err.size() > 1000) return "a line without end";
  const std::string place =
      variant.line == 0 ? "t\\.csv:[0-9]+: " : fmt::format("t\\.csv:{}: ", variant.line);
  if (variant.place == Place::file)
    return found.err.find("t.csv") != std::string::npos ? "" : "no file";
  if (!std::regex_search(found.err, std::regex(place))) return "no line, or another";
  if (variant.place == Place::cell && reader.kind != Kind::cloud &&  // these count columns
      found.err.find(reader.plain.names[reader.hurt]) == std::string::npos)
    return "no column";
  return "";
}

struct Count {
  int tables = 0, one_meaning = 0, read = 0, wrong = 0;
};

/// Every table, or every `step`th from `first` on.
void try_tables(const Reader& reader, const Folder& folder, std::size_t first, std::size_t step,
                Count& count) {
  const Outcome plain = outcome(reader, folder, text(reader.plain));
  ASSERT_EQ(plain.code, 0) << reader.name << ": " << plain.err;
  ASSERT_FALSE(plain.made.empty()) << reader.name;
  std::optional<Outcome> gap, cut;
  std::vector<Variant> all = plain_ways(reader);
  for (Variant& fault : faults(reader)) all.push_back(std::move(fault));
  Count own;
  for (std::size_t v = first; v < all.size(); v += step) {
    const Variant& variant = all[v];
    const Outcome found = outcome(reader, folder, variant.bytes);
    const Outcome* truth = variant.meaning == Meaning::one ? &plain : nullptr;
    if (variant.meaning == Meaning::gap && (reader.gaps || reader.kind == Kind::log)) {
      if (!gap)
        gap = outcome(reader, folder,
                      text(with_cell(reader, reader.kind == Kind::cloud ? "nan" : "")));
      truth = &*gap;
    }
    if (variant.meaning == Meaning::cut) {
      Sheet less = reader.plain;
      less.rows.pop_back();
      if (!cut) cut = outcome(reader, folder, text(less));
      truth = &*cut;
    }
    ++own.tables;
    own.one_meaning += truth != nullptr ? 1 : 0;
    std::string fault;
    if (truth != nullptr && found == *truth) {
      ++own.read;
    } else if (truth != nullptr && found.code == truth->code) {
      fault = "another outcome";
    } else {
      Variant refused = variant;
      if (variant.meaning == Meaning::one) refused.place = Place::file, refused.line = 0;
      fault = fault_of_refusal(found, reader, refused);
      if (truth != nullptr && fault.empty() && std::getenv("ODD_TABLES") != nullptr)
        std::printf("  not read: %s, %s: %s", reader.name.c_str(), variant.name.c_str(),
                    found.err.c_str());
    }
    own.wrong += fault.empty() ? 0 : 1;
    EXPECT_EQ(fault, "") << reader.name << ", " << variant.name << ": " << found.code << " "
                         << found.err.substr(0, 400);
  }
  std::printf("%-28s %3d tables, %2d of %2d with one meaning read, %d wrong\n", reader.name.c_str(),
              own.tables, own.read, own.one_meaning, own.wrong);
  count.tables += own.tables, count.one_meaning += own.one_meaning;
  count.read += own.read, count.wrong += own.wrong;
}

/// Rows of numbers with at most six decimals.
template <class Row>
Sheet sheet_of(const Words& names, int rows, const Row& row) {
  Sheet sheet{names, {}};
  for (int i = 0; i < rows; ++i) {
    Words cells;
    for (const double value : row(i)) cells.push_back(fmt::format("{:.6f}", value));
    sheet.rows.push_back(cells);
  }
  return sheet;
}
using Numbers = std::vector<double>;

/// Those that need no road and take little time.
std::vector<Reader> quick_readers(const Folder& folder) {
  const std::string cars = places::source() + "/vehicles/open_wheel/";
  cli::write(folder / "right.csv", "x_m,y_m\n0,-5\n30,-5\n60,-5\n100,-6\n");
  return {
      {.name = "crgdrive tyre --points",
       .tool = places::crgdrive(),
       .call = {"tyre", "--tir", cars + "front.tir", "--points", "T", "-o", "O/forces.csv"},
       .plain = sheet_of({"fz_n", "kappa", "alpha_rad", "gamma_rad", "vx_mps"}, 7,
                         [](int i) {
                           return Numbers{3000.5 + i, 0.01 * i, 0.015 - 0.01 * i, 0.0, 30.5};
                         }),
       .hurt = 2,
       .others = false,
       .by_name = false,
       .none_is_some = true},
      {.name = "crgsim run --inputs",
       .tool = places::crgsim(),
       .call = {"run", cars + "vehicle.yaml", "--inputs", "T", "--stop-s", "0.05", "--set",
                "start.u=20.0", "-o", "O/run.csv"},
       .plain = sheet_of({"time_s", "input.throttle", "input.steering"}, 6,
                         [](int i) {
                           return Numbers{0.0078125 * i, 0.1 * i, 0.25 - 0.1 * i};
                         }),
       .hurt = 2,
       .others = false,
       .none_is_some = true,
       .may_lack = true},
      {.name = "crgsim run --opponent",
       .tool = places::crgsim(),
       .call = {"run", cars + "vehicle.yaml", "--opponent", "T@1m", "--stop-s", "0.05", "-o",
                "O/run.csv"},
       .plain = sheet_of({"time_s", "x_m", "y_m"}, 12,
                         [](int i) {
                           return Numbers{0.125 * i, 4.5 * i - 10.5, 0.015 * i * i};
                         }),
       .kind = Kind::log,
       .clock = 0},
      {.name = "crgexplain map",
       .tool = places::crgexplain(),
       .call = {"map", "T", "--json", "-o", "O/mapping.yaml"},
       .plain =
           sheet_of({"time_s", "speed [km/h]", "yaw rate [deg/s]"}, 60,
                    [](int i) {
                      return Numbers{0.125 * i, 100.5 + 3.2 * std::sin(0.3 * i), 0.25 * i - 3.1};
                    }),
       .kind = Kind::log,
       .none_is_some = true,  // a draft, with exit code 3: Open.OfADraftThatNothingCanUse*
       .clock = 0},
      {
          .name = "crgexplain map, units",
          .tool = places::crgexplain(),
          .call = {"map", "T", "--json", "-o", "O/mapping.yaml"},
          .plain =
              sheet_of({"time [s]", "speed [km/h]", "yaw rate [deg/s]"}, 60,
                       [](int i) {
                         return Numbers{0.125 * i, 100.5 + 3.2 * std::sin(0.3 * i), 0.25 * i - 3.1};
                       }),
          .kind = Kind::log,
          .none_is_some = true,
      },
      {.name = "crgidentify actuator",
       .tool = places::crgidentify(),
       .call = {"actuator", "T", "-o", "O/sheet.txt"},
       .plain = sheet_of({"time_s", "steer_command_rad", "steer_rad"}, 600,
                         [](int i) {
                           const auto wave = [](int k) {
                             return 0.1 * std::sin(0.03 * k) + 0.03 * std::sin(0.11 * k);
                           };
                           return Numbers{0.015625 * i, 16 * wave(i), wave(i - 4)};
                         }),
       .kind = Kind::log,
       .hurt = 2,
       .clock = 0},
      {.name = "crgbuild from-edges",
       .tool = places::crgbuild(),
       .call = {"from-edges", "T", folder / "right.csv", "-o", "O/e"},
       .plain = sheet_of({"x_m", "y_m"}, 5,
                         [](int i) {
                           return Numbers{25.5 * i, 5.25 + 0.05 * i * i};
                         })},
      {.name = "crgbuild from-edges, widths",
       .tool = places::crgbuild(),
       .call = {"from-edges", "T", "-o", "O/e"},
       .plain = sheet_of({"x_m", "y_m", "w_tr_right_m", "w_tr_left_m"}, 5,
                         [](int i) {
                           return Numbers{25.5 * i, 0.05 * i * i, 5.25, 4.5 + 0.05 * i};
                         }),
       .hurt = 3},
  };
}

/// A table that one of the programs wrote, its first rows.
Sheet sheet_from(const std::string& path, std::size_t most_rows) {
  std::istringstream lines(cli::read(path));
  Sheet sheet;
  for (std::string line; std::getline(lines, line) && sheet.rows.size() < most_rows;) {
    if (line.starts_with('#')) continue;
    Words cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    if (line.ends_with(',')) cells.emplace_back();
    if (sheet.names.empty())
      sheet.names = cells;
    else
      sheet.rows.push_back(cells);
  }
  return sheet;
}

std::size_t column_of(const Sheet& sheet, const std::string& name) {
  return static_cast<std::size_t>(std::find(sheet.names.begin(), sheet.names.end(), name) -
                                  sheet.names.begin());
}

/// The car with one map of its own.
std::string car_with_map(const Folder& folder, const std::string& map) {
  const std::string car = folder / ("car_with_" + map);
  std::filesystem::copy(places::source() + "/vehicles/open_wheel", car);
  std::string file = car + "/vehicle.yaml";
  cli::write(file, replaced(cli::read(file), ": " + map + ".csv", ": " + (folder / "t.csv")));
  return file;
}

/// Places on the middle of the stadium.
Numbers on_stadium(double u_m) {
  constexpr double kStraight_m = 120, kRadius_m = 40, kBend_m = std::numbers::pi * kRadius_m;
  if (u_m < kStraight_m) return {u_m, 0};
  if (u_m < kStraight_m + kBend_m) {
    const double turned = (u_m - kStraight_m) / kRadius_m;
    return {kStraight_m + kRadius_m * std::sin(turned), kRadius_m * (1 - std::cos(turned))};
  }
  const Numbers opposite = on_stadium(u_m - kStraight_m - kBend_m);
  return {kStraight_m - opposite[0], 2 * kRadius_m - opposite[1]};
}

/// Places `left_m` beside the middle of a ring whose halves differ.
Numbers on_egg(double turned, double left_m) {
  const double radius_m = 60 + 15 * std::sin(turned) + 6 * std::sin(2 * turned + 1) - left_m;
  return {radius_m * std::cos(turned), radius_m * std::sin(turned)};
}

void run_or_fail(const std::string& tool, const Words& words) {
  const ToolRun ran = run_tool(tool, words);
  ASSERT_EQ(ran.code, 0) << ran.err;
}

std::vector<Reader> readers_of_crgbuild(const Folder& f) {
  const std::string mesh = f / "s.obj", road = f / "out/s.crg", tool = places::crgbuild();
  cli::write(mesh, cli::Stadium{}.obj());
  run_or_fail(tool, {"build", mesh, "-o", f / "out", "--no-report"});
  cli::write(f / "right_deg.csv",
             "lat_deg,lon_deg\n48.1,11.5\n48.1,11.5004\n48.1,11.5008\n48.1,11.5012\n");
  const auto edge = [](double left_m) {
    return sheet_of({"x_m", "y_m"}, 120,
                    [left_m](int i) { return on_egg(i * std::numbers::pi / 60, left_m); });
  };
  cli::write(f / "egg_left.csv", text(edge(4)));
  cli::write(f / "egg_right.csv", text(edge(-4)));
  run_or_fail(tool, {"from-edges", f / "egg_left.csv", f / "egg_right.csv", "-o", f / "egg"});
  cli::write(f / "mapping.yaml",
             "version: 1\ncolumns:\n  east: {channel: x_m}\n  north: {channel: y_m}\n");
  const auto round = [](const Words& names, int points, const auto& row) {
    return sheet_of(names, points, [&](int i) {
      return row(i, on_stadium((i + 0.25) * cli::Stadium::length_m() / points));
    });
  };
  const Sheet middle = sheet_from(f / "out/centreline.csv", 100000);
  Sheet line = middle;
  line.rows.clear();
  for (std::size_t i = 0; i + 20 < middle.rows.size() / 2; i += 20)
    line.rows.push_back(middle.rows[i]);
  const Words zones{"u_begin_m", "u_end_m", "v_begin_m", "v_end_m"};
  const auto zone = [&](const char* last, double value) {
    Words names = zones;
    names.emplace_back(last);
    return sheet_of(names, 4, [value](int i) {
      return Numbers{10.5 + 30 * i, 25.25 + 30 * i, -2.5 + i, 2.5, value};
    });
  };
  return {
      {.name = "crgbuild query --points",
       .tool = tool,
       .call = {"query", road, "--points", "T", "-o", "O/z.csv"},
       .plain = round({"x_m", "y_m"}, 9, [](int, const Numbers& p) { return p; }),
       .gaps = true,
       .none_is_some = true},
      {.name = "crgbuild sample --centreline",
       .tool = tool,
       .call = {"sample", mesh, "--centreline", "T", "--u-step-m", "0.5", "-o", "O/s.crg"},
       .plain = line},
      {.name = "crgbuild centreline --guide",
       .tool = tool,
       .call = {"centreline", mesh, "--guide", "T", "-o", "O/line.csv"},
       .plain = round({"x_m", "y_m"}, 40, [](int, const Numbers& p) { return p; }),
       .gaps = true},
      {.name = "crgbuild centreline --mapping",
       .tool = tool,
       .call = {"centreline", mesh, "--guide", "T", "--mapping", f / "mapping.yaml", "-o",
                "O/line.csv"},
       .plain = round({"time", "east", "north"}, 40,
                      [](int i, const Numbers& p) {
                        return Numbers{0.5 * i, p[0], p[1]};
                      }),
       .kind = Kind::log,
       .clock = 0},
      {.name = "crgbuild align --control-points",
       .tool = tool,
       .call = {"align", road, "--control-points", "T", "-o", "O/a.crg"},
       .plain = round({"mesh_x_m", "mesh_y_m", "mesh_z_m", "x_m", "y_m", "z_m"}, 5,
                      [](int, const Numbers& p) {
                        return Numbers{p[0], p[1], 0.5, 1000.5 + p[0], 2000.25 + p[1], 300.5};
                      }),
       .hurt = 3},
      {.name = "crgbuild align --trajectory",
       .tool = tool,
       .call = {"align", f / "egg/egg.crg", "--trajectory", "T", "-o", "O/a.crg"},
       .plain = sheet_of({"x_m", "y_m", "z_m"}, 60,
                         [](int i) {
                           const Numbers p = on_egg((i + 0.25) * std::numbers::pi / 30, 0);
                           return Numbers{1000.5 + p[0], 2000.25 + p[1], 300.5};
                         }),
       .gaps = true},
      {.name = "crgbuild from-edges, degrees",
       .tool = tool,
       .call = {"from-edges", "T", f / "right_deg.csv", "-o", "O/e"},
       .plain = sheet_of({"lat_deg", "lon_deg"}, 8,
                         [](int i) {
                           return Numbers{48.1001, 11.5 + 0.0002 * i};
                         }),
       .gaps = true},
      {.name = "crgbuild kerb --kerb-zones",
       .tool = tool,
       .call = {"kerb", road, "--mesh", mesh, "--kerb-zones", "T", "-o", "O/k.crg"},
       .plain = zone("kerb", 1),
       .none_is_some = true},
      {.name = "crgbuild build --friction-zones",
       .tool = tool,
       .call = {"build", mesh, "--friction", "--friction-zones", "T", "--no-report", "--u-step-m",
                "1", "--v-step-m", "0.5", "-o", "O/b"},
       .plain = zone("friction", 0.85),
       .hurt = 4,
       .none_is_some = true},
  };
}

std::vector<Reader> readers_of_scans(const Folder& f) {
  const std::string tool = places::lidar2mesh(),
                    ring = places::source() + "/tests/corpus/circuit/closed.yaml";
  run_or_fail(tool, {"synth", ring, "-o", f / "scans", "--u-begin-m", "5", "--u-end-m", "15",
                     "--laps", "1", "--azimuths", "64", "--beams", "8", "--cars", "0"});
  const Sheet poses = sheet_from(f / "scans/truth_trajectory.csv", 1000);
  return {
      {.name = "lidar2mesh tiles --trajectory",
       .tool = tool,
       .call = {"tiles", f / "scans/scan_000.ply", "--trajectory", "T", "-o", "O/t"},
       .plain = poses,
       .hurt = 2},
      {.name = "lidar2mesh info, a survey",
       .tool = tool,
       .call = {"info", "T", "--json"},
       .plain = sheet_of({"x_m", "y_m", "z_m"}, 20,
                         [](int i) {
                           return Numbers{0.5 * i - 3, 2.25 * i, 0.01 * i * i};
                         }),
       .kind = Kind::cloud,
       .gaps = true},
  };
}

std::vector<Reader> readers_of_drives(const Folder& f) {
  const std::string car = places::source() + "/vehicles/open_wheel/vehicle.yaml",
                    tir = places::source() + "/vehicles/open_wheel/front.tir",
                    road = f / "scans/truth.crg";
  run_or_fail(places::crgdrive(), {"lap", "--car", car, "--road", road, "-o", f / "lap.csv"});
  const Sheet lap = sheet_from(f / "lap.csv", 100000);
  Sheet begin = lap;
  begin.rows.resize(300);
  const std::size_t speed = column_of(lap, "vx_mps");
  Sheet bench =
      sheet_of({"fz_n", "kappa", "alpha_rad", "gamma_rad", "vx_mps", "fy_n"}, 81, [](int i) {
        const double x = 0.2 * (i - 40);
        return Numbers{3000.5, 0,     0.005 * (i - 40),
                       0,      30.25, -4000.0 * std::sin(0.5 * std::atan(x))};
      });
  std::vector<Reader> out{
      {.name = "crgdrive lap --opponent",
       .tool = places::crgdrive(),
       .call = {"lap", "--car", car, "--road", road, "--opponent", "T", "-o", "O/lap.csv"},
       .plain = sheet_of({"time_s", "x_m", "y_m"}, 60,
                         [](int i) {
                           return Numbers{0.25 * i, 11.5 * i + 5, 0.25 * i};
                         }),
       .kind = Kind::log,
       .clock = 0},
      {.name = "crgdrive replay --log",
       .tool = places::crgdrive(),
       .call = {"replay", "--car", car, "--road", road, "--log", "T", "-o", "O/r"},
       .plain = begin,
       .kind = Kind::log,
       .hurt = speed},
      {.name = "crgdrive report",
       .tool = places::crgdrive(),
       .call = {"report", "T", "--road", road, "-o", "O/page.html"},
       .plain = begin,
       .kind = Kind::log,
       .hurt = speed},
      {.name = "crgdrive, a map of two",
       .tool = places::crgdrive(),
       .call = {"manoeuvre", "bump", "--car", car_with_map(f, "drag"), "--stop-s", "1.2", "-o",
                "O/bump.csv"},
       .plain = sheet_from(places::source() + "/vehicles/open_wheel/drag.csv", 100),
       .others = false,
       .by_name = false},
      {.name = "crgdrive, a map of one",
       .tool = places::crgdrive(),
       .call = {"manoeuvre", "bump", "--car", car_with_map(f, "yaw_drag"), "--stop-s", "1.2", "-o",
                "O/bump.csv"},
       .plain = sheet_from(places::source() + "/vehicles/open_wheel/yaw_drag.csv", 100),
       .others = false},
      {.name = "crgexplain run",
       .tool = places::crgexplain(),
       .call = {"run", "--road", road, "--car", car, "--log", "T", "--skip-simulation", "--nulls",
                "100", "-o", "O/found"},
       .plain = lap,
       .kind = Kind::log,
       .hurt = speed},
      {.name = "crgidentify tyre",
       .tool = places::crgidentify(),
       .call = {"tyre", "T", "--tir", tir, "--starts", "1", "-o", "O/fitted.tir"},
       .plain = bench,
       .hurt = 5,
       .gaps = true},
  };
  for (const char* command : {"mass", "aero", "brakes"})
    out.push_back({.name = std::string("crgidentify ") + command,
                   .tool = places::crgidentify(),
                   .call = {command, "T", "--road", road, "--car", car, "-o", "O/sheet.txt"},
                   .plain = lap,
                   .kind = Kind::log,
                   .hurt = speed});
  return out;
}

/// Every `step`th table of each.
Count tried(const std::vector<Reader>& readers, const Folder& folder, std::size_t step) {
  Count count;
  for (std::size_t k = 0; k < readers.size(); ++k)
    try_tables(readers[k], folder, k % step, step, count);
  std::printf("%d tables: %d wrong; %d of %d that have one meaning are read\n", count.tables,
              count.wrong, count.read, count.one_meaning);
  return count;
}

TEST(OddTables, AreReadRightOrRefused) {
  const Folder folder;
  EXPECT_EQ(tried(quick_readers(folder), folder, 32).wrong, 0);
}

TEST(SlowOddTables, AreReadRightOrRefused) {
  const Folder folder;
  std::vector<Reader> readers = quick_readers(folder);
  for (const auto& more : {readers_of_crgbuild, readers_of_scans, readers_of_drives})
    for (Reader& reader : more(folder)) readers.push_back(std::move(reader));
  const Count count = tried(readers, folder, 1);
  EXPECT_GE(count.tables, 500);
  EXPECT_EQ(count.wrong, 0);
  EXPECT_GE(count.read, 0.9 * count.one_meaning);
}

}  // namespace odd_tables_test
