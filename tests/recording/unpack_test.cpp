#include "unpack.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "support/mcap_file.h"

namespace recording {
namespace unpack_test {

std::string unpacked(const std::string& packer, const std::string& bytes, std::size_t most) {
  try {
    return packer == "zstd" ? unpack_zstd(bytes, most) : unpack_lz4(bytes, most);
  } catch (const base::Error& error) {
    return error.what();
  }
}

TEST(Unpack, GivesBackWhatWasPacked) {
  std::string text;
  for (int k = 0; k < 100000; ++k) text += std::to_string(k * k) + ' ';
  for (const char* packer : {"zstd", "lz4"}) {
    const std::string packed = support::packed(text, packer);
    EXPECT_TRUE(unpacked(packer, packed, text.size()) == text) << packer;
    EXPECT_TRUE(unpacked(packer, packed + packed, 2 * text.size()) == text + text)
        << packer;  // frames in a row
    EXPECT_EQ(unpacked(packer, support::packed("", packer), 0), "");
    EXPECT_EQ(unpacked(packer, "", 0), "");
  }
  EXPECT_TRUE(is_zstd(support::packed(text, "zstd")));
  EXPECT_FALSE(is_zstd(text));
}

TEST(Unpack, RefusesWhatIsDamagedOrHoldsTooMuch) {
  const std::string bomb(std::size_t{50} << 20, '\0');
  for (const char* packer : {"zstd", "lz4"}) {
    const std::string packed = support::packed(bomb, packer);
    EXPECT_THAT(unpacked(packer, packed, 1000), testing::HasSubstr("more than")) << packer;
    EXPECT_THAT(unpacked(packer, packed.substr(0, packed.size() / 2), bomb.size()),
                testing::HasSubstr("cut off"))
        << packer;
    EXPECT_THAT(unpacked(packer, "no such thing", 1000), testing::HasSubstr("packed by")) << packer;
  }
}

TEST(Unpack, AllPartsTogetherHaveABound) {
  EXPECT_EQ(most_unpacked(4000), (std::size_t{16} << 20) + 4000000);
  EXPECT_EQ(most_unpacked(std::size_t{1} << 40), std::size_t{8} << 30);
}

}  // namespace unpack_test
}  // namespace recording
