// The only file that knows OpenSSL.
#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>

#include "text_file.h"
#include "vehicle/error.h"
#include "vehicle/write_file.h"

namespace vehicle {

std::string sha256_of_file(const std::string& path) {
  constexpr std::size_t kLargestFileBytes = std::size_t{4} << 30;
  const std::string bytes = read_text(path, kLargestFileBytes);
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned length = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, EVP_sha256(), nullptr) != 1)
    throw Error(path + ": cannot compute the SHA-256");
  std::string out;
  for (unsigned i = 0; i < length; ++i) out += fmt::format("{:02x}", digest[i]);
  return out;
}

}  // namespace vehicle
