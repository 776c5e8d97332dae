#include <fmt/format.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "base/error.h"
#include "base/json_text.h"
#include "command/exit_code.h"
#include "commands.h"
#include "verbs.h"
#include "view/server.h"

namespace kerbstone {

namespace fs = std::filesystem;

bool open_browser(const std::string& address) {
  if (::getenv("DISPLAY") == nullptr && ::getenv("WAYLAND_DISPLAY") == nullptr) return false;
  std::array<std::string, 2> words = {"xdg-open", address};
  std::array<char*, 3> arguments = {words[0].data(), words[1].data(), nullptr};
  pid_t process = -1;
  if (::posix_spawnp(&process, "xdg-open", nullptr, nullptr, arguments.data(), environ) != 0)
    return false;
  int status = 0;
  return ::waitpid(process, &status, 0) == process && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

int view(const ViewCommand& command, command::Terminal& terminal) {
  ::view::ServerOptions options;
  std::string opened;
  for (const std::string& path : command.paths) {
    if (fs::is_directory(path)) {
      options.folders.push_back(path);
      continue;
    }
    if (!fs::exists(path)) throw base::Error(path + ": no such file or folder");
    if (!opened.empty())
      throw base::Error(path + ": one file at most; give the folder that holds them all");
    opened = path;
    const fs::path parent = fs::absolute(path).parent_path();
    options.folders.insert(options.folders.begin(), parent.string());
    options.opened = "0/" + fs::path(path).filename().string();
  }
  if (options.folders.empty()) options.folders.emplace_back(".");
  if (!command.host.empty()) options.host = command.host;
  options.port = command.port;
  options.token = command.token.empty() ? ::view::random_token() : command.token;
  if (options.token.size() < ::view::kShortestToken ||
      !std::all_of(options.token.begin(), options.token.end(),
                   [](unsigned char c) { return std::isalnum(c) != 0; }))
    throw base::Error(
        fmt::format("--token: at least {} letters and digits wanted", ::view::kShortestToken));
  options.tools = own_folder();
  make_tools_found(options.tools);
  options.demo = example_file(options.tools, "tracks/kerbstone-ring/circuit.yaml");
  std::thread clock;
  ::view::serve(options, [&](const std::string& address, const std::function<void()>& stop) {
    terminal.print(terminal.json ? base::json_text(nlohmann::ordered_json{{"address", address}})
                                 : address + "\n");
    terminal.finish();
    if (!command.no_open && !open_browser(address))
      terminal.remark("no browser could be started; open the address yourself");
    if (command.seconds > 0.0)
      clock = std::thread([stop, seconds = command.seconds] {
        std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
        stop();
      });
  });
  if (clock.joinable()) clock.join();
  return 0;
}

}  // namespace kerbstone
