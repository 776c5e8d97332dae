// The answers of the reference C API 2.0.1, asked through the same calls (see the README beside
// them), and threads. The answers are skipped where the files are absent.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "crg/roads.h"
#include "crgBaseLib.h"
#include "support/places.h"

namespace evaluate_test {

namespace fs = std::filesystem;
using crg::test::Folder;

struct Case {
  std::string sample;
  bool modifiers = true;
  std::vector<std::pair<unsigned, double>> scales = {};
  std::vector<std::pair<unsigned, int>> modes = {};
  std::vector<std::pair<unsigned, double>> offsets = {};
};

Case case_of(std::string name) {
  const std::string curved = "handmade_curved_banked_sloped";
  const std::map<std::string, Case> special = {
      {"scale_z", {curved, true, {{dCrgModScaleZ, 2.5}}}},
      {"scale_bank", {curved, true, {{dCrgModScaleBank, 3.0}}}},
      {"scale_len", {curved, true, {{dCrgModScaleLength, 1.7}}}},
      {"circle_close",
       {"handmade_circle", true, {}, {{dCrgCpOptionRefLineContinue, dCrgRefLineCloseTrack}}}},
      {"curved_offsets",
       {curved,
        true,
        {},
        {{dCrgCpOptionBorderModeU, 2}, {dCrgCpOptionBorderModeV, 2}},
        {{dCrgCpOptionBorderOffsetU, 0.25}, {dCrgCpOptionBorderOffsetV, -0.5}}}}};
  if (const auto found = special.find(name); found != special.end()) return found->second;
  Case result;
  const auto drop = [&](const std::string& suffix) {
    const bool there = name.ends_with(suffix);
    if (there) name.resize(name.size() - suffix.size());
    return there;
  };
  result.modifiers = !drop("_nomods");
  for (int mode = 0; mode <= 4; ++mode) {
    if (drop("_bu" + std::to_string(mode)))
      result.modes.emplace_back(dCrgCpOptionBorderModeU, mode);
    if (drop("_bv" + std::to_string(mode)))
      result.modes.emplace_back(dCrgCpOptionBorderModeV, mode);
  }
  result.sample = name;
  return result;
}

struct Tally {
  std::size_t asked = 0, agree = 0;
  double worst = 0.0;
};

bool near(double got, double want, double tolerance) {
  return std::isnan(want) ? std::isnan(got) : std::abs(got - want) <= tolerance;
}

void compare_line(const std::string& text, int set, int cp, Tally& tally) {
  std::string words = text;
  std::replace(words.begin(), words.end(), ',', ' ');
  std::istringstream in(words);
  std::string kind, a, b, ret, one, two;
  in >> kind;
  if (kind == "#") {
    in >> kind >> a >> b >> one;
    double x = 0, y = 0;
    int closed = -1;
    if (kind == "check") {
      EXPECT_EQ(crgCheck(set), std::stoi(a));
    }
    if (kind == "urange" || kind == "vrange") {
      double u_step = 0, v_step = 0;
      const bool u = kind[0] == 'u';
      EXPECT_EQ((u ? crgDataSetGetURange : crgDataSetGetVRange)(set, &x, &y), 1);
      EXPECT_EQ(crgDataSetGetIncrements(set, &u_step, &v_step), 1);
      EXPECT_NEAR(x, std::stod(a), 1e-9);
      EXPECT_NEAR(y, std::stod(b), 1e-9);
      EXPECT_NEAR(u ? u_step : v_step, std::stod(one), 1e-9);
    }
    if (kind == "closed") {
      EXPECT_EQ(crgDataSetGetUtilityDataClosedTrack(set, &closed, &x, &y), 1);
      EXPECT_EQ(closed, std::stoi(a));
      EXPECT_NEAR(x, std::stod(b), 1e-9);
      EXPECT_NEAR(y, std::stod(one), 1e-9);
    }
    return;
  }
  in >> a >> b >> ret >> one >> two;
  if (ret.empty() || kind == "kind") return;
  const double in1 = std::stod(a), in2 = std::stod(b), want1 = std::stod(one);
  double out1 = -99.0, out2 = -99.0;
  int got = 0;
  double tolerance = 1e-9;
  if (kind == "uv2z" || kind == "xy2z") {
    got = (kind == "uv2z" ? crgEvaluv2z : crgEvalxy2z)(cp, in1, in2, &out1);
    tolerance = 1e-6;
  } else {
    const auto call = kind == "uv2xy"   ? crgEvaluv2xy
                      : kind == "uv2pk" ? crgEvaluv2pk
                                        : crgEvalxy2uv;
    got = call(cp, in1, in2, &out1, &out2);
  }
  ++tally.asked;
  const bool pair = kind != "uv2z" && kind != "xy2z";
  const bool good = got == std::stoi(ret) && near(out1, want1, tolerance) &&
                    (!pair || near(out2, std::stod(two), tolerance));
  if (good)
    ++tally.agree;
  else if (tally.asked - tally.agree < 20)
    std::printf("%s: %d %.17g %.17g\n", text.c_str(), got, out1, out2);
}

TEST(Evaluate, AnswersAsTheReferenceThroughTheSameCalls) {
  const fs::path data = fs::path(places::data()) / "opencrg";
  if (!fs::is_directory(data / "reference")) GTEST_SKIP() << "no answers in " << data;
  // The samples include each other as ../crg-txt/<name>.
  const Folder folder;
  for (const char* part : {"crg-txt", "here"}) {
    fs::create_directories(folder.file(part));
    for (const auto& entry : fs::directory_iterator(data / "samples"))
      fs::copy_file(entry.path(), fs::path(folder.file(part)) / entry.path().filename());
  }
  crgMsgSetLevel(dCrgMsgLevelFatal);
  Tally tally;
  for (const auto& entry : fs::directory_iterator(data / "reference")) {
    if (entry.path().extension() != ".csv") continue;
    SCOPED_TRACE(entry.path().filename().string());
    const Case now = case_of(entry.path().stem().string());
    const int set = crgLoaderReadFile((folder.file("here") + "/" + now.sample + ".crg").c_str());
    ASSERT_GT(set, 0);
    for (const auto& [id, value] : now.scales)
      ASSERT_EQ(crgDataSetModifierSetDouble(set, id, value), 1);
    if (now.modifiers) crgDataSetModifiersApply(set);
    const int cp = crgContactPointCreate(set);
    ASSERT_GE(cp, 0);
    for (const auto& [id, value] : now.modes)
      ASSERT_EQ(crgContactPointOptionSetInt(cp, id, value), 1);
    for (const auto& [id, value] : now.offsets)
      ASSERT_EQ(crgContactPointOptionSetDouble(cp, id, value), 1);
    std::ifstream file(entry.path());
    std::string text;
    while (std::getline(file, text)) compare_line(text, set, cp, tally);
    EXPECT_EQ(crgDataSetRelease(set), 1);
  }
  crgMsgSetLevel(dCrgMsgLevelNotice);
  EXPECT_GT(tally.asked, 50000U);
  EXPECT_EQ(tally.agree, tally.asked);
}

TEST(Evaluate, OneContactPointPerThreadAnswersAsAlone) {
  const crg::ReferenceLine line = crg::test::circuit(1501, 30.0, 0.1, 3);
  const Folder folder;
  crg::write(crg::make_crg(line, crg::test::grid_of(line, -4.0, 4.0, 17,
                                                    [](double u, double v) {
                                                      return 0.1 * std::sin(u) + 0.02 * v;
                                                    })),
             folder.file("road.crg"), crg::Format::KRBI);
  const int set = crgLoaderReadFile(folder.file("road.crg").c_str());
  ASSERT_GT(set, 0);
  const auto drive = [&](int shift) {
    const int cp = crgContactPointCreate(set);
    std::vector<double> z;
    for (int k = 0; k < 4000; ++k) {
      double x = 0, y = 0, height = 0;
      crgEvaluv2xy(cp, std::fmod(0.037 * (k + shift), 150.0), 1.5 * std::sin(0.01 * k), &x, &y);
      EXPECT_EQ(crgEvalxy2z(cp, x, y, &height), 1);
      z.push_back(height);
    }
    EXPECT_EQ(crgContactPointDelete(cp), 1);
    return z;
  };
  std::vector<std::vector<double>> alone, together(4);
  for (int t = 0; t < 4; ++t) alone.push_back(drive(700 * t));
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int again = 0; again < 5; ++again)
        together[static_cast<std::size_t>(t)] = drive(700 * t);
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(together, alone);
  EXPECT_EQ(crgDataSetRelease(set), 1);
}

}  // namespace evaluate_test
