// What both versions of the standard's functions put around an instance: its log and its saved
// states. No exception leaves; a null or a stranger is an error, not a crash.
#pragma once

#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/one_line.h"
#include "fmu/instance.h"

namespace fmu {

/// As in the standard, both versions.
enum class Status { kOk = 0, kWarning = 1, kDiscard = 2, kError = 3 };

using Log = std::function<void(Status, const std::string&)>;

struct Component {
  std::unique_ptr<Instance> instance;
  Log log;
  std::vector<std::unique_ptr<SavedState>> saved;
  double begin_s = 0.0;  ///< FMI 2 says it before initialisation
};

/// Null, with a line in the log, where it cannot be.
inline Component* make_component(const std::string& folder, const std::string& token, Log log) {
  try {
    auto made = std::make_unique<Component>();
    made->instance = std::make_unique<Instance>(folder, token);
    made->log = std::move(log);
    return made.release();
  } catch (const std::exception& error) {
    log(Status::kError, base::one_line(error.what()));
  } catch (...) {
    log(Status::kError, "the unit cannot be made");
  }
  return nullptr;
}

/// Does `work`, which returns a Status, and makes a line of what it throws.
template <class Work>
Status guarded(void* component, const Work& work) noexcept {
  if (component == nullptr) return Status::kError;
  Component& c = *static_cast<Component*>(component);
  try {
    try {
      return work(c);
    } catch (const std::exception& error) {
      c.log(Status::kError, base::one_line(error.what()));
    }
  } catch (...) {  // not even that line can be made
  }
  return Status::kError;
}

inline void want(bool holds, const char* what) {
  if (!holds) throw base::Error(what);
}

/// Passes a remark on.
inline Status told(Component& c, const std::string& remark) {
  if (remark.empty()) return Status::kOk;
  c.log(Status::kWarning, remark);
  return Status::kWarning;
}

/// Before the run that there was is over.
inline void close_run(Component& c) { told(c, c.instance->closing_remark()); }

/// A copy of the state in *handle, which is one of ours or null.
inline Status keep_state(Component& c, void** handle) {
  want(handle != nullptr, "no place for the state was given");
  auto state = std::make_unique<SavedState>(c.instance->save());
  const auto old = std::find_if(c.saved.begin(), c.saved.end(),
                                [&](const auto& s) { return s.get() == *handle; });
  if (old != c.saved.end()) {
    **old = std::move(*state);
    return Status::kOk;
  }
  want(*handle == nullptr, "the state to be written over is none of this unit");
  c.saved.push_back(std::move(state));
  *handle = c.saved.back().get();
  return Status::kOk;
}

inline const SavedState& kept_state(Component& c, const void* handle) {
  const auto found = std::find_if(c.saved.begin(), c.saved.end(),
                                  [&](const auto& s) { return s.get() == handle; });
  want(found != c.saved.end(), "this state is none of this unit, or was freed");
  return **found;
}

inline Status free_state(Component& c, void** handle) {
  // An importer in wide use gives the state itself in place of where it keeps it.
  const auto is_given = [&](const auto& s) { return s.get() == static_cast<void*>(handle); };
  if (std::erase_if(c.saved, is_given) > 0) return Status::kOk;
  if (handle == nullptr || *handle == nullptr) return Status::kOk;
  (void)kept_state(c, *handle);
  std::erase_if(c.saved, [&](const auto& s) { return s.get() == *handle; });
  *handle = nullptr;
  return Status::kOk;
}

inline Status state_size(Component& c, const void* handle, std::size_t* size) {
  want(size != nullptr, "no place for the size was given");
  *size = to_bytes(kept_state(c, handle), c.instance->token()).size();
  return Status::kOk;
}

inline Status write_state(Component& c, const void* handle, char* out, std::size_t size) {
  want(out != nullptr, "no place for the bytes was given");
  const std::string bytes = to_bytes(kept_state(c, handle), c.instance->token());
  want(size >= bytes.size(), "the place for the bytes is too small");
  std::copy(bytes.begin(), bytes.end(), out);
  return Status::kOk;
}

inline Status read_state(Component& c, const char* bytes, std::size_t size, void** handle) {
  want(bytes != nullptr && handle != nullptr, "no bytes or no place for the state were given");
  c.saved.push_back(std::make_unique<SavedState>(
      from_bytes(std::string_view(bytes, size), c.instance->token(), c.instance->list())));
  *handle = c.saved.back().get();
  return Status::kOk;
}

}  // namespace fmu
