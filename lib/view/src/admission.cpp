#include "admission.h"

#include "base/sha256.h"
#include "same_text.h"

namespace view {

std::string key_of_file(const std::string& token, const std::string& id) {
  return base::sha256(token + '\n' + id + '\n' + token);
}

std::optional<Refusal> refusal_of(const Asked& asked, const std::string& authority,
                                  const std::string& token) {
  const std::string port = authority.substr(authority.rfind(':'));
  if (asked.host != authority && asked.host != "localhost" + port)
    return Refusal(403, "this page answers under its own address only");
  if (asked.origin && *asked.origin != "http://" + asked.host)
    return Refusal(403, "asked for by another page");
  if (asked.path == "/" || is_same(asked.token, token)) return std::nullopt;
  if (asked.path == "/api/file" && is_same(asked.key, key_of_file(token, asked.id)))
    return std::nullopt;
  return Refusal(404, "nothing here; use the whole address that 'kerbstone view' printed");
}

}  // namespace view
