// Who is answered. Private to lib/view.
#pragma once

#include <optional>
#include <string>

#include "wish.h"

namespace view {

constexpr const char* kTokenHeader = "X-Kerbstone-Token";

/// What a request says of who asks.
struct Asked {
  std::string path, host, token;
  std::optional<std::string> origin;
  std::string id, key;  ///< of a file
};

/// Opens one file and nothing else: for frames and pictures, which send no header. Whoever has it
/// cannot reckon the token from it.
std::string key_of_file(const std::string& token, const std::string& id);

/// Why nothing is answered; nothing: it is. `authority`: host and port where this listens. The page
/// itself ("/") holds no secret, and is given without the token.
std::optional<Refusal> refusal_of(const Asked& asked, const std::string& authority,
                                  const std::string& token);

}  // namespace view
