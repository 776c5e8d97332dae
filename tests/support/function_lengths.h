// How long the functions of a C++ source are, by its braces.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace support {

struct FunctionLength {
  std::string name;       ///< as it is defined: "add", "Shape::area", "operator()"
  std::size_t line = 0;   ///< where its signature begins, from 1
  std::size_t lines = 0;  ///< from there to its last brace
};

/// Every function that is defined in a namespace or a class. What stands in a function (lambdas,
/// local classes) is part of it; the lambda that a variable is set to is none. Throws
/// std::runtime_error where braces do not match.
std::vector<FunctionLength> function_lengths(std::string_view source);

}  // namespace support
