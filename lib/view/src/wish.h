// What the page asks for, as the command that somebody would type in the first folder. Private to
// lib/view.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "view/folders.h"

namespace view {

/// A request that cannot be done, with its status of HTTP.
struct Refusal : base::Error {
  int status;
  Refusal(int code, const std::string& why) : base::Error(why), status(code) {}
};

struct Wish {
  std::vector<std::string> command;
  std::string result;  ///< folder or file that it writes, below the first folder; empty: none
  std::string unit;    ///< file that runs as a program; empty: none
  std::string agreed;  ///< SHA-256 of the unit that may run, as the page says
  int port = 0;        ///< of UDP that a drive listens on; 0: no drive
};

/// {"do": "build", "input": ID} and the like. Files are named as seen from the first folder;
/// nothing of a wish becomes a word of the command as it stands. `demo`: the circuit.yaml of the
/// demo; empty: there is none. Throws Refusal.
Wish wish_of(const nlohmann::ordered_json& wish, const Folders& folders,
             const std::string& demo = {});

/// Where the build of a recipe or a mesh goes: out/aalborg for tracks/aalborg/track.yaml, out/ring
/// for meshes/ring.obj.
std::string result_of(const std::string& path);

}  // namespace view
