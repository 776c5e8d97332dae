// No exception is caught and kept in lib and tools, but where tests/caught_errors.txt says why: who
// decides by one decides by every fault of ours too. What can be counted on is a base::Answer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "support/function_lengths.h"
#include "support/listed.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/sources.h"

namespace cli {
namespace caught_errors_test {

namespace fs = std::filesystem;

/// Lines of a source with a handler of Error, std::exception or everything that throws nothing on.
std::vector<std::size_t> keepers(const std::string& source) {
  static const std::regex kHandler(
      R"(catch \(\s*(\.\.\.|[^)]*(\bError|std::exception)\s*&[^)]*)\)\s*\{)");
  // These never come back, or keep the exception for the thread that waits.
  static const std::regex kThrows(R"(\bthrow\b|\bfail\(|\braise_\w+\(|\bcurrent_exception\b)");
  std::vector<std::size_t> lines;
  for (std::sregex_iterator m(source.begin(), source.end(), kHandler), end; m != end; ++m) {
    const auto begin = static_cast<std::size_t>(m->position() + m->length());
    std::size_t at = begin;
    for (std::size_t depth = 1; depth > 0 && at < source.size(); ++at)
      depth += source[at] == '{' ? 1 : source[at] == '}' ? -1 : 0;
    if (std::regex_search(source.substr(begin, at - begin), kThrows)) continue;
    lines.push_back(1 + static_cast<std::size_t>(
                            std::count(source.begin(), source.begin() + m->position(), '\n')));
  }
  return lines;
}

TEST(CaughtErrors, AreThoseThatNothingThrowsOn) {
  EXPECT_THAT(keepers(R"(
void a() { try { b(); } catch (const Error&) { } }
void b() { try { c(); } catch (const base::Error& error) { if (x) { return; } } }
void c() { try { d(); } catch (const Error& error) { if (x) { y(); } throw; } }
void d() { try { e(); } catch (const std::exception& e) { place.fail(1, e.what()); } }
void e() { try { f(); } catch (...) { } throw 1; }
void f() { try { g(); } catch (const UsageError& e) { } catch (const YAML::Exception& e) { } }
)"),
              ::testing::ElementsAre(2, 3, 6));
}

TEST(CaughtErrors, AreKeptWhereThereIsAReasonAlone) {
  const std::map<std::string, std::string> known = support::listed("caught_errors.txt");
  std::set<std::string> found;
  const fs::path top = places::source();
  for (const std::string& file : support::cpp_of_lib_and_tools()) {
    const std::string source = read(top / file);
    const std::vector<std::size_t> lines = keepers(source);
    if (lines.empty()) continue;
    const std::vector<support::FunctionLength> functions = support::function_lengths(source);
    for (const std::size_t line : lines) {
      std::string place = file;
      for (const support::FunctionLength& f : functions)
        if (f.line <= line && line < f.line + f.lines) place = file + ":" + f.name;
      found.insert(place);
      EXPECT_TRUE(known.contains(place))
          << file << ":" << line << ": " << place << " keeps an exception: let it pass, or give "
          << "back a base::Answer where what it is thrown for can be counted on";
    }
  }
  EXPECT_GT(found.size(), 20u);
  for (const auto& [place, reason] : known)
    EXPECT_TRUE(found.contains(place))
        << place << ": keeps none any more; take it off tests/caught_errors.txt";
}

}  // namespace caught_errors_test
}  // namespace cli
