#include "print/operator/page_token.h"

#include <sys/random.h>

#include <stdexcept>

namespace firn {

std::string new_page_token() {
  unsigned char bytes[16];
  if (::getrandom(bytes, sizeof bytes, 0) != ssize_t(sizeof bytes))
    throw std::runtime_error("the kernel gives no random numbers");
  std::string token;
  for (const unsigned char b : bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    token += kDigits[b >> 4];
    token += kDigits[b & 15];
  }
  return token;
}

}  // namespace firn
