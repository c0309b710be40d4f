#include "tests/live/no_hosts.h"

#include <string>

#include "tests/live/far_hosts.h"
#include "tests/live/live_checks.h"
#include "tests/support/skip.h"

namespace firn::test {

bool no_hosts() {
  if (skipped()) return true;
  static const std::string why = FarHosts::refused();
  if (why.empty()) return false;
  skip("network-namespace", why);
  return true;
}

}  // namespace firn::test
