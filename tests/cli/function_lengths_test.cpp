// No function of lib and tools is longer than a screen, but for those that tests/long_functions.txt
// names.
#include "support/function_lengths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <stdexcept>

#include "support/listed.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/sources.h"

namespace cli {
namespace function_lengths_test {

namespace fs = std::filesystem;
using support::function_lengths;

/// "add 3 2": name, first line, lines.
std::vector<std::string> told(std::string_view source) {
  std::vector<std::string> out;
  for (const support::FunctionLength& f : function_lengths(source))
    out.push_back(f.name + " " + std::to_string(f.line) + " " + std::to_string(f.lines));
  return out;
}

TEST(FunctionLengths, AreThoseOfNamespacesAndClasses) {
  EXPECT_THAT(told(R"(// { not a brace
#define OPEN {
#define MORE(x) \
  { x
namespace a::b {
int add(int x,
        int y) {
  const auto f = [](int z) { return z; };
  if (x > 0) { return f(x); }
  return y;
}
template <class T = int>
struct Shape {
  int width_{1'000};
  Shape() : width_{2}, height_(3) {
    width_ = '}';
  }
  double area() const noexcept override { return 1; }
  auto operator()(int x) -> int {
    return x;
  }
  bool operator==(const Shape& other) const {
    return true;
  }
  int height_ = 4;
};
enum class Kind { kOne, kTwo };
constexpr int kTable[] = {1, 2, 3};
const auto kCall = [](int x) {
  return x;
};
std::map<int, int> made{{1, 2}};
}  // namespace a::b
extern "C" {
int old(void) { return R"x({{{)x"[0]; }
}
std::vector<int> Shape::sides(std::function<int(int)> of)
    const {
  return {1, 2};
}
)"),
              ::testing::ElementsAre("add 6 6", "Shape 15 3", "area 18 1", "operator() 19 3",
                                     "operator== 22 3", "old 35 1", "Shape::sides 37 4"));
}

TEST(FunctionLengths, BracesThatDoNotMatchAreNoSource) {
  EXPECT_THROW(function_lengths("int f() { if (true) { }"), std::runtime_error);
  EXPECT_THROW(function_lengths("int f() { } }"), std::runtime_error);
}

TEST(Layout, FunctionsAreShort) {
  constexpr std::size_t kMostLines = 80, kMostWithAReason = 5;
  std::map<std::string, std::string> known = support::listed("long_functions.txt");
  std::size_t with_a_reason = 0, functions = 0;
  for (const auto& [name, reason] : known) with_a_reason += reason != "to split" ? 1 : 0;
  EXPECT_LE(with_a_reason, kMostWithAReason);
  const fs::path top = places::source();
  for (const std::string& file : support::cpp_of_lib_and_tools())
    for (const support::FunctionLength& f : function_lengths(read(top / file))) {
      ++functions;
      if (f.lines > kMostLines) {
        EXPECT_EQ(known.erase(file + ":" + f.name), 1u)
            << file << ":" << f.line << ": " << f.name << " has " << f.lines << " lines, at most "
            << kMostLines << " wanted: give its steps names";
      }
    }
  EXPECT_GT(functions, 3500u);
  for (const auto& [name, reason] : known)
    ADD_FAILURE() << name
                  << ": not there or short enough now; take it off tests/long_functions.txt";
}

}  // namespace function_lengths_test
}  // namespace cli
