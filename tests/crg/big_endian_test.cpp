// Numbers of a file, most significant byte first: the same bits whatever the processor can do.
#include "big_endian.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace crg {
namespace big_endian_test {

// Bytes as the format has them, written here digit by digit.
template <typename Word>
std::string bytes_of(const std::vector<Word>& words) {
  std::string bytes;
  for (const Word word : words) {
    for (std::size_t k = sizeof word; k-- > 0;)
      bytes.push_back(static_cast<char>((word >> (8 * k)) & 0xFFU));
  }
  return bytes;
}

TEST(BigEndian, FloatsOfAnyBitsAndNumberAreTakenAsTheyAre) {
  std::mt19937 random(5);
  for (std::size_t count = 0; count < 40; ++count) {
    std::vector<std::uint32_t> words(count);
    for (std::uint32_t& word : words) word = static_cast<std::uint32_t>(random());
    const std::string bytes = " " + bytes_of(words);  // not aligned
    std::vector<float> fast(count), plain(count);
    const bool fast_bounded = take_floats(bytes.data() + 1, count, 1e9F, fast.data());
    const bool plain_bounded = take_floats_one_by_one(bytes.data() + 1, count, 1e9F, plain.data());
    EXPECT_EQ(fast_bounded, plain_bounded) << count;
    for (std::size_t c = 0; c < count; ++c) {
      EXPECT_EQ(std::bit_cast<std::uint32_t>(fast[c]), words[c]);
      EXPECT_EQ(std::bit_cast<std::uint32_t>(plain[c]), words[c]);
    }
  }
}

TEST(BigEndian, OneNumberBeyondTheBoundIsSeenWhereverItStands) {
  const float infinity = std::numeric_limits<float>::infinity();
  for (std::size_t place = 0; place < 19; ++place) {
    for (const float value : {1e9F, -1e9F, NAN, std::nextafter(1e9F, infinity), -2e9F, infinity}) {
      std::vector<std::uint32_t> words(19, std::bit_cast<std::uint32_t>(-3.5F));
      words[place] = std::bit_cast<std::uint32_t>(value);
      const bool within = std::isnan(value) || std::abs(value) == 1e9F;
      std::vector<float> to(19);
      EXPECT_EQ(take_floats(bytes_of(words).data(), 19, 1e9F, to.data()), within) << value;
      EXPECT_EQ(take_floats_one_by_one(bytes_of(words).data(), 19, 1e9F, to.data()), within);
      std::vector<std::uint64_t> wide(19, std::bit_cast<std::uint64_t>(-3.5));
      wide[place] = std::bit_cast<std::uint64_t>(static_cast<double>(value));
      std::vector<double> doubles(19);
      EXPECT_EQ(take_doubles(bytes_of(wide).data(), 19, 1e9, doubles.data()), within) << value;
      EXPECT_EQ(doubles[(place + 1) % 19], -3.5);
    }
  }
}

}  // namespace big_endian_test
}  // namespace crg
