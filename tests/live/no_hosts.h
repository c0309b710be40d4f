// no_hosts() says and counts a skipped test where this machine gives no other computers (far_hosts.h).
#pragma once

namespace firn::test {

bool no_hosts();

}  // namespace firn::test
