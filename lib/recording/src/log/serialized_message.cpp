#include "serialized_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "base/error.h"

namespace recording {
namespace {

constexpr std::size_t kDeepestType = 32;
constexpr std::size_t kMostParts = 4 * kMostFields;

/// Bytes of a value; 0: of what has no size of its own.
std::size_t size_of(Kind kind) {
  switch (kind) {
    case Kind::boolean:
    case Kind::int8:
    case Kind::uint8:
      return 1;
    case Kind::int16:
    case Kind::uint16:
      return 2;
    case Kind::int32:
    case Kind::uint32:
    case Kind::float32:
      return 4;
    case Kind::int64:
    case Kind::uint64:
    case Kind::float64:
      return 8;
    default:
      return 0;
  }
}

class Layer {
 public:
  Layer(const MessageTypes& types, MessageWay& way, Topic& topic)
      : types_(types), way_(way), topic_(topic) {}

  /// Appends the steps of a type, with channels below `path`.
  void lay(const std::string& type, const std::string& path, std::string_view unit,
           std::size_t depth, std::vector<Step>& out) {
    want_depth(type, depth);
    if (++parts_ > kMostParts)
      throw base::Error(fmt::format("a message has more than {} parts", kMostParts));
    const std::vector<MessageField>& fields = fields_of(type);
    if (fields.empty() && way_.encoding == Encoding::cdr)
      out.push_back({});  // one byte for nothing
    for (const MessageField& field : fields) {
      const std::string here = path.empty() ? field.name : path + '.' + field.name;
      const std::string_view own = standard_unit(type, field.name);
      lay_field(field, here, own.empty() ? unit : own, depth, out);
    }
    if (out.size() > kMostParts)
      throw base::Error(fmt::format("a message has more than {} parts", kMostParts));
  }

 private:
  static void want_depth(const std::string& type, std::size_t depth) {
    if (depth > kDeepestType)
      throw base::Error(fmt::format("type {} is nested more than {} deep", type, kDeepestType));
  }

  const std::vector<MessageField>& fields_of(const std::string& type) const {
    for (const MessageTypes* types : {&types_, &standard_types()})
      if (const auto found = types->find(type); found != types->end()) return found->second;
    throw base::Error(fmt::format("type {} is not described", type));
  }

  void lay_field(const MessageField& field, const std::string& path, std::string_view unit,
                 std::size_t depth, std::vector<Step>& out) {
    const bool few =
        field.many == Many::one || (field.many == Many::fixed && field.count <= kMostElements);
    if (field.kind == Kind::nested && few) {
      for (std::size_t i = 0; i < field.count; ++i)
        lay(field.type, field.many == Many::one ? path : fmt::format("{}.{}", path, i), unit,
            depth + 1, out);
      return;
    }
    Step step;
    step.kind = field.kind;
    step.many = field.many;
    step.count = field.count;
    if (field.kind == Kind::nested) step.way = way_of(field.type, depth);
    if (field.kind != Kind::nested && field.kind != Kind::text) {
      if (few) step.slot = slots_of(field, path, unit);
      if (field.many == Many::sequence && field.kind != Kind::time) step.path = path;
    }
    out.push_back(std::move(step));
  }

  std::size_t slot_of(const std::string& path, std::string_view unit) {
    const std::size_t slot = topic_.slot(path, unit);
    if (slot == Topic::kNone)
      throw base::Error(fmt::format("a message has more than {} numbers", kMostFields));
    return slot;
  }

  /// The first of the slots, which follow one another (a time has two).
  std::size_t slots_of(const MessageField& field, const std::string& path, std::string_view unit) {
    const std::size_t first = topic_.columns.size();
    for (std::size_t i = 0; i < field.count; ++i) {
      const std::string element = field.many == Many::one ? path : fmt::format("{}.{}", path, i);
      if (field.kind == Kind::time) {
        slot_of(element + ".sec", "s");
        slot_of(element + ".nsec", "");
      } else {
        slot_of(element, unit);
      }
    }
    if (topic_.columns.size() != first + field.count * (field.kind == Kind::time ? 2 : 1))
      throw base::Error(fmt::format("field '{}' twice", path));
    return first;
  }

  /// The way through a type that repeats: no channels.
  std::size_t way_of(const std::string& type, std::size_t depth) {
    if (const auto found = repeated_.find(type); found != repeated_.end()) return found->second;
    want_depth(type, depth);
    const std::size_t index = way_.ways.size();
    repeated_.emplace(type, index);
    way_.ways.emplace_back();
    std::vector<Step> steps;
    const std::vector<MessageField>& fields = fields_of(type);
    if (fields.empty() && way_.encoding == Encoding::cdr) steps.push_back({});
    for (const MessageField& field : fields) {
      Step step{field.kind, field.many, field.count, 0, Topic::kNone, "", {}};
      if (field.kind == Kind::nested) step.way = way_of(field.type, depth + 1);
      steps.push_back(std::move(step));
    }
    way_.ways[index] = std::move(steps);
    return index;
  }

  const MessageTypes& types_;
  MessageWay& way_;
  Topic& topic_;
  std::size_t parts_ = 0;
  std::unordered_map<std::string, std::size_t> repeated_;
};

class Walk {
 public:
  Walk(std::string_view bytes, MessageWay& way, Topic& topic)
      : bytes_(bytes), way_(way), topic_(topic) {}

  bool go() {
    if (way_.encoding == Encoding::cdr && !read_encapsulation()) return false;
    return walk(0, 0);
  }

 private:
  bool read_encapsulation() {
    if (bytes_.size() < 4 || bytes_[0] != 0) return false;
    if (bytes_[1] != 0 && bytes_[1] != 1) return false;  // plain CDR, big- or little-endian
    swapped_ = bytes_[1] == 0;
    bytes_.remove_prefix(4);
    return true;
  }

  bool align(std::size_t size) {
    if (way_.encoding == Encoding::ros1) return true;
    at_ = (at_ + size - 1) / size * size;
    return at_ <= bytes_.size();
  }

  bool skip(std::size_t count) {
    if (count > bytes_.size() - at_) return false;
    at_ += count;
    return true;
  }

  template <class T>
  T take() {
    char raw[sizeof(T)];
    std::memcpy(raw, bytes_.data() + at_, sizeof(T));
    if (swapped_) std::reverse(std::begin(raw), std::end(raw));
    at_ += sizeof(T);
    return std::bit_cast<T>(raw);
  }

  bool count(std::size_t& out) {
    if (!align(4) || bytes_.size() - at_ < 4) return false;
    out = take<std::uint32_t>();
    return true;
  }

  /// A value whose bytes are there.
  double number(Kind kind) {
    switch (kind) {
      case Kind::boolean:
      case Kind::uint8:
        return take<std::uint8_t>();
      case Kind::int8:
        return take<std::int8_t>();
      case Kind::int16:
        return take<std::int16_t>();
      case Kind::uint16:
        return take<std::uint16_t>();
      case Kind::int32:
        return take<std::int32_t>();
      case Kind::uint32:
        return take<std::uint32_t>();
      case Kind::float32:
        return static_cast<double>(take<float>());
      case Kind::int64:
        return static_cast<double>(take<std::int64_t>());
      case Kind::uint64:
        return static_cast<double>(take<std::uint64_t>());
      default:
        return take<double>();
    }
  }

  std::size_t slot(Step& step, std::size_t element) {
    if (step.slot != Topic::kNone) return step.slot + element;
    if (step.path.empty() || element >= kMostElements) return Topic::kNone;
    if (element == step.elements.size())
      step.elements.push_back(topic_.slot(fmt::format("{}.{}", step.path, element)));
    return step.elements[element];
  }

  bool numbers(Step& step, std::size_t count) {
    const std::size_t size = size_of(step.kind);
    if (count == 0) return true;
    if (!align(size) || count > (bytes_.size() - at_) / size) return false;
    const bool wanted = step.slot != Topic::kNone || (!step.path.empty() && count <= kMostElements);
    if (!wanted) return skip(count * size);
    for (std::size_t i = 0; i < count; ++i) topic_.put(slot(step, i), number(step.kind));
    return true;
  }

  bool times(const Step& step, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      if (!align(4) || bytes_.size() - at_ < 8) return false;
      const double sec = take<std::uint32_t>(), nsec = take<std::uint32_t>();
      if (step.slot == Topic::kNone) continue;
      topic_.put(step.slot + 2 * i, sec);
      topic_.put(step.slot + 2 * i + 1, nsec);
    }
    return true;
  }

  bool texts(std::size_t count) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < count; ++i)
      if (!this->count(length) || !skip(length)) return false;
    return true;
  }

  /// Nothing that is there has more parts than bytes, but types without fields (ROS 1).
  bool walk(std::size_t way, std::size_t depth) {
    if (depth > kDeepestType || ++walked_ > bytes_.size() + kMostParts) return false;
    for (Step& step : way_.ways[way]) {
      std::size_t many = step.count;
      if (step.many == Many::sequence && !count(many)) return false;
      if (step.kind == Kind::text) {
        if (!texts(many)) return false;
      } else if (step.kind == Kind::time) {
        if (!times(step, many)) return false;
      } else if (step.kind != Kind::nested) {
        if (!numbers(step, many)) return false;
      } else {
        for (std::size_t i = 0; i < many; ++i)
          if (!walk(step.way, depth + 1)) return false;
      }
    }
    return true;
  }

  std::string_view bytes_;
  MessageWay& way_;
  Topic& topic_;
  std::size_t at_ = 0, walked_ = 0;
  bool swapped_ = false;
};

}  // namespace

MessageWay lay_way(const MessageTypes& types, const std::string& root, Encoding encoding,
                   Topic& topic) {
  MessageWay out;
  out.encoding = encoding;
  out.ways.emplace_back();
  std::vector<Step> steps;
  Layer(types, out, topic).lay(plain_type(root), "", "", 0, steps);
  out.ways.front() = std::move(steps);
  return out;
}

bool read_serialized(std::string_view bytes, MessageWay& way, Topic& topic) {
  return Walk(bytes, way, topic).go();
}

}  // namespace recording
