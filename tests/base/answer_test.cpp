#include "base/answer.h"

#include <gtest/gtest.h>

#include <memory>

namespace answer_test {

base::Answer<int> half(const int& number) {
  if (number % 2 != 0) return base::Refusal("odd\nnumber");
  return number / 2;
}

TEST(Answer, IsAValueOrWhyThereIsNone) {
  EXPECT_EQ(*half(8), 4);
  EXPECT_FALSE(half(7));
  EXPECT_EQ(half(7).refusal().message, "odd number");
}

TEST(Answer, ARefusalIsThrownAsWhatItIs) {
  EXPECT_EQ(half(8).or_throw(), 4);
  try {
    (void)half(7).or_throw();
    ADD_FAILURE();
  } catch (const base::NotUsable&) {
    ADD_FAILURE();
  } catch (const base::Error& error) {
    EXPECT_STREQ(error.what(), "odd number");
  }
  EXPECT_THROW(base::Answer<int>(base::Refusal("no road", true)).or_throw(), base::NotUsable);
}

TEST(Answer, OneLeadsToTheNext) {
  EXPECT_EQ(*half(8).and_then(half), 2);
  EXPECT_EQ(half(6).and_then(half).refusal().message, "odd number");
  EXPECT_EQ(half(7)
                .and_then([](const int&) -> base::Answer<std::string> {
                  ADD_FAILURE() << "nothing to go on from";
                  return std::string();
                })
                .refusal()
                .message,
            "odd number");
}

TEST(Answer, ToTakeWhatIsNotThereIsAFault) {
  EXPECT_THROW((void)*half(7), std::bad_variant_access);
  EXPECT_THROW((void)half(8).refusal(), std::bad_variant_access);
}

TEST(Answer, MovesWhatCannotBeCopied) {
  base::Answer<std::unique_ptr<int>> answer(std::make_unique<int>(3));
  const std::unique_ptr<int> taken = *std::move(answer);
  EXPECT_EQ(*taken, 3);
}

}  // namespace answer_test
