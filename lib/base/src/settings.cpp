#include "base/settings.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "base/error.h"
#include "base/read_file.h"

namespace base {
namespace {

constexpr std::size_t kLargestFileBytes = 1u << 20, kMostNodes = 100000, kDeepest = 64;

/// Copies a node; anchors that repeat each other are counted as often as they stand for something,
/// and one that holds itself is too deep.
Setting copy(const YAML::Node& node, const std::string& path, std::size_t& count,
             std::size_t depth = 0) {
  Setting out;
  out.line = node.Mark().line + 1;
  const auto where = [&] { return fmt::format("{}:{}", path, out.line); };
  if (++count > kMostNodes)
    throw Error(
        fmt::format("{}: more than {} entries; no such file is that long", where(), kMostNodes));
  if (depth > kDeepest)
    throw Error(
        fmt::format("{}: more than {} lists and tables within each other", where(), kDeepest));
  if (node.IsScalar()) {
    out.kind = Setting::Kind::kWord;
    out.word = node.Scalar();
  } else if (node.IsSequence()) {
    out.kind = Setting::Kind::kList;
    for (const auto& item : node) out.values.push_back(copy(item, path, count, depth + 1));
  } else if (node.IsMap()) {
    out.kind = Setting::Kind::kKeys;
    std::set<std::string> seen;
    for (const auto& entry : node) {
      const int line = entry.first.Mark().line + 1;
      if (!entry.first.IsScalar())
        throw Error(fmt::format("{}:{}: a key that is no word", path, line));
      if (!seen.insert(entry.first.Scalar()).second)
        throw Error(
            fmt::format("{}:{}: '{}' twice", path, line, entry.first.Scalar().substr(0, 60)));
      out.keys.push_back(entry.first.Scalar());
      out.values.push_back(copy(entry.second, path, count, depth + 1));
      out.values.back().line = line;
    }
  }
  return out;
}

}  // namespace

double to_number(std::string_view text, const std::string& where, std::string_view what) {
  double value = 0.0;
  std::string_view digits = text;
  if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value))
    throw Error(fmt::format("{}: {} = '{}', wanted a finite number", where, what.substr(0, 60),
                            text.substr(0, 40)));
  return value;
}

Setting read_settings(const std::string& path) {
  const std::string text = base::read_file(path, kLargestFileBytes);
  std::size_t count = 0;
  try {
    return copy(YAML::Load(text), path, count);
  } catch (const YAML::Exception& error) {
    throw Error(fmt::format("{}:{}: no YAML: {}", path, error.mark.line + 1, error.msg));
  }
}

Section::Section(const Setting& node, std::string path, const std::string& name)
    : node_(&node), path_(std::move(path)), name_(name.substr(0, 60)) {
  if (node.line == 0) throw Error(fmt::format("{}: is empty, wanted {}", path_, name_));
  if (node.kind != Setting::Kind::kKeys)
    throw Error(fmt::format("{}: {} is not a list of keys and values", where(node), name_));
}

std::string Section::where(const Setting& node) const {
  return fmt::format("{}:{}", path_, node.line);
}

void Section::allow(std::initializer_list<std::string_view> keys) const {
  for (std::size_t i = 0; i < node_->keys.size(); ++i)
    if (std::find(keys.begin(), keys.end(), node_->keys[i]) == keys.end())
      throw Error(fmt::format("{}: '{}' is not a key of {}; wanted one of: {}",
                              where(node_->values[i]), node_->keys[i].substr(0, 60), name_,
                              fmt::join(keys.begin(), keys.end(), ", ")));
}

const Setting* Section::find(std::string_view key) const {
  const auto found = std::find(node_->keys.begin(), node_->keys.end(), key);
  return found == node_->keys.end()
             ? nullptr
             : &node_->values[static_cast<std::size_t>(found - node_->keys.begin())];
}

const Setting& Section::need(std::string_view key) const {
  const Setting* const value = find(key);
  if (value == nullptr) throw Error(fmt::format("{}: {} lacks '{}'", where(*node_), name_, key));
  return *value;
}

std::string Section::text(std::string_view key) const {
  const Setting& value = need(key);
  if (value.kind != Setting::Kind::kWord)
    throw Error(fmt::format("{}: '{}' is not one word", where(value), key));
  return value.word;
}

double Section::number(std::string_view key, double otherwise, double low, double high) const {
  if (!has(key)) return otherwise;
  const double value = to_number(text(key), where(need(key)), key);
  if (!(value >= low && value <= high))
    throw Error(
        fmt::format("{}: {} = {}, wanted {} to {}", where(need(key)), key, value, low, high));
  return value;
}

std::vector<double> Section::numbers(std::string_view key, std::size_t count) const {
  std::vector<double> out;
  if (!has(key)) return out;
  for (const std::string& word : words(key)) out.push_back(to_number(word, where(need(key)), key));
  if (out.size() != count)
    throw Error(fmt::format("{}: '{}' has {} numbers, wanted {}", where(need(key)), key, out.size(),
                            count));
  return out;
}

std::vector<std::string> Section::words(std::string_view key) const {
  std::vector<std::string> out;
  const Setting* const value = find(key);
  if (value == nullptr) return out;
  if (value->kind != Setting::Kind::kList)
    throw Error(fmt::format("{}: '{}' is not a list", where(*value), key));
  for (const Setting& item : value->values) {
    if (item.kind != Setting::Kind::kWord)
      throw Error(fmt::format("{}: '{}' holds more than words", where(*value), key));
    out.push_back(item.word);
  }
  return out;
}

bool Section::flag(std::string_view key, bool otherwise) const {
  if (!has(key)) return otherwise;
  const std::string word = text(key);
  if (word != "true" && word != "false")
    throw Error(fmt::format("{}: {} = '{}', wanted true or false", where(need(key)), key,
                            word.substr(0, 40)));
  return word == "true";
}

Section Section::section(std::string_view key) const {
  return Section(need(key), path_, std::string(key));
}

void Section::for_each(
    const std::function<void(const std::string&, const Setting&, const std::string&)>& f) const {
  for (std::size_t i = 0; i < node_->keys.size(); ++i)
    f(node_->keys[i], node_->values[i], where(node_->values[i]));
}

}  // namespace base
