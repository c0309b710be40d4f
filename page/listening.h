// Opens the socket on which browsers reach the page.
#pragma once

#include <string>

namespace firn::page {

struct Listening {
  int fd = -1;
  bool v6 = false;
  int port = 0;
  std::string address;  ///< "http://127.0.0.1:8750/"
};

/// @param port 0: the first free one of some from kFirstPort on, or any
/// @throws UsageError: an address that is none or not this machine's, a port in use
Listening listen_on(const std::string& bind, int port);

}  // namespace firn::page
