// The program that measures another library beside ours, with ours as the other.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace api_bench_test {

struct Ran {
  int code;
  std::string out;
};

Ran bench(const std::string& arguments) {
  FILE* pipe = ::popen((KERBSTONE_CRG_API_BENCH " " + arguments + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return {-1, ""};
  std::string out;
  std::array<char, 4096> part;
  for (std::size_t got; (got = std::fread(part.data(), 1, part.size(), pipe)) > 0;)
    out.append(part.data(), got);
  return {WEXITSTATUS(::pclose(pipe)), out};
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size())
    ++found;
  return found;
}

TEST(ApiBench, MeasuresAnotherLibraryBesideOursAndComparesTheAnswers) {
  const Ran ran = bench("--km 0.5 --rounds 3 --library " KERBSTONE_OPENCRG);
  ASSERT_EQ(ran.code, 0) << ran.out;
  EXPECT_EQ(count(ran.out, "M/s"), 8U) << ran.out;
  EXPECT_EQ(count(ran.out, "read and check"), 1U) << ran.out;
  EXPECT_EQ(count(ran.out, "0.0e+00"), 9U) << "the same library, the same answers\n" << ran.out;
}

TEST(ApiBench, WithoutAnotherLibraryOursAlone) {
  const Ran ran = bench("--km 0.5 --rounds 1");
  ASSERT_EQ(ran.code, 0) << ran.out;
  EXPECT_EQ(count(ran.out, "M/s"), 8U) << ran.out;
  EXPECT_EQ(count(ran.out, "ratio"), 0U) << ran.out;
}

TEST(ApiBench, RefusesWhatIsNoSuchLibrary) {
  const Ran none = bench("--library /nowhere/libOpenCRG.so");
  EXPECT_EQ(none.code, 1);
  EXPECT_NE(none.out.find("/nowhere/libOpenCRG.so"), std::string::npos) << none.out;
  const Ran other = bench("--library libm.so.6");
  EXPECT_EQ(other.code, 1);
  EXPECT_NE(other.out.find("libm.so.6: no crgMsgSetLevel; wanted"), std::string::npos) << other.out;
}

}  // namespace api_bench_test
