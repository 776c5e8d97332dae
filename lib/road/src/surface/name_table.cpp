#include "name_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "mesh/error.h"
#include "road/clean.h"

namespace road {
namespace {

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

NameTable::NameTable(const std::vector<NameRule>& rules, const std::string& convention) {
  for (std::size_t k = 0; k < rules.size(); ++k) {
    const NameRule& rule = rules[k];
    if (!rule.convention.empty() && rule.convention != convention) continue;
    try {
      compiled_.push_back({k, rule.field, rule.surface_class, NamePattern(rule.pattern), {}});
    } catch (const Error& error) {
      throw Error(fmt::format("name rule {}", error.what()));
    }
  }
}

const NameTable::Rule* NameTable::match(const MeshObject& object) {
  const std::array<std::string, 3> text{lower_case(object.name), lower_case(object.material),
                                        lower_case(object.texture)};
  for (Rule& rule : compiled_) {
    const std::string& subject = text[static_cast<std::size_t>(rule.field)];
    if (subject.empty()) continue;
    bool matches = false;
    if (rule.field == NameRule::Field::object) {
      matches = rule.pattern.is_in(subject);
    } else {
      const auto [known, inserted] = rule.answers.try_emplace(subject, false);
      if (inserted) known->second = rule.pattern.is_in(subject);
      matches = known->second;
    }
    if (matches) return &rule;
  }
  return nullptr;
}

std::optional<SurfaceClass> NameTable::class_of(const MeshObject& object) {
  const Rule* rule = match(object);
  return rule != nullptr ? std::optional(rule->surface_class) : std::nullopt;
}

std::optional<std::size_t> NameTable::rule_of(const MeshObject& object) {
  const Rule* rule = match(object);
  return rule != nullptr ? std::optional(rule->place) : std::nullopt;
}

std::string convention_of(const std::vector<MeshObject>& objects,
                          const std::vector<NameRule>& rules) {
  std::vector<std::string> conventions;
  for (const NameRule& rule : rules) {
    if (!rule.convention.empty() &&
        std::find(conventions.begin(), conventions.end(), rule.convention) == conventions.end()) {
      conventions.push_back(rule.convention);
    }
  }
  for (const std::string& convention : conventions) {
    NameTable table(rules, convention);
    for (const MeshObject& object : objects) {
      if (table.class_of(object) == SurfaceClass::road) return convention;
    }
  }
  return {};
}

std::vector<std::optional<std::size_t>> rules_of(const std::vector<MeshObject>& objects,
                                                 const std::vector<NameRule>& rules) {
  NameTable table(rules, convention_of(objects, rules));
  std::vector<std::optional<std::size_t>> out;
  out.reserve(objects.size());
  for (const MeshObject& object : objects) out.push_back(table.rule_of(object));
  return out;
}

MeshReadOptions read_to_clean(MeshReadOptions read, const CleanOptions& options) {
  if (options.use_names == UseNames::no) return read;
  read.want_colours = [rules = options.name_rules](const std::vector<MeshObject>& objects) {
    NameTable table(rules, convention_of(objects, rules));
    return std::none_of(objects.begin(), objects.end(), [&](const MeshObject& object) {
      return table.class_of(object) == SurfaceClass::road;
    });
  };
  return read;
}

// What names of objects, materials and textures say about their class.
std::vector<NameRule> default_name_rules() {
  using enum NameRule::Field;
  using enum SurfaceClass;
  const auto torcs = [](NameRule::Field field, const char* pattern, SurfaceClass surface_class) {
    return NameRule{field, pattern, surface_class, "torcs"};
  };
  const auto assetto = [](const char* pattern, SurfaceClass surface_class) {
    return NameRule{object, pattern, surface_class, "assetto corsa"};
  };
  const auto words = [](NameRule::Field field, const char* pattern, SurfaceClass surface_class) {
    return NameRule{field, pattern, surface_class, "words"};
  };
  return {
      // Trees and boards first: most objects are of these, and the first match decides.
      torcs(object, "^(obj|tree|trib|pub|poutre|box|rect|poly|roue|toptent)", scenery),
      torcs(object, R"(^(b[0-9r][lr]t|p\d+ts|s[0-9t]bg))", barrier),
      torcs(object, "^terr", scenery),
      torcs(texture, "wall|barr|fence|armco|pylon", barrier),
      torcs(object, "^tkmn", road),
      torcs(object, "^[tx]k[lr]s", runoff),
      torcs(texture, "kerb|curb|^rmbl|^rsa", kerb),
      torcs(object, R"(^[tx]\d[lr]b)", runoff),
      // Surfaces that count are numbered: "1ROAD", "12KERB".
      assetto(R"(^\d+(road|asph|pit|conc))", road),
      assetto(R"(^\d+(kerb|curb))", kerb),
      assetto(R"(^\d+(grass|sand|gravel|runoff|dirt|turf))", runoff),
      assetto(R"(^\d+(wall|fence|armco|barr))", barrier),
      // Plain words, rFactor's four-letter ones among them. Scenery and walls by the object's name
      // first; else the
      // material tells more than the object: one object "track" may hold grass, asphalt and painted
      // lines.
      words(object,
            "(^|[^a-z])(tree|bush|forest|crowd|stand|grandstand|gantry|building|house|sign|board|"
            "light|car|tent|sky|terrain|hill|mountain)",
            scenery),
      words(object, "(^|[^a-z])(wall|fence|barrier|armco|guard|tyre|tire|cone|pylon)", barrier),
      words(material,
            "(^|[^a-z])(tree|bush|forest|crowd|stand|gantry|building|house|sign|board|leaf|leaves|"
            "trunk|sky|terrain)",
            scenery),
      words(material, "(^|[^a-z])(wall|fence|barrier|armco|guard|tyre|tire)", barrier),
      words(material, "(^|[^a-z])(kerb|curb|rmbl|rumble)", kerb),
      words(material, "(^|[^a-z])(road|track)[_-]?side", runoff),
      words(material, "(^|[^a-z])(road|asphalt|tarmac|rdap)", road),
      words(material, "(^|[^a-z])(run_?-?off|grass|grss|gravel|grav|sand|verge|shoulder|dirt|cemt)",
            runoff),
      words(object, "(^|[^a-z])(kerb|curb|rmbl|rumble)", kerb),
      words(object, "(^|[^a-z])(road|track)[_-]?side", runoff),
      words(object, "(^|[^a-z])(road|asphalt|tarmac|track|rdap|racingsurface|pitlane)", road),
      words(object,
            "(^|[^a-z])(run_?-?off|grass|grss|gravel|grav|sand|verge|shoulder|dirt|concrete|cemt)",
            runoff),
  };
}

}  // namespace road
