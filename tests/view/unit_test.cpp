// Units of strangers on the page: nothing of them runs before it was asked for.
#include <dlfcn.h>
#include <gmock/gmock.h>

#include <cstdlib>

#include "base/json_text.h"
#include "base/read_file.h"
#include "base/sha256.h"
#include "fmu/archive.h"
#include "served.h"

namespace server_test {
namespace unit_test {

using ::testing::HasSubstr;

class Unit : public Server {
 protected:
  Unit() {
    folder_.file("shown/car.fmu",
                 fmu::make_archive({{"modelDescription.xml",
                                     R"(<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Some" guid="1"><CoSimulation modelIdentifier="some"/>
<ModelVariables><ScalarVariable name="a" valueReference="1" causality="output"><Real/></ScalarVariable>
</ModelVariables></fmiModelDescription>)"},
                                    {"binaries/linux64/some.so", base::read_file(MARKING_UNIT)}}));
    ::setenv("KERBSTONE_MARK", folder_.path("mark").c_str(), 1);
    const std::string crgsim = std::filesystem::path(places::crgsim()).parent_path().string();
    ::setenv("PATH", (crgsim + ":" + ::getenv("PATH")).c_str(), 1);
  }
  ~Unit() override { ::unsetenv("KERBSTONE_MARK"); }
  httplib::Result post(const nlohmann::json& wish) {
    return client_->Post("/api/job", base::dump_json(wish), "application/json");
  }
  bool has_run() const { return std::filesystem::exists(folder_.path("mark")); }
};

TEST_F(Unit, IsListedAndToldOfWithoutBeingRun) {
  const auto begun = post({{"do", "info"}, {"unit", "0/car.fmu"}});
  ASSERT_EQ(begun->status, 200) << begun->body;
  const nlohmann::json job = ended_job(base::parse_json<nlohmann::json>(begun->body)["id"]);
  EXPECT_EQ(job["exit_code"], 0) << job;
  const auto told = get("api/output?job=" + std::to_string(job["id"].get<int>()));
  EXPECT_THAT(told->body, HasSubstr("\"a\""));
  EXPECT_EQ(get("api/unit?id=0/car.fmu")->status, 200);
  json("api/list");
  EXPECT_FALSE(has_run());
  // It would have been seen.
  ASSERT_NE(::dlopen(MARKING_UNIT, RTLD_NOW), nullptr);
  EXPECT_TRUE(has_run());
}

TEST_F(Unit, IsRunOnlyByWhoAgreesToItsBytesAndIsAskedOnce) {
  const auto start = [&](const nlohmann::json& agreed) {
    return post({{"do", "drive"}, {"unit", "0/car.fmu"}, {"agreed", agreed}})->status;
  };
  const std::string path = folder_.path("shown/car.fmu"), sha256 = base::sha256_of_file(path);
  for (const nlohmann::json& agreed :
       {nlohmann::json(), nlohmann::json(true), nlohmann::json(""), nlohmann::json(sha256 + "0")})
    EXPECT_EQ(start(agreed), 428) << agreed;
  EXPECT_EQ(json("api/jobs").size(), 0U);
  EXPECT_FALSE(has_run());
  EXPECT_EQ(json("api/unit?id=0/car.fmu"), (nlohmann::json{{"sha256", sha256}, {"agreed", false}}));
  EXPECT_EQ(start(sha256), 200);
  EXPECT_EQ(json("api/unit?id=0/car.fmu"), (nlohmann::json{{"sha256", sha256}, {"agreed", true}}));
  EXPECT_EQ(start(nullptr), 200);
  folder_.file("shown/car.fmu", folder_.read("shown/car.fmu") + "x");
  EXPECT_EQ(start(sha256), 428) << "other bytes under the same name";
}

}  // namespace unit_test
}  // namespace server_test
