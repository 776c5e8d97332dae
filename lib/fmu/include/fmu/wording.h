#pragma once

#include "fmu/variables.h"

namespace fmu {

/// "a real number", for messages.
constexpr const char* word(Type type) {
  switch (type) {
    case Type::kReal:
      return "a real number";
    case Type::kInteger:
      return "a whole number";
    case Type::kBoolean:
      return "true or false";
    case Type::kString:
      break;
  }
  return "a text";
}

}  // namespace fmu
