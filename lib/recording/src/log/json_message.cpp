#include "json_message.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace recording {
namespace {

using nlohmann::json;

constexpr std::size_t kDeepestValue = 32, kLongestPath = 500;

/// Follows the way through a text as nlohmann's reader walks it.
class Numbers : public nlohmann::json_sax<json> {
 public:
  explicit Numbers(Topic& topic) : topic_(topic) {}

  bool null() override { return word(); }
  bool boolean(bool value) override { return number(value ? 1.0 : 0.0); }
  bool number_integer(number_integer_t value) override {
    return number(static_cast<double>(value));
  }
  bool number_unsigned(number_unsigned_t value) override {
    return number(static_cast<double>(value));
  }
  bool number_float(number_float_t value, const string_t&) override { return number(value); }
  bool string(string_t&) override { return word(); }
  bool binary(binary_t&) override { return word(); }
  bool start_object(std::size_t) override { return begin(false); }
  bool key(string_t& name) override {
    if (followed()) enter(name);
    return true;
  }
  bool end_object() override { return end(); }
  bool start_array(std::size_t) override { return begin(true); }
  bool end_array() override { return end(); }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
    return false;
  }

 private:
  struct Level {
    bool array;
    std::size_t length;   ///< of the path to it
    std::size_t element;  ///< of an array: the next one
  };

  bool followed() const { return depth_ == levels_.size(); }
  bool short_enough() const { return path_.size() < kLongestPath; }

  void enter(std::string_view part) {
    path_.resize(levels_.empty() ? 0 : levels_.back().length);
    if (!path_.empty()) path_ += '.';
    path_ += part;
  }

  /// An element begins: in an array it names itself. False: beyond what is taken.
  bool element() {
    if (levels_.empty() || !levels_.back().array) return true;
    Level& level = levels_.back();
    if (level.element > kMostElements) return false;
    enter(std::to_string(level.element++));
    return true;
  }

  bool number(double value) {
    if (!followed() || !element() || !short_enough()) return true;
    const std::size_t slot = topic_.slot_near(next_, path_);
    topic_.put(slot, value);
    next_ = slot + 1;
    return true;
  }

  bool word() {
    if (followed()) element();
    return true;
  }

  bool begin(bool array) {
    const bool here = followed() && element() && depth_ < kDeepestValue && short_enough();
    ++depth_;
    if (here) levels_.push_back({array, path_.size(), 0});
    return true;
  }

  bool end() {
    if (depth_ == levels_.size()) {
      path_.resize(levels_.back().length);
      levels_.pop_back();
    }
    --depth_;
    return true;
  }

  Topic& topic_;
  std::string path_;
  std::vector<Level> levels_;  ///< of those that are followed
  std::size_t depth_ = 0;      ///< of all
  std::size_t next_ = 0;
};

}  // namespace

bool read_json(std::string_view text, Topic& topic) {
  Numbers numbers(topic);
  return json::sax_parse(text.begin(), text.end(), &numbers);
}

}  // namespace recording
