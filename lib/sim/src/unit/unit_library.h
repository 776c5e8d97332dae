// The binary of a unit, and what both versions of the standard share.
#pragma once

#include <dlfcn.h>
#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/one_line.h"

namespace sim {

using Reference = std::uint32_t;
using Status = int;  // OK 0, Warning 1, Discard 2, Error 3, Fatal 4, Pending 5
constexpr Status kWarning = 1, kError = 3;

/// What a unit said, for messages; units may log from threads of their own.
struct Log {
  std::function<void(const std::string&, bool closes)> take;
  std::atomic<bool> closes = false;  ///< a run of the unit ends
  std::string last;
  std::mutex mutex;

  void add(const char* text) {
    const std::lock_guard lock(mutex);
    last = base::one_line(text == nullptr ? "" : text);
    if (take) take(last, closes);
  }
};

/// The functions of a binary.
class Library {
 public:
  Library(const std::string& path, std::string unit)
      : unit_(std::move(unit)), handle_(::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (handle_ != nullptr) return;
    const char* const why = ::dlerror();
    throw base::Error(fmt::format("{}: its binary cannot be loaded: {}", unit_,
                                  why == nullptr ? "no reason given" : why));
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  ~Library() { ::dlclose(handle_); }

  template <class Function>
  void find(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(handle_, name));
    if (function == nullptr) missing_ += (missing_.empty() ? "" : ", ") + std::string(name);
  }
  void want_all() const {
    if (!missing_.empty())
      throw base::Error(unit_ + ": its binary lacks functions of the standard: " + missing_);
  }

 private:
  std::string unit_, missing_;
  void* handle_;
};

/// Into the unit's type and back; `call` gets a pointer to values of that type.
template <class Value, class Call>
Status with_copy(std::span<double> values, bool writes, const Call& call) {
  const std::unique_ptr<Value[]> copy(new Value[values.size()]());
  if (writes)
    for (std::size_t i = 0; i < values.size(); ++i)
      copy[i] = static_cast<Value>(std::is_floating_point_v<Value> ? values[i]
                                                                   : std::nearbyint(values[i]));
  const Status status = call(copy.get());
  if (!writes)
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(copy[i]);
  return status;
}

}  // namespace sim
