#include "view/server.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "admission.h"
#include "agreed.h"
#include "base/error.h"
#include "base/json_text.h"
#include "base/output_set.h"
#include "base/read_file.h"
#include "base/sha256.h"
#include "base/text_lines.h"
#include "base/write_file.h"
#include "bounded_server.h"
#include "crg/file.h"
#include "file_part.h"
#include "kept.h"
#include "live_link.h"
#include "numbers.h"
#include "page.h"
#include "same_text.h"
#include "tile_heights.h"
#include "view/folders.h"
#include "view/jobs.h"
#include "wish.h"

namespace view {
namespace {

namespace fs = std::filesystem;
using httplib::Request, httplib::Response;
using nlohmann::ordered_json;

constexpr std::size_t kLargestText = kMostBody, kLargestFile = 300'000'000;
constexpr const char *kJson = "application/json", *kBytes = "application/octet-stream",
                     *kPolicy = "Content-Security-Policy";

/// As it is: what set_content() sends, cpp-httplib packs by brotli's slowest mode, a second per
/// megabyte.
void send(Response& response, std::string bytes, const char* type) {
  if (!response.has_header(kPolicy))
    response.set_header(kPolicy, "default-src 'none'; sandbox; frame-ancestors 'none'");
  if (bytes.empty()) return response.set_content(bytes, type);
  const auto kept = std::make_shared<const std::string>(std::move(bytes));
  response.set_content_provider(
      kept->size(), type, [kept](std::size_t begin, std::size_t length, httplib::DataSink& sink) {
        return sink.write(kept->data() + begin, length);
      });
}

class Pages {
 public:
  explicit Pages(const ServerOptions& options)
      : options_(options), folders_(options.folders), jobs_(options.tools) {}

  /// Nothing of what follows is reached without this.
  bool may(const Request& request, Response& response, const std::string& authority) {
    Asked asked{
        request.path, request.get_header_value("Host"), request.get_header_value(kTokenHeader),
        {},           request.get_param_value("id"),    request.get_param_value("key")};
    if (request.has_header("Origin")) asked.origin = request.get_header_value("Origin");
    const auto refusal = refusal_of(asked, authority, options_.token);
    if (refusal) refuse(response, refusal->status, refusal->what());
    return !refusal;
  }

  void set_up(httplib::Server& server) {
    const auto by = [this](void (Pages::*answer)(const Request&, Response&)) {
      return httplib::Server::Handler([this, answer](const Request& request, Response& response) {
        guarded(response, [&] { (this->*answer)(request, response); });
      });
    };
    server.Get("/", by(&Pages::page_itself));
    for (const auto& [name, answer] :
         std::initializer_list<std::pair<const char*, void (Pages::*)(const Request&, Response&)>>{
             {"list", &Pages::list},
             {"text", &Pages::text},
             {"file", &Pages::file},
             {"part", &Pages::part},
             {"heights", &Pages::heights},
             {"road", &Pages::road},
             {"place", &Pages::place},
             {"profile", &Pages::profile},
             {"difference", &Pages::difference},
             {"result", &Pages::result},
             {"log", &Pages::log},
             {"channels", &Pages::channels},
             {"places", &Pages::places},
             {"jobs", &Pages::jobs},
             {"output", &Pages::output},
             {"unit", &Pages::unit}})
      server.Get(std::string("/api/") + name, by(answer));
    server.Put("/api/text", by(&Pages::write_text));
    server.Post("/api/job", by(&Pages::start_job));
    server.Post("/api/live", by(&Pages::drive));
    server.Delete("/api/job", by(&Pages::stop_job));
  }

 private:
  template <class Answer>
  static void guarded(Response& response, const Answer& answer) {
    try {
      answer();
    } catch (const Refusal& refusal) {
      refuse(response, refusal.status, refusal.what());
    } catch (const std::bad_alloc&) {
      refuse(response, 507, "not enough memory");
    } catch (const std::exception& error) {
      refuse(response, 422, error.what());
    }
  }

  static void refuse(Response& response, int status, const std::string& why) {
    response.status = status;
    send(response, base::dump_json(ordered_json{{"error", why}}), kJson);
  }

  static int number_of(const Request& request, const char* key) {
    const auto number = base::to_number<int>(request.get_param_value(key));
    if (!number) throw Refusal(400, fmt::format("{}: a number wanted", key));
    return *number;
  }

  static double metres_of(const Request& request, const char* key) {
    const auto value = base::to_number<double>(request.get_param_value(key));
    if (!value || !std::isfinite(*value))
      throw Refusal(400, fmt::format("{}: a number wanted", key));
    return *value;
  }

  std::string asked_path(const Request& request, const char* key = "id", bool may_be_new = false) {
    try {
      return folders_.path_of(request.get_param_value(key), may_be_new);
    } catch (const base::Error& error) {
      throw Refusal(404, error.what());
    }
  }

  /// Throws Error where a killed run left files of two runs there.
  std::string path_in_set(const Request& request, const char* key = "id") {
    std::string path = asked_path(request, key);
    base::files_of_set(fs::path(path).parent_path().string());
    return path;
  }

  std::shared_ptr<const crg::Surface> road_of(const Request& request, const char* key = "id") {
    return roads_.of(path_in_set(request, key));
  }

  void page_itself(const Request& /*request*/, Response& response) {
    // Scripts and styles of the page stand in it; it fetches from here alone.
    response.set_header(
        kPolicy,
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
        "img-src 'self' data: blob:; connect-src 'self'; frame-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    response.set_content_provider(
        page().size(), "text/html; charset=utf-8",
        [](std::size_t begin, std::size_t length, httplib::DataSink& sink) {
          return sink.write(page().data() + begin, length);
        });
  }

  void list(const Request& /*request*/, Response& response) {
    const Listing listing = folders_.list();
    ordered_json entries = ordered_json::array(), roots = ordered_json::array();
    for (const Entry& entry : listing.entries) {
      entries.push_back({{"id", entry.id},
                         {"kind", to_string(entry.kind)},
                         {"bytes", entry.bytes},
                         {"modified_s", entry.modified_s}});
      if (entry.kind == Kind::report || entry.kind == Kind::picture)
        entries.back()["key"] = key_of_file(options_.token, entry.id);
    }
    for (std::size_t k = 0; k < folders_.size(); ++k) roots.push_back(folders_.root(k));
    json(response, {{"folders", roots},
                    {"opened", options_.opened},
                    {"demo", !options_.demo.empty()},
                    {"whole", listing.is_whole},
                    {"entries", entries}});
  }

  void text(const Request& request, Response& response) {
    const std::string bytes = base::read_file(asked_path(request), kLargestText);
    response.set_header("ETag", '"' + base::sha256(bytes) + '"');
    send(response, bytes, "text/plain; charset=utf-8");
  }

  /// The text as a whole, where it is still the one that was read (If-Match), or none is there yet
  /// (If-None-Match: *).
  void write_text(const Request& request, Response& response) {
    const std::string path = asked_path(request, "id", true);
    const std::string ending = fs::path(path).extension().string();
    if (ending != ".yaml" && ending != ".csv")
      throw Refusal(403, "only recipes (.yaml) and tables (.csv) are written from here");
    const std::lock_guard lock(writing_);
    const bool is_there = fs::exists(path);
    const std::string known = request.get_header_value("If-Match");
    if (known.empty() ? request.get_header_value("If-None-Match") != "*" : false)
      throw Refusal(428, "If-Match or If-None-Match: * wanted");
    if (known.empty() ? is_there : !is_there || known != '"' + base::sha256_of_file(path) + '"')
      throw Refusal(412, "the file has changed meanwhile (another tab or program); read it again");
    base::write_file(path, request.body);
    response.set_header("ETag", '"' + base::sha256(request.body) + '"');
    send(response, "{}", kJson);
  }

  void file(const Request& request, Response& response) {
    static const std::map<std::string, const char*> types = {
        {".html", "text/html; charset=utf-8"}, {".png", "image/png"}, {".json", kJson},
        {".csv", "text/csv; charset=utf-8"},   {".glb", kBytes},      {".crg", kBytes}};
    const std::string path = path_in_set(request);
    const auto type = types.find(fs::path(path).extension().string());
    if (type == types.end()) throw Refusal(403, "not a kind of file that is shown here");
    // A stranger's page gets no part in this one, and loads nothing; its address opens itself
    // alone.
    response.set_header(kPolicy,
                        "sandbox allow-scripts allow-downloads; default-src 'none'; "
                        "script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                        "img-src data: blob:; base-uri 'none'; form-action 'none'");
    send(response, base::read_file(path, kLargestFile), type->second);
  }

  void part(const Request& request, Response& response) {
    const auto value = [&](const char* key) { return request.get_param_value(key); };
    send(response, part_of_file(path_in_set(request), value("begin"), value("bytes")), kBytes);
  }

  /// Points of a tile over a road: metres each, NaN where there is no road below or above.
  void heights(const Request& request, Response& response) {
    const TilePlace place{
        request.get_param_value("begin"),
        request.get_param_value("points"),
        {metres_of(request, "x"), metres_of(request, "y"), metres_of(request, "z")}};
    const auto road = road_of(request, "road");
    send(response, heights_over(*road, path_in_set(request), place), kBytes);
  }

  void road(const Request& request, Response& response) {
    send(response, packed_road(*road_of(request)), kBytes);
  }

  void place(const Request& request, Response& response) {
    send(response, place_json(*road_of(request), metres_of(request, "x"), metres_of(request, "y")),
         kJson);
  }

  void profile(const Request& request, Response& response) {
    const auto at = [&](const char* key) { return metres_of(request, key); };
    send(response, packed_profile(*road_of(request), {at("x0"), at("y0")}, {at("x1"), at("y1")}),
         kBytes);
  }

  void difference(const Request& request, Response& response) {
    send(response,
         packed_difference(*road_of(request), *road_of(request, "against"),
                           metres_of(request, "u_begin"), metres_of(request, "u_end")),
         kBytes);
  }

  void log(const Request& request, Response& response) {
    send(response, channels_json(*logs_.of(asked_path(request))), kJson);
  }

  void channels(const Request& request, Response& response) {
    std::vector<std::string> names;
    for (std::size_t k = 0; k < request.get_param_value_count("name"); ++k)
      names.push_back(request.get_param_value("name", k));
    send(response, packed_channels(*logs_.of(asked_path(request)), names), kBytes);
  }

  void places(const Request& request, Response& response) {
    send(response,
         packed_places(*logs_.of(asked_path(request)), request.get_param_value("x"),
                       request.get_param_value("y"), *road_of(request, "road")),
         kBytes);
  }

  void jobs(const Request& /*request*/, Response& response) {
    ordered_json jobs = ordered_json::array();
    for (const Job& job : jobs_.list())
      jobs.push_back({{"id", job.id},
                      {"command", job.command},
                      {"folder", job.folder},
                      {"running", job.is_running},
                      {"exit_code", job.exit_code},
                      {"seconds", job.seconds},
                      {"progress", job.progress},
                      {"messages", job.messages},
                      {"output_bytes", job.output_bytes}});
    json(response, jobs);
  }

  void output(const Request& request, Response& response) {
    send(response, jobs_.output(number_of(request, "job")), kBytes);
  }

  void stop_job(const Request& request, Response& response) {
    jobs_.stop(number_of(request, "id"));
    send(response, "{}", kJson);
  }

  void start_job(const Request& request, Response& response) {
    const Wish wish =
        wish_of(base::parse_json<ordered_json>(request.body, false), folders_, options_.demo);
    if (!wish.unit.empty()) agreed_.check(wish.unit, wish.agreed);
    const int id = jobs_.start(wish.command, folders_.root(0));
    if (wish.port != 0) links_.drive(id, wish.port);
    json(response, {{"id", id}, {"command", wish.command}, {"result", wish.result}});
  }

  /// What the bytes of a unit are, and whether they may run.
  void unit(const Request& request, Response& response) {
    const std::string sha256 = base::sha256_of_file(asked_path(request));
    json(response, {{"sha256", sha256}, {"agreed", agreed_.has(sha256)}});
  }

  void result(const Request& request, Response& response) {
    json(response, {{"result", result_of(asked_path(request))}});
  }

  /// One command to the drive that runs, and what it measured last ({}: nothing yet); or what is
  /// measured in a run that somebody else drives, at a UDP port of this machine.
  void drive(const Request& request, Response& response) {
    const std::string seen = request.has_param("watch")
                                 ? links_.watch(number_of(request, "watch"))
                                 : links_.tell(number_of(request, "job"), request.body);
    send(response, seen.empty() ? "{}" : seen, kJson);
  }

  static void json(Response& response, const ordered_json& value) {
    send(response, base::dump_json(value), kJson);
  }

  const ServerOptions& options_;
  Folders folders_;
  Jobs jobs_;
  Kept<recording::Log> logs_{
      [](const std::string& path) { return recording::in_rows(recording::read_log(path), path); }};
  Kept<crg::Surface, 3> roads_{[](const std::string& path) {
    base::check_in_set(path);
    return crg::Surface(crg::read(path));
  }};
  std::mutex writing_;
  LiveLinks links_;
  Agreed agreed_;
};

}  // namespace

void serve(const ServerOptions& options,
           const std::function<void(const std::string& address, const std::function<void()>& stop)>&
               told) {
  if (page().empty())
    throw base::Error(
        "this program was built without the page; run scripts/setup (it needs node and npm) and "
        "build again");
  Pages pages(options);
  BoundedServer server([&](const Request& request) {
    return is_same(request.get_header_value(kTokenHeader), options.token);
  });
  const int port = options.port == 0
                       ? server.bind_to_any_port(options.host)
                       : (server.bind_to_port(options.host, options.port) ? options.port : -1);
  if (port < 0)
    throw base::Error(
        fmt::format("{}:{}: cannot listen there; is it in use? --port 0 takes any "
                    "that is free",
                    options.host, options.port));
  const std::string authority = fmt::format("{}:{}", options.host, port);
  server.set_default_headers({{"X-Content-Type-Options", "nosniff"},
                              {"Referrer-Policy", "no-referrer"},
                              {"Cache-Control", "no-store"},
                              {"Cross-Origin-Resource-Policy", "same-origin"}});
  server.set_pre_routing_handler([&](const Request& request, Response& response) {
    return pages.may(request, response, authority) ? httplib::Server::HandlerResponse::Unhandled
                                                   : httplib::Server::HandlerResponse::Handled;
  });
  pages.set_up(server);
  told(fmt::format("http://{}/#{}", authority, options.token), [&server] {
    while (!server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    server.stop();
  });
  if (!server.listen_within_bounds()) throw base::Error(authority + ": listening has ended");
}

}  // namespace view
