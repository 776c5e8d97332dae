#include "key_kinds.h"

#include <algorithm>
#include <cctype>

#include "base/text_lines.h"
#include "mesh/error.h"

namespace road {

std::string in_quotes(std::string_view text) {
  std::string out = "'";
  for (char c : text.substr(0, 60)) out += static_cast<unsigned char>(c) < 32 ? '?' : c;
  return out + (text.size() > 60 ? "...'" : "'");
}

void refuse(const std::string& seen, const std::string& wanted) {
  throw Error(fmt::format("{} seen, {} wanted", in_quotes(seen), wanted));
}

std::optional<double> parse_number(std::string_view text) {
  const auto value = base::to_number<double>(base::trimmed(text));
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::vector<double> parse_numbers(const std::string& text, std::size_t count, double limit,
                                  const std::string& wanted) {
  std::string_view rest = base::trimmed(text);
  if (rest.starts_with('[') && rest.ends_with(']')) rest = rest.substr(1, rest.size() - 2);
  std::vector<double> values;
  while (true) {
    const std::size_t comma = rest.find(',');
    const auto value = parse_number(rest.substr(0, comma));
    if (!value || std::abs(*value) > limit || values.size() == count) refuse(text, wanted);
    values.push_back(*value);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (values.size() != count) refuse(text, wanted);
  return values;
}

RecipeKey number(std::string stage, std::string name, double low, double high, std::string meaning,
                 const std::function<double&(Recipe&)>& field) {
  std::string wanted = fmt::format("{} to {}", low, high);
  return {std::move(stage),
          std::move(name),
          wanted,
          std::move(meaning),
          false,
          [=](Recipe& recipe, const std::string& text) {
            const auto value = parse_number(text);
            if (!value || *value < low || *value > high) refuse(text, "a number from " + wanted);
            field(recipe) = *value;
          },
          [=](const Recipe& recipe) {
            return fmt::format("{}", field(const_cast<Recipe&>(recipe)));  // only read here
          }};
}

RecipeKey optional_number(std::string stage, std::string name, double low, double high,
                          std::string meaning,
                          const std::function<std::optional<double>&(Recipe&)>& field) {
  RecipeKey key = number(std::move(stage), std::move(name), low, high, std::move(meaning),
                         [=](Recipe& recipe) -> double& {
                           std::optional<double>& value = field(recipe);
                           return value ? *value : value.emplace();
                         });
  key.show = [=](const Recipe& recipe) -> std::string {
    const auto& value = field(const_cast<Recipe&>(recipe));  // only read here
    return value ? fmt::format("{}", *value) : "";
  };
  return key;
}

RecipeKey number_or_automatic(std::string stage, std::string name, double low, double high,
                              std::string meaning,
                              const std::function<std::optional<double>&(Recipe&)>& field) {
  std::string wanted = fmt::format("automatic or {} to {}", low, high);
  return {std::move(stage),
          std::move(name),
          wanted,
          std::move(meaning),
          false,
          [=](Recipe& recipe, const std::string& text) {
            field(recipe).reset();
            if (text == "automatic") return;
            const auto value = parse_number(text);
            if (!value || *value < low || *value > high)
              refuse(text, fmt::format("automatic or a number from {} to {}", low, high));
            field(recipe) = *value;
          },
          [=](const Recipe& recipe) -> std::string {
            const auto& value = field(const_cast<Recipe&>(recipe));  // only read here
            return value ? fmt::format("{}", *value) : "automatic";
          }};
}

RecipeKey yes_or_no(std::string stage, std::string name, std::string meaning,
                    const std::function<bool&(Recipe&)>& field) {
  return {std::move(stage),
          std::move(name),
          "true or false",
          std::move(meaning),
          false,
          [=](Recipe& recipe, const std::string& text) {
            if (text != "true" && text != "false") refuse(text, "true or false");
            field(recipe) = text == "true";
          },
          [=](const Recipe& recipe) -> std::string {
            return field(const_cast<Recipe&>(recipe)) ? "true" : "false";
          }};
}

bool same_word(const std::string& a, const std::string& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char c, unsigned char d) {
    return std::tolower(c) == std::tolower(d);
  });
}

RecipeKey point(std::string stage, std::string name, std::string meaning,
                const std::function<std::optional<Eigen::Vector2d>&(Recipe&)>& field) {
  return {std::move(stage),
          std::move(name),
          "x,y",
          std::move(meaning),
          false,
          [=](Recipe& recipe, const std::string& text) {
            const auto xy = parse_numbers(text, 2, 1e8, "two coordinates x,y in metres");
            field(recipe) = Eigen::Vector2d(xy[0], xy[1]);
          },
          [=](const Recipe& recipe) -> std::string {
            const auto& at = field(const_cast<Recipe&>(recipe));
            return at ? fmt::format("[{}, {}]", at->x(), at->y()) : "";
          }};
}

RecipeKey words(std::string stage, std::string name, std::string values, std::string meaning,
                std::string asked,
                const std::function<std::optional<std::string>&(Recipe&)>& field) {
  return {std::move(stage),
          std::move(name),
          std::move(values),
          std::move(meaning),
          true,
          [=, asked = std::move(asked)](Recipe& recipe, const std::string& text) {
            if (text.empty()) refuse(text, asked);
            field(recipe) = text;
          },
          [=](const Recipe& recipe) {
            return field(const_cast<Recipe&>(recipe)).value_or("");  // only read here
          }};
}

}  // namespace road
