// The file of a summary: what was written is read, everything else is refused in one line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/archive.h"
#include "explain/summary.h"
#include "synthetic_drive.h"
#include "vehicle/error.h"

namespace explain {
namespace summary_file_test {

using ::testing::HasSubstr;

DriveSummary small() {
  DriveSummary out = explain_test::synthetic_drive(
      {.knots = 4, .car_parameters = 1, .car_mechanisms = 1, .sensors = 1}, {.name = "car"}, 3);
  out.columns[0].unit = "m/s²";
  return out;
}

/// With the check that fits.
std::string checked(std::string bytes) {
  const std::uint64_t check = base::checksum(bytes);
  bytes.append(reinterpret_cast<const char*>(&check), 8);
  return bytes;
}

void expect_refused(const std::string& bytes, const std::string& why) {
  try {
    summary_from_bytes(bytes, "x.summary");
    FAIL() << why;
  } catch (const vehicle::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("x.summary: "));
    EXPECT_THAT(error.what(), HasSubstr(why));
  }
}

TEST(SummaryFile, WhatWasWrittenIsRead) {
  const DriveSummary written = small();
  EXPECT_EQ(summary_from_bytes(to_bytes(written), "x.summary"), written);
}

TEST(SummaryFile, EveryCutAndEveryChangedByteIsRefused) {
  const std::string bytes = to_bytes(small());
  for (std::size_t size = 0; size < bytes.size(); size += 7)
    EXPECT_THROW(summary_from_bytes(bytes.substr(0, size), "x"), vehicle::Error) << size;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 0x10);
    EXPECT_THROW(summary_from_bytes(changed, "x"), vehicle::Error) << at;
  }
}

TEST(SummaryFile, ForeignFilesAndVersionsAreNamed) {
  expect_refused("time_s,x_m\n", "no summary of a drive");
  std::string bytes = to_bytes(small());
  const std::size_t version = bytes.find('\n') + 1;
  bytes[version] = 3;
  expect_refused(bytes, "version 3 seen, 2 wanted");
}

TEST(SummaryFile, CountsThatTheBytesDoNotPayForTakeNoMemory) {
  DriveSummary s = small();
  const std::string bytes = to_bytes(s);
  const std::string payload = bytes.substr(0, bytes.size() - 8);
  std::string length(8, '\0');
  std::memcpy(length.data(), &s.length_m, 8);
  const std::size_t knots_at = payload.find(length) + 8 + 1, columns_at = knots_at + 4 + 4 + 8;
  const auto with = [&](std::size_t at, std::uint32_t number) {
    std::string more = payload;
    std::memcpy(more.data() + at, &number, 4);
    return checked(more);
  };
  expect_refused(with(knots_at, kMostKnots), "sums seen");
  expect_refused(with(knots_at, kMostKnots + 1), "121 knots seen, 4 to 120 wanted");
  expect_refused(with(columns_at, 0xFFFFFFFFu), "cut short");
  s.columns.resize(kMostSummaryColumns + 1);
  expect_refused(to_bytes(s), "401 columns seen");
  expect_refused(checked(payload + "more"), "more bytes seen than wanted");
}

TEST(SummaryFile, NumbersThatAreNoneAreRefused) {
  DriveSummary s = small();
  s.by_forces.right[3] = NAN;
  expect_refused(to_bytes(s), "no finite number");
  s = small();
  s.by_forces.among[0] = -1;
  expect_refused(to_bytes(s), "negative");
  s = small();
  s.columns[0].deviation = 0;
  expect_refused(to_bytes(s), "deviation of 0 seen");
  s = small();
  s.car = "two\nlines";
  expect_refused(to_bytes(s), "control characters");
}

}  // namespace summary_file_test
}  // namespace explain
