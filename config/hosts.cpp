#include "config/hosts.h"

#include <algorithm>

namespace firn {

bool is_host_name(std::string_view name) {
  return !name.empty() && name.size() <= 40 && std::ranges::all_of(name, [](unsigned char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || c == '_' || c == '-';
  });
}

bool is_host_address(std::string_view address) {
  return !address.empty() && address[0] != '-' && address[0] != ':' &&
         std::ranges::all_of(address, [](unsigned char c) { return c > ' ' && c < 0x7f; });
}

}  // namespace firn
