#include "files/digest.h"

#include <openssl/evp.h>

#include <stdexcept>

namespace firn {

std::string sha256_hex(std::span<const std::byte> bytes) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest, &size, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("SHA-256 is not available in this OpenSSL");
  std::string hex;
  for (unsigned n = 0; n < size; ++n) {
    hex += "0123456789abcdef"[digest[n] >> 4];
    hex += "0123456789abcdef"[digest[n] & 15];
  }
  return hex;
}

}  // namespace firn
