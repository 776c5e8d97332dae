// The car of a vehicle file behind the same functions as a unit's: what the unit of crgdrive fmu
// has in its binary, linked in. Private to lib/sim.
#pragma once

#include <cmath>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/error.h"
#include "fmu/instance.h"
#include "sim/unit_description.h"
#include "unit_library.h"

namespace sim {

struct OwnCar {
  Log* log = nullptr;

  static fmu::Instance& of(void* instance) { return *static_cast<fmu::Instance*>(instance); }

  /// What is thrown becomes a line of the log, as in a unit.
  template <class Work>
  Status guarded(const Work& work) const {
    try {
      const std::string remark = work();
      if (remark.empty()) return 0;
      log->add(remark.c_str());
      return kWarning;
    } catch (const std::exception& error) {
      log->add(error.what());
    }
    return kError;
  }
  template <class Work>
  Status done(const Work& work) const {
    return guarded([&] {
      work();
      return std::string();
    });
  }

  void* make(const std::string& resources, const UnitDescription& description, Log& to) {
    log = &to;
    std::unique_ptr<fmu::Instance> made;
    done([&] { made = std::make_unique<fmu::Instance>(resources, description.token); });
    return made.release();
  }
  void release(void* instance) const {
    guarded([&] { return of(instance).closing_remark(); });
    delete static_cast<fmu::Instance*>(instance);
  }
  Status terminate(void* instance) const {
    return done([&] { of(instance).terminate(); });
  }
  Status reset(void* instance) const {
    guarded([&] { return of(instance).closing_remark(); });
    return done([&] { of(instance).reset(); });
  }

  Status get_state(void* instance, void** state) const {
    return done([&] {
      auto saved = std::make_unique<fmu::SavedState>(of(instance).save());
      if (*state == nullptr)
        *state = saved.release();
      else
        *static_cast<fmu::SavedState*>(*state) = std::move(*saved);
    });
  }
  Status set_state(void* instance, void* state) const {
    return done([&] { of(instance).restore(*static_cast<const fmu::SavedState*>(state)); });
  }
  static Status free_state(void*, void** state) {
    delete static_cast<fmu::SavedState*>(*state);
    *state = nullptr;
    return 0;
  }

  Status initialise(void* instance, double start_s, const std::optional<double>&,
                    const std::optional<double>&) const {
    return done([&] {
      of(instance).enter_initialisation(start_s);
      of(instance).leave_initialisation();
    });
  }
  Status step(void* instance, double time_s, double step_s, bool&) const {
    return done([&] { of(instance).step(time_s, step_s); });
  }

  Status access(void* instance, const UnitVariable& v, std::span<double> values,
                bool writes) const {
    const fmu::Type type = v.type == ValueType::float64   ? fmu::Type::kReal
                           : v.type == ValueType::boolean ? fmu::Type::kBoolean
                                                          : fmu::Type::kInteger;
    return guarded([&]() -> std::string {
      if (writes)
        return of(instance).set_number(
            v.reference, type, type == fmu::Type::kReal ? values[0] : std::nearbyint(values[0]));
      values[0] = of(instance).number(v.reference, type);
      return {};
    });
  }
  Status write_text(void* instance, const UnitVariable& v, const char* text) const {
    return done([&] { of(instance).set_text(v.reference, text); });
  }
  Status read_text(void* instance, const UnitVariable& v, const char*& text) const {
    return done([&] { text = of(instance).text(v.reference).c_str(); });
  }
};

}  // namespace sim
