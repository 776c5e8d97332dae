// The answers of the reference C API 2.0.1 on roads of our own (tests/corpus/reference, see the
// README there), asked through the same calls.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "crgBaseLib.h"
#include "support/places.h"

namespace own_roads_test {

namespace fs = std::filesystem;

const std::map<std::string, unsigned> kNumbers = {
    {"SCALE_BANKING", dCrgModScaleBank},           {"SCALE_WIDTH", dCrgModScaleWidth},
    {"SCALE_CURVATURE", dCrgModScaleCurvature},    {"BORDER_MODE_U", dCrgCpOptionBorderModeU},
    {"BORDER_MODE_V", dCrgCpOptionBorderModeV},    {"BORDER_OFFSET_U", dCrgCpOptionBorderOffsetU},
    {"BORDER_OFFSET_V", dCrgCpOptionBorderOffsetV}};

struct Answers {
  std::string road;
  bool modified = true;
  std::vector<std::pair<std::string, double>> modifiers, options;
  std::vector<std::vector<std::string>> lines;  ///< cells, without the header
};

Answers read_answers(const fs::path& path) {
  Answers answers;
  std::ifstream file(path);
  for (std::string text; std::getline(file, text);) {
    if (text.front() == 'u') continue;
    if (text.front() == '#') {
      std::istringstream words(text.substr(1));
      std::string kind, key;
      double value = 0.0;
      words >> kind >> key >> value;
      if (kind == "road") answers.road = key;
      if (kind == "modifiers") answers.modified = key != "none";
      if (kind == "modifier") answers.modifiers.emplace_back(key, value);
      if (kind == "option") answers.options.emplace_back(key, value);
      continue;
    }
    std::istringstream cells(text);
    answers.lines.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) answers.lines.back().push_back(cell);
  }
  return answers;
}

/// The contact point of a data set as a file of answers wants both.
int prepared(int set, const Answers& answers) {
  for (const auto& [key, value] : answers.modifiers)
    EXPECT_EQ(crgDataSetModifierSetDouble(set, kNumbers.at(key), value), 1) << key;
  EXPECT_EQ(crgCheck(set), 1);
  if (answers.modified) crgDataSetModifiersApply(set);
  const int cp = crgContactPointCreate(set);
  for (const auto& [key, value] : answers.options) {
    const unsigned id = kNumbers.at(key);
    EXPECT_EQ(key.starts_with("BORDER_MODE")
                  ? crgContactPointOptionSetInt(cp, id, static_cast<int>(value))
                  : crgContactPointOptionSetDouble(cp, id, value),
              1)
        << key;
  }
  return cp;
}

void expect_height(int got, double z, const std::string& cell) {
  EXPECT_EQ(got, cell == "none" ? 0 : 1);
  if (cell == "none") return;
  if (cell == "nan") {
    EXPECT_TRUE(std::isnan(z)) << z;
  } else {
    EXPECT_NEAR(z, std::stod(cell), 1e-6);
  }
}

TEST(OwnRoads, AnswersAsTheReferenceThroughTheSameCalls) {
  crgMsgSetLevel(dCrgMsgLevelNone);
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(places::source() + "/tests/corpus/reference")) {
    if (entry.path().extension() != ".csv") continue;
    SCOPED_TRACE(entry.path().stem().string());
    ++files;
    const Answers answers = read_answers(entry.path());
    EXPECT_EQ(answers.lines.size(), 200U);
    const int set = crgLoaderReadFile((places::source() + "/tests/corpus/" + answers.road).c_str());
    ASSERT_GT(set, 0);
    const int cp = prepared(set, answers);
    double u_begin = 0.0, u_end = 0.0, u_step = 0.0, v_step = 0.0, v_right = 0.0, v_left = 0.0;
    double u_low = 0.0, u_high = 0.0;
    int closed = 0;
    crgDataSetGetURange(set, &u_begin, &u_end);
    crgDataSetGetVRange(set, &v_right, &v_left);
    crgDataSetGetIncrements(set, &u_step, &v_step);
    crgDataSetGetUtilityDataClosedTrack(set, &closed, &u_low, &u_high);
    for (const std::vector<std::string>& cells : answers.lines) {
      const double u = std::stod(cells[0]), v = std::stod(cells[1]);
      SCOPED_TRACE(cells[0] + ", " + cells[1]);
      const auto want = [&](std::size_t column) { return std::stod(cells[column]); };
      // The seam of a closed track and banking beyond a repeated border: as in
      // tests/crg/reference_test.cpp.
      if (closed == 1 && (u < u_begin + u_step || u > u_end - u_step)) continue;
      const bool banking_differs = entry.path().stem() == "reflect" && (v < v_right || v > v_left);
      const double tolerance = u < u_begin || u > u_end ? 1e-7 : 1e-9;
      double one = 0.0, two = 0.0;
      int got = crgEvaluv2z(cp, u, v, &one);
      if (!banking_differs) expect_height(got, one, cells[2]);
      EXPECT_EQ(crgEvaluv2xy(cp, u, v, &one, &two), 1);
      EXPECT_NEAR(one, want(3), tolerance);
      EXPECT_NEAR(two, want(4), tolerance);
      EXPECT_EQ(crgEvaluv2pk(cp, u, v, &one, &two), 1);
      EXPECT_NEAR(one, want(5), 1e-9);
      EXPECT_NEAR(two, want(6), 1e-9);
      EXPECT_EQ(crgEvalxy2uv(cp, want(7), want(8), &one, &two), 1);
      EXPECT_NEAR(one, want(9), tolerance);
      EXPECT_NEAR(two, want(10), tolerance);
      got = crgEvalxy2z(cp, want(7), want(8), &one);
      if (!banking_differs) expect_height(got, one, cells[11]);
    }
    EXPECT_EQ(crgDataSetRelease(set), 1);
  }
  EXPECT_EQ(files, 9U);
  crgMsgSetLevel(dCrgMsgLevelNotice);
}

}  // namespace own_roads_test
