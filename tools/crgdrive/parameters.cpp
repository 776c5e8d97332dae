#include "vehicle/parameters.h"

#include <cstdio>

#include "commands.h"

namespace crgdrive {

int parameters() {
  std::fputs(vehicle::describe_parameters().c_str(), stdout);
  return 0;
}

}  // namespace crgdrive
