// One value of each type that is asked for: what a stage has for itself, and a recipe or a summary
// only carries.
#pragma once

#include <any>
#include <map>
#include <typeindex>

namespace road {

class ByType {
 public:
  /// As it was left; at first what its default constructor makes.
  template <class T>
  T& of() {
    std::any& value = values_[typeid(T)];
    if (!value.has_value()) value = T{};
    return *std::any_cast<T>(&value);
  }

  template <class T>
  const T& of() const {
    static const T untouched{};
    const auto found = values_.find(typeid(T));
    return found == values_.end() ? untouched : *std::any_cast<T>(&found->second);
  }

 private:
  std::map<std::type_index, std::any> values_;
};

}  // namespace road
