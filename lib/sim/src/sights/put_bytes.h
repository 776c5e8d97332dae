// Values as the bytes that they are in memory.
#pragma once

#include <string>

namespace sim {

template <class... Values>
void put(std::string& bytes, const Values&... values) {
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
}

}  // namespace sim
