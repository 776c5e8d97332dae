#include "name_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "mesh/error.h"

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

}  // namespace road
