#include "json_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace recording {
namespace json_message_test {

std::map<std::string, double> numbers(const std::string& text, bool good = true) {
  Topic topic;
  topic.begin_message(1);
  EXPECT_EQ(read_json(text, topic), good) << text.substr(0, 80);
  std::map<std::string, double> out;
  for (const Topic::Column& column : topic.columns) out[column.path] = column.values.back();
  return out;
}

TEST(JsonMessage, NamesNumbersByTheWayToThem) {
  using Found = std::map<std::string, double>;
  EXPECT_EQ(numbers(R"({"a": 1.5, "b": {"c": [true, null, "x", -3]}, )"
                    R"("d": [[1], {"e": 2}], "f": {}, "g": 18446744073709551615})"),
            (Found{{"a", 1.5},
                   {"b.c.0", 1},
                   {"b.c.3", -3},
                   {"d.0.0", 1},
                   {"d.1.e", 2},
                   {"g", 18446744073709551616.0}}));
  EXPECT_EQ(numbers("7"), (Found{{"", 7}}));
  EXPECT_EQ(numbers("[7, 8]"), (Found{{"0", 7}, {"1", 8}}));
  EXPECT_EQ(numbers(R"({"a": 1, "a": 2})"), (Found{{"a", 2}}));
}

TEST(JsonMessage, SaysWhatIsNoJson) {
  for (const char* text : {"", "{", R"({"a": 1)", "{'a': 1}", "1 2", "nan", R"({"a": 1e999})"})
    (void)numbers(text, false);
}

TEST(JsonMessage, DepthAndLengthHaveAnEnd) {
  EXPECT_TRUE(numbers(std::string(100000, '[') + "1" + std::string(100000, ']')).empty());
  EXPECT_EQ(numbers(R"({"deep": )" + std::string(1000, '[') + "1" + std::string(1000, ']') +
                    R"(, "after": 3})")
                .at("after"),
            3);
  EXPECT_EQ(numbers("{\"" + std::string(5000, 'x') + "\": 1, \"y\": 2}").size(), 1u);
  std::string many = "[0";
  for (int k = 1; k < 5000; ++k) many += "," + std::to_string(k);
  EXPECT_EQ(numbers(many + "]").size(), kMostElements + 1);
}

}  // namespace json_message_test
}  // namespace recording
