#include "fmu/channel_name.h"

#include <utility>
#include <vector>

namespace fmu {
namespace {

constexpr std::pair<std::string_view, std::string_view> kUnits[] = {
    {"s", "s"},   {"m", "m"}, {"rad", "rad"}, {"mps", "m/s"}, {"radps", "rad/s"}, {"mps2", "m/s2"},
    {"pa", "Pa"}, {"n", "N"}, {"nm", "N.m"},  {"k", "K"},     {"kg", "kg"},       {"j", "J"}};

bool is_wheel(std::string_view word) {
  return word == "fl" || word == "fr" || word == "rl" || word == "rr" || word == "*";
}

std::string joined(const std::vector<std::string_view>& words) {
  std::string out;
  for (const std::string_view word : words) out += (out.empty() ? "" : "_") + std::string(word);
  return out;
}

}  // namespace

ChannelName structured_name(std::string_view channel) {
  std::vector<std::string_view> words;
  for (std::string_view rest = channel;;) {
    const std::size_t end = rest.find('_');
    words.push_back(rest.substr(0, end));
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  ChannelName out;
  out.unit = "1";
  for (std::string_view& word : words)
    if (is_wheel(word)) {
      out.of_wheel = true;
      word = "*";
    }
  out.pattern = joined(words);
  if (words.size() > 1)
    for (const auto& [suffix, unit] : kUnits)
      if (words.back() == suffix) {
        out.unit = unit;
        words.pop_back();
        break;
      }
  std::erase(words, "*");
  std::string rest = joined(words);
  if (out.unit == "K") rest += "_temperature";
  if (out.of_wheel && rest == "wheel") rest = "spin";
  out.name = (out.of_wheel ? "wheel.*." : "car.") + rest;
  return out;
}

}  // namespace fmu
