#include "header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "crg/error.h"
#include "crg/options.h"
#include "text.h"

namespace crg {
namespace {

constexpr std::string_view kMaxMagnitudeText = "1e12";
constexpr double kMaxMagnitude =
    1e12;  // larger header values have no metre-sized meaning in double

enum class Kind { None, Comment, Road, Options, Modifiers, Projection, File, Definition, Other };

Kind kind_of(std::string_view name) {
  if (name == "CT") return Kind::Comment;
  if (name == "ROAD_CRG") return Kind::Road;
  if (name == "ROAD_CRG_OPTS") return Kind::Options;
  if (name == "ROAD_CRG_MODS") return Kind::Modifiers;
  if (name == "ROAD_CRG_MPRO") return Kind::Projection;
  if (name == "ROAD_CRG_FILE") return Kind::File;
  if (name == "KD_DEFINITION") return Kind::Definition;
  return Kind::Other;
}

// How far the channel definitions have been understood before the v positions are settled.
struct Definitions {
  struct HeightColumn {
    std::size_t column = 0;
    double position = 0.0;  // v in metres, or the number of the section
    std::size_t line = 0;
  };
  std::vector<HeightColumn> heights;
  bool explicit_v = false;
  bool format_given = false;
};

class Parser {
 public:
  Parser(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  Header parse();

 private:
  [[noreturn]] void fail(const std::string& message) const { fail_at(line_, message); }
  [[noreturn]] void fail_at(std::size_t line, const std::string& message) const {
    // A damaged word may be as long as the file.
    throw Error(name_ + ":" + std::to_string(line) + ": " +
                (message.size() > 500
                     ? message.substr(0, 300) + " ... " + message.substr(message.size() - 150)
                     : message));
  }
  void note(const std::string& message) {
    if (header_.crg.notes.size() < 100) {
      header_.crg.notes.push_back("line " + std::to_string(line_) + ": " + message);
    }
  }

  void open_section(std::string_view line);
  void parse_line(std::string_view line);
  void parse_entry(std::string_view line, std::vector<HeaderEntry>& entries);
  void parse_definition(std::string_view line);
  void parse_channel(std::string_view text);
  void place_heights();
  std::vector<double> regular_positions();

  std::string_view bytes_;
  const std::string& name_;
  std::size_t line_ = 0;
  Kind section_ = Kind::None;
  std::vector<Kind> seen_;
  Header header_;
  Definitions definitions_;
};

void Parser::open_section(std::string_view line) {
  std::size_t end = 1;
  while (end < line.size() &&
         (std::isalnum(static_cast<unsigned char>(line[end])) != 0 || line[end] == '_')) {
    ++end;
  }
  if (end == 1) {  // a closing line such as "$!****"
    section_ = Kind::None;
    return;
  }
  const std::string name = upper(line.substr(1, end - 1));
  section_ = kind_of(name);
  if (section_ == Kind::Other) {
    header_.crg.other_sections.push_back({.name = std::string(line)});
    return;
  }
  if (std::find(seen_.begin(), seen_.end(), section_) != seen_.end()) {
    note("section $" + name + " appears again; the standard wants each once. Later values win");
  }
  seen_.push_back(section_);
  if (section_ == Kind::Options) header_.crg.has_option_section = true;
  if (section_ == Kind::Modifiers) header_.crg.has_modifier_section = true;
}

void Parser::parse_entry(std::string_view line, std::vector<HeaderEntry>& entries) {
  if (entries.size() >= 10000) fail("more than 10000 lines in one section");
  HeaderEntry entry;
  const std::size_t bang = line.find('!');
  if (bang != std::string_view::npos) {
    entry.comment = std::string(trim(line.substr(bang + 1)));
    line = line.substr(0, bang);
  }
  line = trim(line);
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) {
    if (!line.empty()) note("ignored, no KEY = value: \"" + std::string(line.substr(0, 60)) + "\"");
    entry.key = "*";
    entry.text = std::string(line);
    if (!line.empty() || !entry.comment.empty()) entries.push_back(std::move(entry));
    return;
  }
  entry.key = upper(trim(line.substr(0, equals)));
  const std::string_view text = trim(line.substr(equals + 1));
  if (entry.key.empty()) fail("no key before '='; write KEY = value");
  if (entry.key.size() >= 3 && entry.key.ends_with("_NM")) {
    entry.text = std::string(text);
  } else {
    std::string_view rest;
    const std::optional<double> value = parse_number(text, &rest);
    if (!value) {
      fail(entry.key + " = \"" + std::string(text.substr(0, 40)) + "\": want a finite number");
    }
    if (std::abs(*value) > kMaxMagnitude) {
      fail(entry.key + " = " + shortest(*value) + ": want at most " +
           std::string(kMaxMagnitudeText));
    }
    if (!trim(rest).empty()) {
      note(entry.key + ": read as " + shortest(*value) + ", ignored \"" +
           std::string(rest.substr(0, 40)) + "\"");
    }
    entry.value = *value;
  }
  if (std::any_of(entries.begin(), entries.end(),
                  [&](const HeaderEntry& e) { return e.key == entry.key; })) {
    note(entry.key + " is given again; the later value holds");
  }
  entries.push_back(std::move(entry));
}

void Parser::parse_channel(std::string_view text) {
  const std::size_t bang = text.find('!');
  const std::string_view definition = trim(text.substr(0, bang));
  const std::size_t comma = definition.find(',');
  const std::string_view unit =
      comma == std::string_view::npos
          ? std::string_view()
          : trim(definition.substr(comma + 1, definition.find(',', comma + 1) - comma - 1));
  std::string name = upper(trim(definition.substr(0, comma)));
  name.erase(
      std::unique(name.begin(), name.end(), [](char a, char b) { return a == ' ' && b == ' '; }),
      name.end());

  const auto want_unit = [&](std::string_view wanted) {
    if (unit.empty()) {
      note("channel \"" + std::string(definition) + "\" has no unit; taken as " +
           std::string(wanted));
    } else if (upper(unit) != upper(wanted)) {
      fail("channel \"" + std::string(definition.substr(0, 60)) + "\": unit \"" +
           std::string(unit.substr(0, 20)) + "\", want " + std::string(wanted));
    }
  };
  const std::size_t column = header_.columns.size();
  struct Known {
    std::string_view name, unit;
    Column::Kind kind;
  };
  constexpr std::array<Known, 6> kReferenceChannels = {
      {{"REFERENCE LINE PHI", "rad", Column::Kind::Heading},
       {"REFERENCE LINE SLOPE", "m/m", Column::Kind::Slope},
       {"REFERENCE LINE BANKING", "m/m", Column::Kind::Banking},
       {"REFERENCE LINE X", "m", Column::Kind::X},
       {"REFERENCE LINE Y", "m", Column::Kind::Y},
       {"REFERENCE LINE U", "m", Column::Kind::U}}};
  for (const Known& known : kReferenceChannels) {
    if (name != known.name) continue;
    want_unit(known.unit);
    for (const Column& other : header_.columns) {
      if (other.kind == known.kind)
        fail("channel \"" + std::string(definition) + "\" is defined twice");
    }
    header_.columns.push_back({known.kind, 0});
    return;
  }

  constexpr std::string_view kLongSection = "LONG SECTION ";
  if (name.starts_with(kLongSection)) {
    want_unit("m");
    std::string_view rest = std::string_view(name).substr(kLongSection.size());
    constexpr std::string_view kAtV = "AT V";
    const bool explicit_v = rest.starts_with(kAtV);
    if (explicit_v) {
      rest = trim(rest.substr(kAtV.size()));
      if (!rest.starts_with('='))
        fail("channel \"" + std::string(definition.substr(0, 60)) +
             "\": want \"long section at v = X,m\"");
      rest.remove_prefix(1);
    }
    const std::optional<double> position = parse_number(rest, &rest);
    if (!position || !trim(rest).empty() || std::abs(*position) > 1e6) {
      fail("channel \"" + std::string(definition.substr(0, 60)) +
           "\": want \"long section N,m\" or \"long section at v = X,m\" with a number up to 1e6");
    }
    if (!definitions_.heights.empty() && definitions_.explicit_v != explicit_v) {
      fail("long sections are defined both by number and by v; use one of the two for all of them");
    }
    definitions_.explicit_v = explicit_v;
    definitions_.heights.push_back({column, *position, line_});
    header_.columns.push_back({Column::Kind::Height, 0});
    return;
  }
  note("channel \"" + std::string(definition.substr(0, 60)) +
       "\" is not one of the standard's; kept, not used");
  header_.columns.push_back({Column::Kind::Other, header_.crg.other_channels.size()});
  header_.crg.other_channels.push_back({.definition = std::string(definition)});
}

void Parser::parse_definition(std::string_view line) {
  const std::string_view text = trim(line);
  if (text.empty() || text.front() == '!') return;
  const std::string prefix = upper(text.substr(0, 2));
  if (prefix == "#:") {
    const std::string_view word = trim(text.substr(
        2, text.find('!') == std::string_view::npos ? std::string_view::npos : text.find('!') - 2));
    const std::string name = upper(word);
    Format& format = header_.crg.format;
    if (name == "KRBI")
      format = Format::KRBI;
    else if (name == "KDBI")
      format = Format::KDBI;
    else if (name == "LRFI")
      format = Format::LRFI;
    else if (name == "LDFI")
      format = Format::LDFI;
    else
      fail("data format \"" + std::string(word.substr(0, 20)) +
           "\", want KRBI, KDBI, LRFI or LDFI");
    definitions_.format_given = true;
  } else if (prefix == "D:") {
    if (header_.columns.size() >= 1000000) fail("more than 1000000 channels");
    parse_channel(trim(text.substr(2)));
  } else if (prefix == "U:") {
    header_.crg.virtual_channels.emplace_back(trim(text.substr(2)));
  } else {
    note("ignored in $KD_DEFINITION: \"" + std::string(text.substr(0, 60)) + "\"");
  }
}

void Parser::parse_line(std::string_view line) {
  if (section_ == Kind::Comment) {
    header_.crg.comment.emplace_back(line);
    return;
  }
  if (section_ == Kind::Other) {
    header_.crg.other_sections.back().lines.emplace_back(line);
    return;
  }
  std::vector<HeaderEntry>* entries = section_ == Kind::Road         ? &header_.crg.road
                                      : section_ == Kind::Options    ? &header_.crg.options
                                      : section_ == Kind::Modifiers  ? &header_.crg.modifiers
                                      : section_ == Kind::Projection ? &header_.crg.projection
                                                                     : nullptr;
  if (line.starts_with('*')) {
    if (entries != nullptr) entries->push_back({.key = "*", .text = std::string(line.substr(1))});
    return;
  }
  if (entries != nullptr) {
    parse_entry(line, *entries);
  } else if (section_ == Kind::Definition) {
    parse_definition(line);
  } else if (section_ == Kind::File) {
    header_.include_path += trim(line.substr(0, line.find('!')));
    if (header_.include_line == 0 && !header_.include_path.empty()) header_.include_line = line_;
  } else if (!trim(line).empty() && trim(line).front() != '!') {
    note("ignored outside any section: \"" + std::string(line.substr(0, 60)) + "\"");
  }
}

// v of "long section N": V_RIGHT + (N - 1) * V_INCREMENT, either derived from the other two and the
// number of sections where it is missing.
std::vector<double> Parser::regular_positions() {
  const std::vector<HeaderEntry>& road = header_.crg.road;
  const std::size_t count = definitions_.heights.size();
  const std::optional<double> given_right = find_value(road, "LONG_SECTION_V_RIGHT");
  const std::optional<double> left = find_value(road, "LONG_SECTION_V_LEFT");
  std::optional<double> step = find_value(road, "LONG_SECTION_V_INCREMENT");
  const double steps = static_cast<double>(count) - 1.0;
  if (!step) {
    if (!left || !given_right || count < 2) {
      fail(
          "LONG_SECTION_V_INCREMENT is missing, and LONG_SECTION_V_RIGHT and _LEFT are not both "
          "there to "
          "derive it from; add it to $ROAD_CRG or define \"long section at v = X\"");
    }
    step = (*left - *given_right) / steps;
    note("LONG_SECTION_V_INCREMENT derived from V_RIGHT, V_LEFT and " + std::to_string(count) +
         " sections");
  }
  if (*step <= 0.0) fail("LONG_SECTION_V_INCREMENT = " + shortest(*step) + ": want more than 0");
  const double right = given_right ? *given_right : left ? *left - steps * *step : 0.0;
  std::vector<double> positions(count);
  for (std::size_t j = 0; j < count; ++j) positions[j] = right + static_cast<double>(j) * *step;
  return positions;
}

void Parser::place_heights() {
  auto& heights = definitions_.heights;
  if (heights.size() < 2) {
    fail(std::to_string(heights.size()) + " \"D:long section\" channels: want at least 2");
  }
  std::stable_sort(heights.begin(), heights.end(),
                   [](const auto& a, const auto& b) { return a.position < b.position; });
  std::vector<double>& v_m = header_.crg.grid.v_m;
  for (std::size_t j = 0; j < heights.size(); ++j) {
    header_.columns[heights[j].column].index = j;
    const bool wrong_number =
        !definitions_.explicit_v && heights[j].position != static_cast<double>(j + 1);
    const bool repeated = j > 0 && heights[j].position <= heights[j - 1].position;
    if (wrong_number || repeated) {
      fail_at(heights[j].line,
              "long section " + shortest(heights[j].position) +
                  (wrong_number
                       ? ": want the numbers 1 to " + std::to_string(heights.size()) + ", each once"
                       : ": defined twice"));
    }
    v_m.push_back(heights[j].position);
  }
  if (!definitions_.explicit_v) v_m = regular_positions();
  for (std::size_t j = 0; j < v_m.size(); ++j) {
    if (!(std::abs(v_m[j]) <= 1e6) || (j > 0 && !(v_m[j] - v_m[j - 1] > 1e-9))) {
      fail("v of long section " + std::to_string(j + 1) + " is " + shortest(v_m[j]) +
           ": want ascending values at least 1e-9 m apart, at most 1e6 m");
    }
  }
}

Header Parser::parse() {
  std::size_t offset = 0;
  while (offset < bytes_.size()) {
    const std::size_t newline = bytes_.find('\n', offset);
    const std::size_t end = newline == std::string_view::npos ? bytes_.size() : newline;
    std::string_view line = bytes_.substr(offset, end - offset);
    offset = newline == std::string_view::npos ? bytes_.size() : newline + 1;
    ++line_;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.starts_with("$$")) {
      header_.has_separator = true;
      break;
    }
    if (line.starts_with('$')) {
      open_section(line);
    } else {
      parse_line(line);
    }
  }
  header_.end_offset = offset;
  header_.line_count = line_;
  if (!header_.columns.empty()) {
    if (!definitions_.format_given)
      note("no \"#:\" line in $KD_DEFINITION; the standard's default is KRBI");
    place_heights();
  }
  return std::move(header_);
}

}  // namespace

std::size_t find_header_end(std::string_view bytes) {
  std::size_t start = 0;
  if (!bytes.starts_with("$$")) {
    const std::size_t found = bytes.find("\n$$");
    if (found == std::string_view::npos) return found;
    start = found + 1;
  }
  const std::size_t newline = bytes.find('\n', start);
  return newline == std::string_view::npos ? newline : newline + 1;
}

Header parse_header(std::string_view bytes, const std::string& name) {
  return Parser(bytes, name).parse();
}

}  // namespace crg
