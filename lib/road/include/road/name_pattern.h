// A pattern that names of objects, materials and textures are looked through for. RE2 stays private
// to the source file.
#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace re2 {
class RE2;
}

namespace road {

/// A regular expression (RE2's syntax: that of ECMAScript without look-ahead and back references),
/// found anywhere in a name, upper and lower case alike, byte by byte. Takes time linear in the
/// name, whatever the pattern.
class NamePattern {
 public:
  /// Throws Error that quotes the pattern.
  explicit NamePattern(const std::string& pattern);
  bool is_in(std::string_view lower_case_name) const;

 private:
  std::shared_ptr<const re2::RE2> pattern_;
};

}  // namespace road
