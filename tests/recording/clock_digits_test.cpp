#include "clock_digits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace recording {
namespace clock_digits_test {

/// A clock of 1,000 rows, 0.05 s apart, as `digits` makes them of seconds of the day.
template <class Digits>
Channel clock_of_digits(double first_s, const Digits& digits) {
  Channel clock{"Time", "", 0.0, {}, 0};
  for (int i = 0; i < 1000; ++i) clock.values.push_back(digits(first_s + 0.05 * i));
  return clock;
}

/// Which seconds a mended clock shows from its first row on; the notes go to `notes`.
void want_steps_of(double step, Channel& clock, std::vector<std::string>& notes) {
  mend_clock_digits(clock, notes);
  for (std::size_t i = 1; i < clock.values.size(); ++i)
    ASSERT_NEAR(clock.values[i] - clock.values[0], step * static_cast<double>(i), 1e-5) << i;
}

double hours_minutes_seconds(double t) {
  const double day = std::fmod(t, 86400.0), h = std::floor(day / 3600),
               m = std::floor((day - 3600 * h) / 60);
  return 1e4 * h + 100 * m + day - 3600 * h - 60 * m;
}

TEST(ClockDigits, HoursMinutesAndSecondsInOneNumber) {
  for (const double first_s : {43195.0, 46795.0, 86390.0}) {  // over a minute, an hour, midnight
    Channel clock = clock_of_digits(first_s, hours_minutes_seconds);
    std::vector<std::string> notes;
    want_steps_of(0.05, clock, notes);
    EXPECT_EQ(clock.unit, "s");
    EXPECT_THAT(notes, testing::ElementsAre(testing::HasSubstr("hours, minutes and seconds")));
  }
}

TEST(ClockDigits, SecondsStayWhatTheyAre) {
  for (const double first_s : {0.0, 30.0, 120000.0}) {
    Channel clock = clock_of_digits(first_s, [](double t) { return t; });
    const Channel before = clock;
    std::vector<std::string> notes;
    mend_clock_digits(clock, notes);
    EXPECT_EQ(clock.values, before.values);
    EXPECT_THAT(notes, testing::IsEmpty());
  }
}

TEST(ClockDigits, SecondsFarApartStayToo) {
  for (const char* name : {"time_s", "time"})
    for (const std::vector<double>& values :
         {std::vector<double>{0, 100}, {0, 50, 100}, {0, 30, 100, 130, 200}}) {
      Channel clock;
      clock.name = name;
      clock.values = values;
      std::vector<std::string> notes;
      mend_clock_digits(clock, notes);
      EXPECT_EQ(clock.values, values) << name;
      // Without a unit whole numbers so far apart are rather milliseconds, which is said.
      if (clock.name == "time_s")
        EXPECT_THAT(notes, testing::IsEmpty());
      else
        EXPECT_THAT(notes, testing::ElementsAre(testing::HasSubstr("read as ms")));
    }
}

TEST(ClockDigits, DaysOfASpreadsheet) {
  Channel clock = clock_of_digits(0.0, [](double t) { return 45413.5 + t / 86400.0; });
  std::vector<std::string> notes;
  want_steps_of(0.05, clock, notes);
  EXPECT_THAT(notes, testing::ElementsAre(testing::HasSubstr("days of a spreadsheet")));
}

TEST(ClockDigits, CountersThatBeginAgainGoOn) {
  const auto wraps = [](double counter, double scale) {
    return [=](double t) { return std::fmod(std::round(scale * t), counter); };
  };
  std::vector<std::string> notes;
  Channel bits = clock_of_digits(60.0, wraps(65536.0, 1e3));
  want_steps_of(50.0, bits, notes);
  EXPECT_THAT(notes, testing::ElementsAre(testing::HasSubstr("read as ms"),
                                          testing::HasSubstr("begins again 1 times")));
  Channel week = clock_of_digits(604790.0, [](double t) { return std::fmod(t, 604800.0); });
  want_steps_of(0.05, week, notes);
  // A new session is none: what lies between is not known.
  Channel session = clock_of_digits(0.0, [](double t) { return t < 20.0 ? 100.0 + t : t - 20.0; });
  const Channel before = session;
  mend_clock_digits(session, notes);
  EXPECT_EQ(session.values, before.values);
}

}  // namespace clock_digits_test
}  // namespace recording
