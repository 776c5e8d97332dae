// `query` against the answers of the reference C API at every point, with and without height.
// Skipped where the files are absent.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>

#include "support/places.h"
#include "support/run_crgbuild.h"

namespace cli {
namespace reference_answers_test {

namespace fs = std::filesystem;

/// The sample of a file of answers and the flags that say what the answers were asked with.
struct Case {
  std::string sample;
  std::vector<std::string> flags;
  bool zero_at_sides = false;  ///< BORDER_MODE_V 1
};

Case case_of(std::string name) {
  const std::map<std::string, std::pair<std::string, std::vector<std::string>>> special = {
      {"scale_z", {"handmade_curved_banked_sloped", {"SCALE_Z_GRID=2.5"}}},
      {"scale_bank", {"handmade_curved_banked_sloped", {"SCALE_BANKING=3"}}},
      {"scale_len", {"handmade_curved_banked_sloped", {"SCALE_LENGTH=1.7"}}},
      {"curved_offsets",
       {"handmade_curved_banked_sloped",
        {"BORDER_MODE_U=2", "BORDER_MODE_V=2", "BORDER_OFFSET_U=0.25", "BORDER_OFFSET_V=-0.5"}}},
      {"circle_close", {"handmade_circle", {"REFLINE_CONTINUATION=1"}}}};
  std::vector<std::string> settings;
  bool modifiers = true, zero = false;
  if (const auto found = special.find(name); found != special.end()) {
    settings = found->second.second;
    name = found->second.first;
  } else {
    const auto drop = [&](const std::string& suffix) {
      const bool there = name.ends_with(suffix);
      if (there) name.resize(name.size() - suffix.size());
      return there;
    };
    modifiers = !drop("_nomods");
    for (int mode = 0; mode <= 4; ++mode) {
      if (drop(fmt::format("_bu{}", mode)))
        settings.push_back(fmt::format("BORDER_MODE_U={}", mode));
      if (drop(fmt::format("_bv{}", mode))) {
        settings.push_back(fmt::format("BORDER_MODE_V={}", mode));
        zero = mode == 1;
      }
    }
  }
  Case result{name, {"--modifiers", modifiers ? "reference" : "none"}, zero};
  for (const std::string& setting : settings)
    result.flags.insert(result.flags.end(), {"--set", setting});
  return result;
}

struct Answer {
  std::string kind, a, b;
  double want1, want2;
  bool valid;
};

std::vector<Answer> answers_in(const std::string& path) {
  std::vector<Answer> answers;
  std::istringstream file(read(path));
  std::string text;
  while (std::getline(file, text)) {
    if (text.empty() || text[0] == '#' || text[0] == 'k') continue;
    std::replace(text.begin(), text.end(), ',', ' ');
    std::istringstream words(text);
    Answer answer;
    std::string ret, one, two;
    words >> answer.kind >> answer.a >> answer.b >> ret >> one >> two;
    answer.want1 = std::strtod(one.c_str(), nullptr),
    answer.want2 = std::strtod(two.c_str(), nullptr);
    answer.valid = ret != "0" && !std::isnan(answer.want1);
    answers.push_back(answer);
  }
  return answers;
}

/// x_m, y_m, u_m, v_m, z_m, heading_rad, curvature_1pm; NaN for an empty cell.
std::vector<std::vector<double>> rows_of(const std::string& csv) {
  std::vector<std::vector<double>> rows;
  std::istringstream file(csv);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::vector<double> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');)
      row.push_back(cell.empty() ? std::nan("") : std::strtod(cell.c_str(), nullptr));
    row.resize(9, std::nan(""));
    rows.push_back(row);
  }
  return rows;
}

TEST(ReferenceAnswers, QueryGivesThemAtEveryPointAlsoWithoutHeight) {
  const fs::path data = fs::path(places::data()) / "opencrg";
  std::error_code absent;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(data / "reference", absent)) {
    if (entry.path().extension() == ".csv") names.push_back(entry.path().stem().string());
  }
  if (names.empty())
    GTEST_SKIP() << "no reference answers in " << places::data() << "/opencrg/reference";
  std::sort(names.begin(), names.end());
  const Folder folder;
  // The samples include each other as ../crg-txt/<name>.
  for (const char* part : {"crg-txt", "here"}) fs::copy(data / "samples", fs::path(folder / part));
  std::size_t points = 0, without_height = 0;
  for (const std::string& name : names) {
    SCOPED_TRACE(name);
    const Case now = case_of(name);
    const std::vector<Answer> answers = answers_in((data / "reference" / (name + ".csv")).string());
    for (const bool map : {false, true}) {
      std::string csv = map ? "x_m,y_m\n" : "u_m,v_m\n";
      std::vector<const Answer*> asked;
      for (const Answer& answer : answers) {
        if (answer.kind.starts_with("xy") != map) continue;
        csv += answer.a + "," + answer.b + "\n";
        asked.push_back(&answer);
      }
      write(folder / "points.csv", csv);
      std::vector<std::string> arguments = {"query",    folder / "here/" + now.sample + ".crg",
                                            "--points", folder / "points.csv",
                                            "-o",       folder / "answers.csv"};
      arguments.insert(arguments.end(), now.flags.begin(), now.flags.end());
      const Ran ran = crgbuild(arguments);
      ASSERT_EQ(ran.code, 0) << ran.err;
      const auto rows = rows_of(read(folder / "answers.csv"));
      ASSERT_EQ(rows.size(), asked.size());
      for (std::size_t k = 0; k < rows.size(); ++k) {
        const Answer& answer = *asked[k];
        const std::vector<double>& row = rows[k];
        const std::string place = fmt::format("{} {} {}", answer.kind, answer.a, answer.b);
        for (const std::size_t column : {0, 1, 2, 3, 5})
          EXPECT_TRUE(std::isfinite(row[column]))
              << place << ": column " << column + 1 << " is empty";
        ++points;
        without_height += std::isnan(row[4]);
        if (answer.kind == "uv2xy") {
          EXPECT_NEAR(row[0], answer.want1, 1e-9) << place;
          EXPECT_NEAR(row[1], answer.want2, 1e-9) << place;
        } else if (answer.kind == "uv2pk") {
          EXPECT_NEAR(row[5], answer.want1, 1e-9) << place;
          EXPECT_NEAR(row[6], answer.want2, 1e-9) << place;
        } else if (answer.kind == "xy2uv") {
          EXPECT_NEAR(row[2], answer.want1, 1e-9) << place;
          EXPECT_NEAR(row[3], answer.want2, 1e-9) << place;
        } else if (now.zero_at_sides && row[4] == 0.0) {
          continue;  // docs/opencrg.md, decision 7
        } else if (answer.valid) {
          EXPECT_NEAR(row[4], answer.want1, 1e-6) << place;
        } else {
          EXPECT_TRUE(std::isnan(row[4])) << place;
        }
      }
    }
  }
  EXPECT_GT(points, 50000U);
  EXPECT_GT(without_height, 100U) << "the answers hold points without height";
  fmt::print("{} points, {} of them without height\n", points, without_height);
}

}  // namespace reference_answers_test
}  // namespace cli
