#include "base/letters.h"

#include <gtest/gtest.h>

namespace letters_test {

TEST(Letters, NamesAreOneWithoutCaseAndPunctuation) {
  EXPECT_EQ(base::letters_of("GPS Latitude_2 [°]"), "gpslatitude");
  EXPECT_EQ(base::letters_and_digits_of("GPS Latitude_2 [°]"), "gpslatitude2");
  EXPECT_EQ(base::letters_of("@`{[019"), "");
  EXPECT_EQ(base::letters_and_digits_of("/:@`{[019"), "019");
}

}  // namespace letters_test
