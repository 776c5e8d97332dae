#include "report/mean_colour.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "report/picture.h"
#include "support/coloured_ring.h"

namespace mean_colour_test {

using ::testing::HasSubstr;

std::array<double, 3> mean_of(std::string_view bytes) {
  std::size_t left = report::kMostPixels;
  return report::mean_colour(bytes, left);
}

std::string refusal_of(std::string_view bytes, std::size_t left = report::kMostPixels) {
  try {
    report::mean_colour(bytes, left);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(MeanColour, IsThatOfTheLight) {
  // Half of it black, half white: half of the light, which is coded as 188 and not as 128.
  const std::vector<std::uint8_t> pixels{0, 0, 0, 255, 255, 255};
  const auto mean = mean_of(report::encode_png(2, 1, pixels));
  for (const double channel : mean) EXPECT_NEAR(channel, 0.5, 1e-9);
  EXPECT_NEAR(report::linear_light(188.0), 0.5, 0.005);
}

TEST(MeanColour, LeavesOutWhatIsTransparent) {
  const std::vector<std::uint8_t> leaf{255, 0, 0, 255, 0, 255, 0, 0};
  const auto mean = mean_of(report::encode_png(2, 1, leaf));
  EXPECT_DOUBLE_EQ(mean[0], 1.0);
  EXPECT_DOUBLE_EQ(mean[1], 0.0);
  const std::vector<std::uint8_t> nothing{255, 0, 0, 0, 0, 255, 0, 0};
  EXPECT_THAT(refusal_of(report::encode_png(2, 1, nothing)), HasSubstr("without anything"));
}

TEST(MeanColour, OfAJpegIsThatOfTheSamePng) {
  for (const support::Rgb& rgb : {support::kAsphalt, support::kGrass, support::kEarth}) {
    const auto png = mean_of(support::png_of(rgb, 12, 61)),
               jpeg = mean_of(support::jpeg_of(rgb, 12, 61));
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(jpeg[k], png[k], 0.005);
      EXPECT_NEAR(png[k], report::linear_light(rgb[k]), 0.005);
    }
  }
}

TEST(MeanColour, OfWhatIsNoPictureOrDamagedIsRefused) {
  EXPECT_THAT(refusal_of(""), HasSubstr("no PNG or JPEG"));
  EXPECT_THAT(refusal_of("DDS |and so on"), HasSubstr("no PNG or JPEG"));
  for (const std::string& picture :
       {support::png_of(support::kGrass), support::jpeg_of(support::kGrass)})
    for (std::size_t k = 1; k < 40; ++k)
      EXPECT_NE(refusal_of(std::string_view(picture).substr(0, picture.size() * k / 40)), "") << k;
}

TEST(MeanColour, LooksAtTheSizeFirst) {
  std::string png = support::png_of(support::kGrass), jpeg = support::jpeg_of(support::kGrass);
  for (std::size_t k = 16; k < 24; ++k) png[k] = '\x7f';
  EXPECT_THAT(refusal_of(png), HasSubstr("pixels; wanted at most"));
  const std::size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  for (std::size_t k = 5; k < 9; ++k) jpeg[frame + k] = '\xfe';
  EXPECT_THAT(refusal_of(jpeg), HasSubstr("pixels; wanted at most"));
}

TEST(MeanColour, CountsThePixelsOfAllPictures) {
  std::size_t left = 2500;
  const std::string png = support::png_of(support::kGrass, 12, 40);
  report::mean_colour(png, left);
  EXPECT_EQ(left, 900u);
  EXPECT_THROW(report::mean_colour(png, left), std::invalid_argument);
  const std::string small = support::png_of(support::kGrass, 12, 30);
  std::string damaged = small;
  damaged.resize(damaged.size() - 40);
  EXPECT_THROW(report::mean_colour(damaged, left), std::invalid_argument);
  EXPECT_EQ(left, 0u) << "time was spent on it";
}

}  // namespace mean_colour_test
