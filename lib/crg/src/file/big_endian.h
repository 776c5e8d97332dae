// Numbers of a file that has the most significant byte first.
#pragma once

#include <cstddef>
#include <cstdint>

namespace crg {

/// The numbers in order of this machine. False where one of them is greater in magnitude than
/// `most`, infinity included; NaN is not. All `count` numbers are written in either case.
bool take_floats(const char* bytes, std::size_t count, float most, float* to) noexcept;
bool take_doubles(const char* bytes, std::size_t count, double most, double* to) noexcept;

/// take_floats() without AVX2, for the test that compares.
bool take_floats_one_by_one(const char* bytes, std::size_t count, float most, float* to) noexcept;

}  // namespace crg
