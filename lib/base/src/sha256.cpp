#include "base/sha256.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/auxv.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <utility>

#include "base/error.h"
#include "base/read_file.h"

namespace base {

namespace {

/// One hash in the making. `what` stands in front of its errors.
class Hash {
 public:
  explicit Hash(std::string what) : what_(std::move(what)) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1)
      throw Error(fmt::format("{}: SHA-256 is not available in this OpenSSL", what_));
  }

  void add(const char* bytes, std::size_t count) {
    if (count > 0 && EVP_DigestUpdate(context_.get(), bytes, count) != 1)
      throw Error(fmt::format("{}: SHA-256 failed", what_));
  }

  std::string hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
    unsigned int size = 0;
    if (EVP_DigestFinal_ex(context_.get(), digest.data(), &size) != 1)
      throw Error(fmt::format("{}: SHA-256 failed", what_));
    std::string text;
    for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
    return text;
  }

 private:
  std::string what_;
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_{EVP_MD_CTX_new(),
                                                                   &EVP_MD_CTX_free};
};

}  // namespace

std::string sha256(std::string_view bytes) {
  Hash hash("bytes in memory");
  hash.add(bytes.data(), bytes.size());
  return hash.hex();
}

Answer<std::string> try_sha256_of_file(const std::string& path) {
  if (auto refused = no_regular_file(path)) return *std::move(refused);
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    return Refusal(
        fmt::format("{}: cannot read: {}; give a file that exists", path, std::strerror(errno)));
  }
  Hash hash(path);
  std::array<char, 1 << 16> buffer;
  while (in) {
    in.read(buffer.data(), buffer.size());
    hash.add(buffer.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad() || !in.eof())
    return Refusal(fmt::format("{}: cannot read: {}", path, std::strerror(errno)));
  return hash.hex();
}

std::string sha256_of_file(const std::string& path) { return try_sha256_of_file(path).or_throw(); }

const std::string& sha256_of_program() {
  static const std::string hash = [] {
    // In a Python module the running program is the interpreter: not that, but the file that this
    // code was loaded from.
    Dl_info here{}, program{};
    // getauxval() gives addresses as numbers.
    // NOLINTBEGIN(performance-no-int-to-ptr)
    const bool known = ::dladdr(reinterpret_cast<void*>(&sha256_of_program), &here) != 0 &&
                       ::dladdr(reinterpret_cast<void*>(::getauxval(AT_PHDR)), &program) != 0;
    // NOLINTEND(performance-no-int-to-ptr)
    const bool in_module = known && here.dli_fbase != program.dli_fbase;
    return sha256_of_file(in_module ? here.dli_fname : "/proc/self/exe");
  }();
  return hash;
}

}  // namespace base
