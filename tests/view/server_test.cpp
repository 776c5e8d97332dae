#include "view/server.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <random>

#include "admission.h"
#include "base/error.h"
#include "base/json_text.h"
#include "base/output_set.h"
#include "base/write_file.h"
#include "served.h"

namespace server_test {

using ::testing::HasSubstr;

TEST_F(Server, GivesThePageAndTheListUnderItsWholeAddress) {
  EXPECT_EQ(address_, "http://127.0.0.1:" + std::to_string(port_) + "/#" + kToken);
  const auto page = get("");
  EXPECT_EQ(page->status, 200);
  EXPECT_THAT(page->body, HasSubstr("<title>Kerbstone</title>"));
  EXPECT_THAT(page->get_header_value("Content-Security-Policy"), HasSubstr("default-src 'none'"));
  // Nothing of the page comes from elsewhere.
  EXPECT_THAT(page->body, ::testing::Not(::testing::ContainsRegex("(src|href)=\"?https?:")));
  const nlohmann::json list = json("api/list");
  EXPECT_EQ(list["entries"].size(), 5U) << list;
}

TEST_F(Server, AnswersNobodyElse) {
  const auto status = [&](const std::string& path, const httplib::Headers& headers = {}) {
    httplib::Client stranger("127.0.0.1", port_);
    const auto answer = stranger.Get(path, headers);
    EXPECT_FALSE(answer->body.find("\"0/track.yaml\"") != std::string::npos);
    return answer->status;
  };
  std::string wrong = kToken;
  wrong.back() = '0';
  for (const std::string& token :
       {std::string(), wrong, kToken.substr(1), kToken + kToken, std::string("0")})
    EXPECT_EQ(status("/api/list", {{"X-Kerbstone-Token", token}}), 404) << token;
  EXPECT_EQ(status("/api/list"), 404);
  EXPECT_EQ(status("//api/list"), 404);
  // In no address does it open anything.
  EXPECT_EQ(status("/" + kToken + "/api/list"), 404);
  EXPECT_EQ(status("/api/list?token=" + kToken + "&key=" + kToken), 404);
  EXPECT_EQ(status("/"), 200) << "the page itself holds no secret";
  // Another page in the same browser; a name that was made to lead here (DNS rebinding).
  const auto with_token = [&](const std::string& header, const std::string& value) {
    return get("api/list", {{header, value}})->status;
  };
  EXPECT_EQ(with_token("Origin", "http://evil.example"), 403);
  EXPECT_EQ(with_token("Origin", "null"), 403);
  EXPECT_EQ(with_token("Host", "evil.example:" + std::to_string(port_)), 403);
  EXPECT_EQ(with_token("Origin", "http://127.0.0.1:" + std::to_string(port_)), 200);
}

TEST_F(Server, ReadsNothingOutsideTheFolders) {
  for (const char* const what : {"text", "file", "part", "road", "log", "channels"})
    for (const char* const id :
         {"0/../secret.csv", "0/%2e%2e/secret.csv", "0/..%2fsecret.csv", "..%2f..%2fetc%2fpasswd",
          "%2fetc%2fpasswd", "0//etc/passwd", ""}) {
      const auto answer = get(std::string("api/") + what + "?id=" + id);
      EXPECT_EQ(answer->status, 404) << what << " " << id;
      EXPECT_THAT(answer->body, ::testing::Not(HasSubstr("secret\n")));
    }
}

// Frames and pictures send no header: their address has a key, which a page inside may know.
TEST_F(Server, TheKeyOfAFileOpensThisFileAlone) {
  httplib::Client stranger("127.0.0.1", port_);
  const auto status = [&](const std::string& path) { return stranger.Get(path)->status; };
  std::string key;
  const nlohmann::json list = json("api/list");
  for (const nlohmann::json& entry : list["entries"])
    if (entry["id"] == "0/report.html") key = entry["key"];
  EXPECT_EQ(status("/api/file?id=0/report.html&key=" + key), 200);
  EXPECT_EQ(status("/api/file?id=0/report.html"), 404);
  EXPECT_EQ(status("/api/file?id=0/log.csv&key=" + key), 404);
  EXPECT_EQ(status("/api/file?id=0/log.csv&id=0/report.html&key=" + key), 404);
  EXPECT_EQ(status("/api/file?id=0/report.html&id=0/log.csv&key=" + key), 200)
      << "the first counts";
  EXPECT_EQ(status("/api/text?id=0/report.html&key=" + key), 404);
  EXPECT_NE(key, view::key_of_file(kToken, "0/log.csv"));
  // What goes out names the token nowhere.
  for (const char* const path : {"", "api/list", "api/file?id=0/report.html"}) {
    const auto answer = get(path);
    EXPECT_FALSE(answer->body.find(kToken) != std::string::npos) << path;
    for (const auto& [name, value] : answer->headers)
      EXPECT_THAT(value, ::testing::Not(HasSubstr(kToken))) << path << " " << name;
  }
}

TEST_F(Server, WhateverIsServedRunsNothingElsewhereAndTellsNoAddress) {
  for (const char* const path :
       {"", "api/list", "api/file?id=0/report.html", "api/file?id=0/log.csv",
        "api/text?id=0/track.yaml", "api/part?id=0/points.tiles&begin=3&bytes=4",
        "api/channels?id=0/log.csv&name=speed", "api/text?id=0/none.csv"}) {
    const auto answer = get(path);
    EXPECT_THAT(answer->get_header_value("Content-Security-Policy"),
                HasSubstr("default-src 'none'"))
        << path;
    EXPECT_EQ(answer->get_header_value_count("Content-Security-Policy"), 1U) << path;
    EXPECT_EQ(answer->get_header_value("Referrer-Policy"), "no-referrer") << path;
    EXPECT_EQ(answer->get_header_value("X-Content-Type-Options"), "nosniff") << path;
  }
}

TEST_F(Server, PagesOutOfTheFoldersGetNoPartInThisOne) {
  const auto page = get("api/file?id=0/report.html");
  EXPECT_EQ(page->status, 200);
  EXPECT_EQ(page->get_header_value("Content-Security-Policy"),
            "sandbox allow-scripts allow-downloads; default-src 'none'; "
            "script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
            "img-src data: blob:; base-uri 'none'; form-action 'none'");
  EXPECT_EQ(page->get_header_value("X-Content-Type-Options"), "nosniff");
}

TEST_F(Server, TwoTabsDoNotOverwriteEachOther) {
  const auto read = get("api/text?id=0/track.yaml");
  const std::string mark = read->get_header_value("ETag");
  const auto put = [&](const std::string& id, const std::string& text,
                       const httplib::Headers& headers) {
    return client_->Put(at("api/text?id=" + id), headers, text, "text/plain")->status;
  };
  EXPECT_EQ(put("0/track.yaml", "mesh: b.obj\n", {{"If-Match", mark}}), 200);
  EXPECT_EQ(folder_.read("shown/track.yaml"), "mesh: b.obj\n");
  EXPECT_EQ(put("0/track.yaml", "mesh: c.obj\n", {{"If-Match", mark}}), 412);
  EXPECT_EQ(put("0/track.yaml", "mesh: c.obj\n", {}), 428);
  EXPECT_EQ(put("0/track.yaml", "mesh: c.obj\n", {{"If-None-Match", "*"}}), 412);
  EXPECT_EQ(folder_.read("shown/track.yaml"), "mesh: b.obj\n");
  EXPECT_EQ(put("0/new.yaml", "mesh: d.obj\n", {{"If-None-Match", "*"}}), 200);
  EXPECT_EQ(folder_.read("shown/new.yaml"), "mesh: d.obj\n");
  EXPECT_EQ(put("0/a.obj", "x", {{"If-None-Match", "*"}}), 403);
  EXPECT_EQ(put("0/../new.yaml", "x", {{"If-None-Match", "*"}}), 404);
  EXPECT_EQ(put("0/big.yaml", std::string(5'000'000, 'x'), {{"If-None-Match", "*"}}), 413);
  EXPECT_FALSE(std::filesystem::exists(folder_.path("shown/big.yaml")));
}

TEST_F(Server, GivesChannelsAsNumbers) {
  const nlohmann::json log = json("api/log?id=0/log.csv");
  EXPECT_EQ(log["format"], "CSV");
  EXPECT_EQ(log["channels"][3]["name"], "speed");
  EXPECT_EQ(log["channels"][3]["values"], 2);
  const std::string bytes = get("api/channels?id=0/log.csv&name=speed&name=x_m")->body;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data(), 4);
  const nlohmann::json head = base::parse_json<nlohmann::json>(bytes.substr(4, length));
  EXPECT_EQ(head["arrays"][0]["name"], "speed");
  ASSERT_EQ(bytes.size(), 4 + length + 6 * sizeof(double));
  std::array<double, 6> values;
  std::memcpy(values.data(), bytes.data() + 4 + length, sizeof values);
  EXPECT_THAT(values, ::testing::ElementsAre(1.0, ::testing::IsNan(), 3.0, 0.0, 1.0, 2.0));
  EXPECT_EQ(get("api/channels?id=0/log.csv&name=nothing")->status, 422);
  EXPECT_EQ(get("api/log?id=0/empty.csv")->status, 422);
  EXPECT_EQ(get("api/road?id=0/log.csv")->status, 422);
  EXPECT_EQ(get("api/text?id=0/empty.csv")->body, "");
  EXPECT_EQ(get("api/part?id=0/points.tiles&begin=3&bytes=4")->body, "3456");
  EXPECT_EQ(get("api/part?id=0/log.csv&begin=3&bytes=4")->status, 403);
}

TEST_F(Server, ShowsNothingThatAKilledRunLeft) {
  folder_.file("shown/points.tiles", "");
  {
    base::OutputSet set(folder_.path("shown"), "tool make");
    base::write_file(set.staged("points.tiles"), "0123456789");
    set.commit("points");
  }
  const auto statuses = [&] {
    return std::vector<int>{get("api/part?id=0/points.tiles&begin=3&bytes=4")->status,
                            get("api/file?id=0/report.html")->status};
  };
  EXPECT_THAT(statuses(), ::testing::ElementsAre(200, 200));
  std::string text = folder_.read("shown/manifest.json");
  const std::string whole = "\"complete\": true";
  folder_.file("shown/manifest.json",
               text.replace(text.find(whole), whole.size(), "\"complete\": false"));
  EXPECT_THAT(statuses(), ::testing::ElementsAre(422, 422));
  EXPECT_THAT(get("api/road?id=0/points.tiles")->body, HasSubstr("was killed"));
}

TEST_F(Server, RunsTheToolsAndNothingElse) {
  const auto post = [&](const std::string& body) {
    return client_->Post(at("api/job"), body, "application/json");
  };
  const auto begun = post(R"({"do": "preview", "input": "0/a.obj"})");
  ASSERT_EQ(begun->status, 200) << begun->body;
  const nlohmann::json wish = base::parse_json<nlohmann::json>(begun->body);
  EXPECT_EQ(wish["command"],
            base::parse_json<nlohmann::json>(R"(["crgbuild", "preview", "a.obj", "-o", "-"])"));
  EXPECT_EQ(ended_job(wish["id"])["exit_code"], 0);
  EXPECT_THAT(get("api/output?job=" + std::to_string(wish["id"].get<int>()))->body,
              ::testing::StartsWith("glTF"));
  for (const char* const body :
       {"", "[]", "1", "{", R"({"do": "sh", "input": "0/a.obj"})", R"({"do": 1})",
        R"({"do": "build"})", R"({"do": "build", "input": ["-o", "/etc"]})",
        R"({"do": "build", "input": "0/../secret.csv"})",
        R"({"do": "report", "road": "0/a.obj", "mesh": "--help"})"})
    EXPECT_THAT(post(body)->status, ::testing::AnyOf(400, 404)) << body;
  EXPECT_EQ(client_->Post(at("api/live?job=1"), "{}", "application/json")->status, 404);
  for (const char* const port : {"0", "65536", "-1", "x"})
    EXPECT_EQ(
        client_->Post(at(std::string("api/live?watch=") + port), "{}", "application/json")->status,
        400)
        << port;
  const auto nobody = client_->Post(at("api/live?watch=9"), "{}", "application/json");
  EXPECT_EQ(nobody->status, 200);
  EXPECT_EQ(nobody->body, "{}") << "nothing has come";
  EXPECT_EQ(get("api/output?job=x")->status, 400);
  EXPECT_EQ(get("api/output?job=77")->status, 422);
}

/// Sends bytes as they are; what comes back until the server closes or half a second is silent.
std::string raw(int port, const std::string& bytes) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string out;
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    const timeval patience{0, 20'000};
    ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    ::shutdown(socket, SHUT_WR);
    std::array<char, 4096> buffer;
    ssize_t got = 0;
    while ((got = ::recv(socket, buffer.data(), buffer.size(), 0)) > 0)
      out.append(buffer.data(), static_cast<std::size_t>(got));
  }
  ::close(socket);
  return out;
}

TEST_F(Server, LivesThroughMalformedRequests) {
  std::mt19937 random(1);
  const auto request = [&](const std::string& begin, const std::string& headers,
                           const std::string& body) {
    return begin.substr(0, begin.find(' ') + 1) + at(begin.substr(begin.find(' ') + 1)) +
           " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) +
           "\r\nX-Kerbstone-Token: " + kToken + "\r\n" + headers +
           "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
  };
  const std::vector<std::string> requests = {
      request("GET api/text?id=0/track.yaml", "Range: bytes=0-4\r\n", "abc"),
      request("GET api/channels?id=0/log.csv&name=speed&name=x_m", "", ""),
      request("GET api/part?id=0/points.tiles&begin=0&bytes=10", "Range: bytes=0-4\r\n", ""),
      request("GET api/difference?id=0/log.csv&against=0/log.csv&u_begin=1&u_end=1e9", "", ""),
      request("GET api/place?id=0/track.yaml&x=1&y=nan", "", ""),
      request("PUT api/text?id=0/track.yaml", "If-Match: \"00\"\r\n", "mesh: b.obj\n"),
      request("POST api/live?job=1", "", R"({"input.throttle": 1})"),
      request("POST api/job", "", R"({"do": "keep", "road": "0/none.crg"})"),
      request("DELETE api/job?id=1", "", "")};
  const int count = std::getenv("KERBSTONE_HEAVY") != nullptr ? 10'000 : 300;
  for (int k = 0; k < count; ++k) {
    std::string bytes = requests[static_cast<std::size_t>(k) % requests.size()];
    for (unsigned n = 1 + random() % 6; n > 0; --n) {
      const std::size_t at = random() % bytes.size();
      switch (random() % 4) {
        case 0:
          bytes[at] = static_cast<char>(random());
          break;
        case 1:
          bytes.erase(at, random() % 20);
          break;
        case 2:
          bytes.insert(at, bytes.substr(at, random() % 40));
          break;
        default:
          bytes.insert(at, std::string(random() % 3000, static_cast<char>(random())));
      }
    }
    EXPECT_THAT(raw(port_, bytes), ::testing::Not(HasSubstr("secret\n")));
  }
  raw(port_, "GET /" + std::string(100'000, 'x') + " HTTP/1.1\r\n\r\n");
  raw(port_,
      "PUT " + at("api/text?id=0/x.yaml") + " HTTP/1.1\r\nContent-Length: 99999999999999\r\n\r\n");
  EXPECT_EQ(json("api/list")["entries"].size(), 5U);
  EXPECT_EQ(folder_.read("shown/track.yaml"), "mesh: a.obj\n");
}

TEST(RandomToken, DiffersEachTime) {
  EXPECT_NE(view::random_token(), view::random_token());
  EXPECT_GE(view::random_token().size(), view::kShortestToken);
}

}  // namespace server_test
