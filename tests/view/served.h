// kerbstone view on a folder with a recipe, a log and a road, within the test's own process.
#pragma once

#include <gtest/gtest.h>
#include <httplib.h>

#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/json_text.h"
#include "page.h"
#include "support/places.h"
#include "support/temporary_folder.h"
#include "view/server.h"

namespace server_test {

inline const std::string kToken = "0123456789abcdef0123456789abcdef";

/// A server of a folder with a recipe, a log and a road, for one test.
class Server : public ::testing::Test {
 protected:
  Server() {
    if (view::page().empty()) return;
    std::filesystem::create_directories(folder_.path("shown"));
    folder_.file("secret.csv", "secret\n1\n");
    folder_.file("shown/track.yaml", "mesh: a.obj\n");
    folder_.file("shown/a.obj", "v 0 0 0\nv 200 0 0\nv 0 0 -9\nv 200 0 -9\nf 1 2 3\nf 2 4 3\n");
    folder_.file("shown/empty.csv", "");
    folder_.file("shown/points.tiles", "0123456789");
    folder_.file("shown/log.csv", "time_s,x_m,y_m,speed\n0,0,0,1\n1,1,0,\n2,2,0,3\n");
    folder_.file("shown/evil.html", "<script>fetch('../api/list')</script>");
    std::filesystem::rename(folder_.path("shown/evil.html"), folder_.path("shown/report.html"));
    std::promise<std::pair<std::string, std::function<void()>>> ready;
    auto told = ready.get_future();
    thread_ = std::thread([this, &ready] {
      view::serve({.folders = {folder_.path("shown")},
                   .opened = {},
                   .tools = std::filesystem::path(places::crgbuild()).parent_path().string(),
                   .demo = {},
                   .token = kToken},
                  [&](const std::string& address, const std::function<void()>& stop) {
                    ready.set_value({address, stop});
                  });
    });
    std::tie(address_, stop_) = told.get();
    port_ = std::stoi(address_.substr(address_.find(':', 7) + 1));
    client_ = std::make_unique<httplib::Client>("127.0.0.1", port_);
    client_->set_read_timeout(60);
    client_->set_default_headers({{"X-Kerbstone-Token", kToken}});
  }
  ~Server() override {
    if (!thread_.joinable()) return;
    client_.reset();
    stop_();
    thread_.join();
  }
  void SetUp() override {
    if (view::page().empty()) GTEST_SKIP() << "built without the page (scripts/setup)";
  }

  static std::string at(const std::string& path) { return "/" + path; }
  httplib::Result get(const std::string& path, const httplib::Headers& headers = {}) {
    return client_->Get(at(path), headers);
  }
  nlohmann::json json(const std::string& path) {
    return base::parse_json<nlohmann::json>(get(path)->body);
  }
  nlohmann::json ended_job(int id) {
    for (int k = 0; k < 3000; ++k) {
      for (const nlohmann::json& job : json("api/jobs"))
        if (job["id"] == id && !job["running"]) return job;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    ADD_FAILURE() << "job " << id << " does not end";
    return {};
  }

  support::TemporaryFolder folder_;
  std::string address_;
  std::function<void()> stop_;
  std::thread thread_;
  int port_ = 0;
  std::unique_ptr<httplib::Client> client_;
};

}  // namespace server_test
