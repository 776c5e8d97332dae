#include "message_types.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace recording {
namespace message_types_test {

TEST(MessageTypes, ReadsFieldsAndLeavesConstantsAndDefaults) {
  const MessageTypes types = parse_message_types(
      "# words\nint32 X=5\nstring S = 'a # b'\nfloat64[3] row # three\nstring<=5 name \"n\"\n"
      "geometry_msgs/msg/Point[] points\nint8[<=2] few\nHeader header\nOther other\n"
      "================\nMSG: a_msgs/Other\nbool on true\n",
      "a_msgs/msg/Root");
  ASSERT_EQ(types.size(), 2u);
  const std::vector<MessageField>& root = types.at("a_msgs/Root");
  ASSERT_EQ(root.size(), 6u);
  EXPECT_EQ(root[0].name, "row");
  EXPECT_EQ(root[0].many, Many::fixed);
  EXPECT_EQ(root[0].count, 3u);
  EXPECT_EQ(root[1].kind, Kind::text);
  EXPECT_EQ(root[2].type, "geometry_msgs/Point");
  EXPECT_EQ(root[2].many, Many::sequence);
  EXPECT_EQ(root[3].many, Many::sequence);
  EXPECT_EQ(root[4].type, "std_msgs/Header");
  EXPECT_EQ(root[5].type, "a_msgs/Other");
  EXPECT_EQ(types.at("a_msgs/Other").front().kind, Kind::boolean);
}

TEST(MessageTypes, RefusesWhatIsNoField) {
  for (const char* text : {"float64", "wstring name", "float64[ x", "IDL: a/msg/B", "int32 x-y"})
    EXPECT_THROW((void)parse_message_types(text, "a/B"), base::Error) << text;
}

TEST(MessageTypes, TheStandardOnesAreWhole) {
  for (const auto& [type, fields] : standard_types()) {
    EXPECT_FALSE(fields.empty()) << type;
    for (const MessageField& field : fields)
      if (field.kind == Kind::nested) {
        EXPECT_TRUE(standard_types().contains(field.type)) << type << ": " << field.type;
      }
  }
  EXPECT_EQ(standard_unit("sensor_msgs/Imu", "angular_velocity"), "rad/s");
  EXPECT_EQ(standard_unit("sensor_msgs/Imu", "orientation"), "");
}

}  // namespace message_types_test
}  // namespace recording
