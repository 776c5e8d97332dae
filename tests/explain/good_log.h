// A log in which nothing is wrong, to break in one place each.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "crg/file.h"
#include "crg/surface.h"
#include "explain/signals.h"
#include "recording/table.h"
#include "support/places.h"
#include "support/temporary_folder.h"
#include "vehicle/error.h"

namespace explain {

/// A log in which nothing is wrong, its road and car.
class GoodLog : public ::testing::Test {
 protected:
  void SetUp() override {
    if (folder_ != nullptr) return;
    folder_ = new support::TemporaryFolder;
    ASSERT_EQ(
        std::system(fmt::format("{} --scenario none {}", places::make_trials(), folder_->path("."))
                        .c_str()),
        0);
    road_ = new crg::Surface(crg::read(folder_->path("none/track.crg")));
    log_ = new recording::Table(recording::read_table(folder_->path("none/run.csv")));
  }
  static void TearDownTestSuite() {
    delete std::exchange(log_, nullptr);
    delete std::exchange(road_, nullptr);
    delete std::exchange(folder_, nullptr);
  }

  static std::vector<double>& column(recording::Table& t, const std::string& name) {
    for (std::size_t k = 0; k < t.names.size(); ++k)
      if (t.names[k] == name) return t.columns[k];
    throw std::runtime_error(name);
  }
  template <class Change>
  static recording::Table changed(const std::string& name, Change change) {
    recording::Table t = *log_;
    for (double& v : column(t, name)) v = change(v);
    return t;
  }
  static Signals signals(const recording::Table& t) {
    return make_signals(t, identity_mapping(t), *road_, "log.csv");
  }
  static std::string said(const recording::Table& t) {
    try {
      std::string out;
      for (const std::string& remark : signals(t).remarks) out += remark + "\n";
      return out;
    } catch (const vehicle::Error& error) {
      return error.what();
    }
  }
  static recording::Table rows(std::size_t begin, std::size_t end, std::size_t every = 1) {
    recording::Table t = *log_;
    for (std::size_t k = 0; k < t.columns.size(); ++k) {
      t.columns[k].clear();
      for (std::size_t i = begin; i < std::min(end, log_->rows()); i += every)
        t.columns[k].push_back(log_->columns[k][i]);
    }
    return t;
  }

  inline static support::TemporaryFolder* folder_ = nullptr;
  inline static crg::Surface* road_ = nullptr;
  inline static recording::Table* log_ = nullptr;
};

}  // namespace explain
