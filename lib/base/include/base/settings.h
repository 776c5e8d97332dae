// Settings from a YAML file: words, lists and keys with values, each with its line.
#pragma once

#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace base {

/// A node of the file.
struct Setting {
  enum class Kind { kNothing, kWord, kList, kKeys } kind = Kind::kNothing;
  std::string word;               ///< kWord
  std::vector<std::string> keys;  ///< kKeys: keys[i] belongs to values[i], each once
  std::vector<Setting> values;    ///< kKeys, kList
  int line = 0;                   ///< from 1
};

/// Reads a YAML file of at most a megabyte and 100,000 nodes. Throws Error with file:line on syntax
/// errors, keys that are no words, a key twice.
Setting read_settings(const std::string& path);

/// Keys and values of which only some are known; every complaint has file and line.
class Section {
 public:
  /// `name` is what messages call it. Throws Error when the node has no keys.
  Section(const Setting& node, std::string path, const std::string& name);

  std::string where(const Setting& node) const;
  void allow(std::initializer_list<std::string_view> keys) const;
  const Setting* find(std::string_view key) const;
  bool has(std::string_view key) const { return find(key) != nullptr; }
  /// The word of a key. Throws Error when it is missing or no word.
  std::string text(std::string_view key) const;
  /// The number of a key, `otherwise` where the key is missing. Throws Error outside [low, high].
  double number(std::string_view key, double otherwise, double low, double high) const;
  /// A list of exactly `count` finite numbers; empty where the key is missing.
  std::vector<double> numbers(std::string_view key, std::size_t count) const;
  /// A list of words; empty where the key is missing.
  std::vector<std::string> words(std::string_view key) const;
  bool flag(std::string_view key, bool otherwise) const;  ///< true or false
  Section section(std::string_view key) const;
  /// Calls f(key, value, "file:line") for every entry.
  void for_each(
      const std::function<void(const std::string&, const Setting&, const std::string&)>& f) const;
  const std::string& path() const { return path_; }

 private:
  const Setting& need(std::string_view key) const;
  const Setting* node_;
  std::string path_, name_;
};

/// A finite number. Throws Error naming `where` and `what`.
double to_number(std::string_view text, const std::string& where, std::string_view what);

}  // namespace base
