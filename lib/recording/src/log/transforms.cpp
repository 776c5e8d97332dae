#include "transforms.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <optional>

namespace recording {
namespace {

constexpr std::size_t kNumbers = 7;  // translation and rotation
constexpr std::size_t kLongestName = 255;
constexpr const char* kPaths[] = {"header.stamp.sec", "header.stamp.nanosec", "translation.x",
                                  "translation.y",    "translation.z",        "rotation.x",
                                  "rotation.y",       "rotation.z",           "rotation.w"};

struct Transform {
  std::uint32_t sec = 0, nanosec = 0;
  std::string_view parent, child;
  double numbers[kNumbers] = {};
};

/// Values one after the other, each at a multiple of its size where they are aligned.
class Bytes {
 public:
  Bytes(std::string_view bytes, Encoding encoding)
      : bytes_(bytes), aligned_(encoding == Encoding::cdr) {
    if (!aligned_) return;
    const bool plain = bytes.size() >= 4 && bytes[0] == 0 && (bytes[1] == 0 || bytes[1] == 1);
    swapped_ = plain && bytes[1] == 0;
    bytes_ = plain ? bytes.substr(4) : std::string_view();
  }

  template <typename T>
  bool take(T& out) {
    const std::size_t at = aligned_ ? (at_ + sizeof(T) - 1) / sizeof(T) * sizeof(T) : at_;
    if (at > bytes_.size() || bytes_.size() - at < sizeof(T)) return false;
    char raw[sizeof(T)];
    std::memcpy(raw, bytes_.data() + at, sizeof(T));
    if (swapped_) std::reverse(std::begin(raw), std::end(raw));
    out = std::bit_cast<T>(raw);
    at_ = at + sizeof(T);
    return true;
  }

  bool take_text(std::string_view& out) {
    std::uint32_t length = 0;
    if (!take(length) || length > bytes_.size() - at_) return false;
    out = bytes_.substr(at_, length);
    at_ += length;
    if (aligned_ && !out.empty()) out.remove_suffix(1);  // the zero behind it
    return true;
  }

 private:
  std::string_view bytes_;
  bool aligned_, swapped_ = false;
  std::size_t at_ = 0;
};

bool take(Bytes& bytes, Encoding encoding, Transform& out) {
  std::uint32_t sequence = 0;
  if (encoding == Encoding::ros1 && !bytes.take(sequence)) return false;
  if (!bytes.take(out.sec) || !bytes.take(out.nanosec) || !bytes.take_text(out.parent) ||
      !bytes.take_text(out.child) || std::max(out.parent.size(), out.child.size()) > kLongestName)
    return false;
  return std::all_of(std::begin(out.numbers), std::end(out.numbers),
                     [&](double& number) { return bytes.take(number); });
}

/// Fields of a type as text, nested ones opened: what its bytes are. Nothing where a type is not
/// known or leads back to itself.
std::optional<std::string> layout_of(const MessageTypes& types, const std::string& type,
                                     int depth = 0) {
  const MessageTypes* known = types.contains(type) ? &types : &standard_types();
  const auto found = known->find(type);
  if (found == known->end() || depth > 8) return std::nullopt;
  std::string out;
  for (const MessageField& field : found->second) {
    out += fmt::format("{} {} {} {}", field.name, static_cast<int>(field.kind),
                       static_cast<int>(field.many), field.count);
    if (field.kind == Kind::nested) {
      const auto inside = layout_of(types, field.type, depth + 1);
      if (!inside || out.size() > 10000) return std::nullopt;
      out += '(' + *inside + ')';
    }
    out += ';';
  }
  return out;
}

}  // namespace

bool is_transforms(const MessageTypes& types, const std::string& root, Encoding encoding) {
  const std::string type = plain_type(root);
  if (type != "tf2_msgs/TFMessage" && type != "tf/tfMessage") return false;
  static const MessageTypes ros2 =
      parse_message_types("geometry_msgs/TransformStamped[] transforms\n", "tf2_msgs/TFMessage");
  static const MessageTypes ros1 = parse_message_types(
      "geometry_msgs/TransformStamped[] transforms\n"
      "================\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n",
      "tf2_msgs/TFMessage");
  const MessageTypes& standard = encoding == Encoding::cdr ? ros2 : ros1;
  const auto seen = types.contains(type) ? layout_of(types, type) : std::nullopt;
  if (!types.contains(type)) return types.empty();
  return seen && *seen == *layout_of(standard, "tf2_msgs/TFMessage");
}

bool Transforms::read(std::uint64_t logged_ns, std::string_view message, Encoding encoding) {
  Bytes bytes(message, encoding);
  std::uint32_t count = 0;
  if (!bytes.take(count)) return false;
  for (std::uint32_t i = 0; i < count; ++i) {
    Transform transform;
    if (!take(bytes, encoding, transform)) return false;
    const auto key = std::make_pair(std::string(transform.parent), std::string(transform.child));
    auto found = pairs_.find(key);
    if (found == pairs_.end()) {
      if (pairs_.size() >= kMostPairs) return false;
      found = pairs_.emplace(key, Pair{}).first;
      for (std::size_t k = 0; k < std::size(kPaths); ++k)
        found->second.slots[k] =
            found->second.topic.slot(kPaths[k], k >= 2 && k < 5 ? std::string_view("m") : "");
    }
    Pair& pair = found->second;
    if (!pair.topic.begin_message(logged_ns)) return true;  // its time is none
    pair.topic.put(pair.slots[0], transform.sec);
    pair.topic.put(pair.slots[1], transform.nanosec);
    for (std::size_t k = 0; k < kNumbers; ++k)
      pair.topic.put(pair.slots[2 + k], transform.numbers[k]);
  }
  return true;
}

std::vector<Topic> Transforms::topics(const std::string& name) && {
  std::vector<Topic> out;
  for (auto& [frames, pair] : pairs_) {
    pair.topic.name = fmt::format("{}.{}.{}", name, frames.first, frames.second);
    out.push_back(std::move(pair.topic));
  }
  return out;
}

}  // namespace recording
