// Keys of a recipe by what they hold: a number, a choice, a point ... Private to the recipe.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "make/recipe.h"

namespace road {

/// Text from a file as it may be shown in one line of an error.
std::string in_quotes(std::string_view text);

/// Throws Error: what was seen, what was wanted.
[[noreturn]] void refuse(const std::string& seen, const std::string& wanted);

/// A finite number, blanks around it allowed.
std::optional<double> parse_number(std::string_view text);

/// "1, 2" or "[1, 2]": exactly `count` numbers of at most `limit`.
std::vector<double> parse_numbers(const std::string& text, std::size_t count, double limit,
                                  const std::string& wanted);

RecipeKey number(std::string stage, std::string name, double low, double high, std::string meaning,
                 const std::function<double&(Recipe&)>& field);

RecipeKey number_or_automatic(std::string stage, std::string name, double low, double high,
                              std::string meaning,
                              const std::function<std::optional<double>&(Recipe&)>& field);

/// A number that need not be given.
RecipeKey optional_number(std::string stage, std::string name, double low, double high,
                          std::string meaning,
                          const std::function<std::optional<double>&(Recipe&)>& field);

RecipeKey yes_or_no(std::string stage, std::string name, std::string meaning,
                    const std::function<bool&(Recipe&)>& field);

RecipeKey point(std::string stage, std::string name, std::string meaning,
                const std::function<std::optional<Eigen::Vector2d>&(Recipe&)>& field);

/// A path or a name; `asked` is what an empty one is answered with.
RecipeKey words(std::string stage, std::string name, std::string values, std::string meaning,
                std::string asked,
                const std::function<std::optional<std::string>&(Recipe&)>& field);

/// In any case: KRBI and krbi.
bool same_word(const std::string& a, const std::string& b);

template <class Integer>
RecipeKey whole_number(std::string stage, std::string name, std::uint64_t low, std::uint64_t high,
                       std::string meaning,
                       const std::function<std::vector<Integer*>(Recipe&)>& fields) {
  std::string wanted = fmt::format("{} to {}", low, high);
  return {std::move(stage),
          std::move(name),
          wanted,
          std::move(meaning),
          false,
          [=](Recipe& recipe, const std::string& text) {
            const auto value = parse_number(text);
            if (!value || *value < static_cast<double>(low) || *value > static_cast<double>(high) ||
                *value != std::floor(*value))
              refuse(text, "a whole number from " + wanted);
            for (Integer* field : fields(recipe)) *field = static_cast<Integer>(*value);
          },
          [=](const Recipe& recipe) {
            return fmt::format("{}", *fields(const_cast<Recipe&>(recipe)).front());
          }};
}

template <class Enum>
RecipeKey choice(std::string stage, std::string name,
                 std::vector<std::pair<std::string, Enum>> choices, std::string meaning,
                 const std::function<Enum&(Recipe&)>& field) {
  std::string wanted = choices.front().first;
  for (std::size_t i = 1; i < choices.size(); ++i)
    wanted += (i + 1 == choices.size() ? " or " : ", ") + choices[i].first;
  return {std::move(stage),
          std::move(name),
          wanted,
          std::move(meaning),
          true,
          [=](Recipe& recipe, const std::string& text) {
            for (const auto& [word, value] : choices)
              if (same_word(word, text)) return void(field(recipe) = value);
            refuse(text, wanted);
          },
          [=](const Recipe& recipe) -> std::string {
            for (const auto& [word, value] : choices)
              if (value == field(const_cast<Recipe&>(recipe))) return word;
            return {};
          }};
}

}  // namespace road
