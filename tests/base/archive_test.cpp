#include "base/archive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace archive_test {

using base::ArchiveKind;
using base::ArchiveReader;
using base::ArchiveWriter;
using ::testing::HasSubstr;

constexpr ArchiveKind kThings{"things of a test", 3};

enum class Colour : std::uint8_t { red = 1, blue = 7 };

struct Part {
  std::string name;
  std::optional<std::array<float, 3>> colour;
  bool operator==(const Part&) const = default;
};
template <class Archive, class Value>
requires std::is_same_v<std::remove_const_t<Value>, Part>
void fields(Archive& archive, Value& part) { archive(part.name, part.colour); }

struct Things {
  double number = 0.0;
  bool mark = false;
  Colour colour = Colour::red;
  std::array<std::string, 2> texts;
  std::vector<std::array<std::uint32_t, 3>> triples;
  std::vector<Part> parts;
  std::map<std::string, std::size_t> counts;
  bool operator==(const Things&) const = default;
};
template <class Archive, class Value>
requires std::is_same_v<std::remove_const_t<Value>, Things>
void fields(Archive& archive, Value& t) {
  archive(t.number, t.mark, t.colour, t.texts, t.triples, t.parts, t.counts);
}

Things some() {
  return {0.1,
          true,
          Colour::blue,
          {"one", ""},
          {{1, 2, 3}, {4, 5, 6}},
          {{"road", std::array{0.1f, 0.2f, 0.3f}}, {"kerb", std::nullopt}},
          {{"kept", 12}, {"dropped", 3}}};
}

std::string bytes_of(const auto&... values) {
  ArchiveWriter out(kThings);
  out(values...);
  return out.finish();
}

/// With the checksum that its bytes want.
std::string mended(std::string bytes) {
  bytes.resize(bytes.size() - 8);
  const std::uint64_t sum = base::checksum(bytes);
  bytes.append(reinterpret_cast<const char*>(&sum), 8);
  return bytes;
}

template <class T>
std::string problem(std::string_view bytes, T value = {}) {
  ArchiveReader in(bytes, kThings);
  in(value);
  return in.finish() ? "taken" : in.problem();
}

TEST(Archive, WhatWasPutIsTaken) {
  const std::string bytes = bytes_of(some());
  EXPECT_THAT(bytes, ::testing::StartsWith("things of a test\n"));
  ArchiveReader in(bytes, kThings);
  Things back;
  in(back);
  EXPECT_TRUE(in.finish()) << in.problem();
  EXPECT_EQ(back, some());
  EXPECT_EQ(bytes_of(back), bytes);
}

TEST(Archive, EveryCutAndEveryChangedBitIsRefused) {
  const std::string bytes = bytes_of(some());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_NE(problem<Things>(bytes.substr(0, size)), "taken") << size;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string changed = bytes;
    changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
    EXPECT_NE(problem<Things>(changed), "taken") << bit;
  }
}

TEST(Archive, SaysWhatItIsNot) {
  const std::string bytes = bytes_of(some());
  EXPECT_THAT(problem<Things>("x_m,y_m\n"), HasSubstr("does not begin with 'things of a test'"));
  std::string newer = bytes;
  ++newer[17];
  EXPECT_EQ(problem<Things>(newer), "version 4 seen, 3 wanted");
  EXPECT_THAT(problem<Things>(bytes.substr(0, 40)), HasSubstr("damaged or cut short"));
  EXPECT_THAT(problem<Things>(mended(bytes + "more")), HasSubstr("more bytes seen than wanted"));
  EXPECT_THAT(problem<Things>(bytes_of(1.0)), HasSubstr("fewer bytes seen than wanted"));
  EXPECT_THAT(problem<bool>(bytes_of(std::uint8_t{2})), HasSubstr("a mark of 2 seen, 0 or 1"));
}

// Counts whose bytes are not there: of numbers, texts, structs and maps.
TEST(Archive, MakesNoMoreRoomThanTheBytesPayFor) {
  const std::string bytes = bytes_of(std::uint32_t{0xFFFFFFFF}, std::string(100, 'x'));
  EXPECT_THAT(problem<std::vector<double>>(bytes), HasSubstr("fewer bytes"));
  EXPECT_THAT(problem<std::string>(bytes), HasSubstr("fewer bytes"));
  EXPECT_THAT(problem<std::vector<Part>>(bytes), HasSubstr("fewer bytes"));
  const std::string few = bytes_of(std::uint32_t{60}, std::string(100, 'x'));
  EXPECT_THAT(problem<std::vector<Part>>(few), HasSubstr("fewer bytes"));
  using Counts = std::map<std::string, std::size_t>;
  EXPECT_THAT(problem<Counts>(few), HasSubstr("fewer bytes"));
}

TEST(Archive, AfterAProblemValuesKeepWhatTheyHave) {
  const std::string bytes = bytes_of(1.5);
  ArchiveReader in(bytes, kThings);
  double first = 0.0, second = 2.5;
  std::string text = "kept";
  std::vector<int> list{1, 2};
  in(first, second, text, list);
  EXPECT_EQ(first, 1.5);
  EXPECT_EQ(second, 2.5);
  EXPECT_EQ(text, "kept");
  EXPECT_THAT(list, ::testing::ElementsAre(1, 2));
  EXPECT_FALSE(in.finish());
}

}  // namespace archive_test
