// The local page and what it asks for, over HTTP. cpp-httplib stays private.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace view {

struct ServerOptions {
  std::vector<std::string> folders;  ///< what may be seen; results go below the first
  std::string opened;                ///< id of the file that the page begins with; empty: none
  std::string tools;                 ///< the folder with the programs of Kerbstone
  std::string demo;                  ///< the circuit.yaml that the tour begins with; empty: none
  std::string token;                 ///< at least kShortestToken letters and digits
  std::string host = "127.0.0.1";
  int port = 0;  ///< 0: any that is free
};
constexpr std::size_t kShortestToken = 16;

/// 32 hexadecimal digits, of the system's random numbers.
std::string random_token();

/// Calls `told` once it can be reached, then serves until `stop` is called (by another thread) or
/// this process ends; commands that run end with it. Answers nothing but the empty page without the
/// token, and nothing under another host's name or to another origin's page. Throws Error where it
/// cannot listen.
void serve(
    const ServerOptions& options,
    const std::function<void(const std::string& address, const std::function<void()>& stop)>& told);

}  // namespace view
