#include "serialized_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "support/mcap_file.h"

namespace recording {
namespace serialized_message_test {

using support::raw;

double value(const Topic& topic, const std::string& path) {
  for (const Topic::Column& column : topic.columns)
    if (column.path == path && !column.values.empty()) return column.values.back();
  return std::nan("");
}

/// Reads one message of a type p/Root.
bool read(const std::string& text, const std::string& bytes, Topic& topic,
          Encoding encoding = Encoding::cdr) {
  MessageWay way = lay_way(parse_message_types(text, "p/Root"), "p/Root", encoding, topic);
  topic.begin_message(1);
  return read_serialized(bytes, way, topic);
}

const std::string kLittle("\0\1\0\0", 4), kBig("\0\0\0\0", 4);

TEST(SerializedMessage, AlignsByTheStartOfTheBody) {
  Topic topic;
  const std::string bytes = kLittle + "\7" + std::string(7, '\xee') + raw(2.5) +
                            raw(std::uint16_t{9}) + std::string(2, '\xee') + raw(-4);
  EXPECT_TRUE(read("uint8 a\nfloat64 b\nuint16 c\nint32 d", bytes, topic));
  EXPECT_EQ(value(topic, "a"), 7);
  EXPECT_EQ(value(topic, "b"), 2.5);
  EXPECT_EQ(value(topic, "c"), 9);
  EXPECT_EQ(value(topic, "d"), -4);
}

TEST(SerializedMessage, ReadsBigEndian) {
  Topic topic;
  const std::string bytes =
      kBig + std::string("\x3f\x80\0\0", 4) + std::string("\1\2\0\0\xff\xff\xff\xfe", 8);
  EXPECT_TRUE(read("float32 a\nuint16 b\nint32 c", bytes, topic));
  EXPECT_EQ(value(topic, "a"), 1.0);
  EXPECT_EQ(value(topic, "b"), 258);
  EXPECT_EQ(value(topic, "c"), -2);
}

TEST(SerializedMessage, ReadsRos1WithoutAlignment) {
  Topic topic;
  const std::string bytes = raw(7u) + raw(10u) + raw(500u) + support::counted("map") + "\1" +
                            raw(1.5) + raw(2u) + raw(1.0f) + raw(2.0f);
  EXPECT_TRUE(
      read("Header header\nbool on\nfloat64 x\nfloat32[] row\n====\nMSG: std_msgs/Header\nuint32 "
           "seq\ntime stamp\nstring frame_id",
           bytes, topic, Encoding::ros1));
  EXPECT_EQ(value(topic, "header.seq"), 7);
  EXPECT_EQ(value(topic, "header.stamp.sec"), 10);
  EXPECT_EQ(value(topic, "header.stamp.nsec"), 500);
  EXPECT_EQ(value(topic, "x"), 1.5);
  EXPECT_EQ(value(topic, "row.1"), 2);
}

TEST(SerializedMessage, WalksOverLongArraysAndNestedSequences) {
  Topic topic;
  const std::string bytes = kLittle + std::string(100, '\1') + raw(2u) + raw(2u) +
                            std::string("a\0\0\0", 4) + raw(5u) + raw(2u) +
                            std::string("b\0\0\0", 4) + raw(6u) + raw(42);
  EXPECT_TRUE(
      read("uint8[100] image\nItem[] items\nint32 last\n====\nMSG: p/Item\nstring name\nuint32 id",
           bytes, topic));
  ASSERT_EQ(topic.columns.size(), 1u);
  EXPECT_EQ(value(topic, "last"), 42);
}

TEST(SerializedMessage, StopsWhereTheBytesEnd) {
  const auto whole = [](const std::string& text, const std::string& bytes,
                        Encoding encoding = Encoding::cdr) {
    Topic topic;
    return read(text, bytes, topic, encoding);
  };
  EXPECT_FALSE(whole("float64[2] a", kLittle + raw(1.0) + raw(1.0f)));
  EXPECT_FALSE(whole("uint8[] many", kLittle + raw(0xffffffffu)));
  EXPECT_FALSE(whole("string text", kLittle + raw(0xffffffffu)));
  EXPECT_FALSE(whole("Nothing[] many\n====\nMSG: p/Nothing\n", kLittle + raw(0xffffffffu)));
  EXPECT_FALSE(whole("Nothing[] many\n====\nMSG: p/Nothing\n", raw(0xffffffffu), Encoding::ros1));
  EXPECT_FALSE(whole("uint8 a", ""));
  EXPECT_FALSE(whole("uint8 a", std::string("\0\2\0\0\1", 5)));  // parameter lists
}

TEST(SerializedMessage, RefusesTypesWithoutEnd) {
  const auto refused = [](const std::string& text, Encoding encoding = Encoding::cdr) {
    Topic topic;
    try {
      (void)lay_way(parse_message_types(text, "p/Root"), "p/Root", encoding, topic);
    } catch (const base::Error& error) {
      return std::string(error.what());
    }
    return std::string("laid");
  };
  EXPECT_THAT(refused("Root again"), testing::HasSubstr("nested more than"));
  EXPECT_THAT(refused("Root[60] again"), testing::HasSubstr("nested more than"));
  EXPECT_THAT(refused("Missing x"), testing::HasSubstr("p/Missing is not described"));
  EXPECT_THAT(refused("float64 x\nfloat64 x"), testing::HasSubstr("twice"));
  std::string tree = "A0[64] a";
  for (int k = 0; k < 20; ++k)
    tree += "\n====\nMSG: p/A" + std::to_string(k) + "\nA" + std::to_string(k + 1) + "[64] a";
  tree += "\n====\nMSG: p/A20\n";
  EXPECT_THAT(refused(tree), testing::HasSubstr("parts"));
  EXPECT_THAT(refused(tree, Encoding::ros1), testing::HasSubstr("parts"));
  EXPECT_EQ(refused("Root[] again"), "laid");
}

}  // namespace serialized_message_test
}  // namespace recording
