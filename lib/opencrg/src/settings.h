// Options of contact points and modifiers of data sets, as the C API numbers them.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "crg/file.h"
#include "crgBaseLib.h"

namespace opencrg {

/// One option or modifier that the interface knows.
struct Setting {
  unsigned int id;
  const char* key;    ///< in the sections of a file
  const char* words;  ///< in messages
  bool as_int, as_double;
};

std::span<const Setting> options();
std::span<const Setting> modifiers();
/// nullptr for an id of neither.
const Setting* find_setting(unsigned int id);

/// What is set. Numbers and what they are set to; setting refuses what the interface refuses.
class Settings {
 public:
  bool set_int(unsigned int id, int value);
  bool set_double(unsigned int id, double value);  ///< no zones of smoothing <= 0, no NaN
  bool get_int(unsigned int id, int& value) const;
  bool get_double(unsigned int id, double& value) const;
  bool remove(unsigned int id);
  void clear() { set_ = {}; }
  bool has(unsigned int id) const { return id < set_.size() && set_[id]; }
  double value_or(unsigned int id, double otherwise) const {
    return has(id) ? values_[id] : otherwise;
  }
  /// Takes from a file's section what `known` lists.
  void take(const std::vector<crg::HeaderEntry>& entries, std::span<const Setting> known);
  /// The section of a file that says the same.
  std::vector<crg::HeaderEntry> entries(std::span<const Setting> known) const;
  /// One message per value, at level notice.
  void print(const char* what) const;

 private:
  std::array<bool, dCrgSizeOptList + 1> set_ = {};
  std::array<double, dCrgSizeOptList + 1> values_ = {};
};

Settings default_options();
Settings default_modifiers();

}  // namespace opencrg
