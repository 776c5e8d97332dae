#pragma once

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/error.h"
#include "base/one_line.h"

namespace base {

/// Why there is no value, in the words that an Error would have.
struct Refusal {
  explicit Refusal(std::string_view why, bool is_not_usable = false)
      : message(one_line(why)), not_usable(is_not_usable) {}

  std::string message;
  bool not_usable;  ///< what was given can be read: NotUsable, else Error
};

/// A value, or the reason why there is none. For what can be counted on to happen and what others
/// decide by; an exception is a fault, and nothing is decided by one. To take the value where there
/// is none is a fault too (std::bad_variant_access).
template <class T>
class [[nodiscard]] Answer {
 public:
  Answer(T value) : held_(std::in_place_index<0>, std::move(value)) {}
  Answer(Refusal refusal) : held_(std::in_place_index<1>, std::move(refusal)) {}

  explicit operator bool() const { return held_.index() == 0; }
  const T& operator*() const& { return std::get<0>(held_); }
  T& operator*() & { return std::get<0>(held_); }
  T&& operator*() && { return std::get<0>(std::move(held_)); }
  const T* operator->() const { return &std::get<0>(held_); }
  T* operator->() { return &std::get<0>(held_); }
  const Refusal& refusal() const { return std::get<1>(held_); }

  /// What `next` answers for the value; where there is none, why.
  template <class Next>
  std::invoke_result_t<const Next&, const T&> and_then(const Next& next) const {
    if (!*this) return refusal();
    return next(**this);
  }

  /// For those who have no other road to take.
  T or_throw() && {
    if (*this) return std::get<0>(std::move(held_));
    if (refusal().not_usable) throw NotUsable(refusal().message);
    throw Error(refusal().message);
  }

 private:
  std::variant<T, Refusal> held_;
};

}  // namespace base
