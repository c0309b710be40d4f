// Catch2 3 by the names of version 2, which the tests are written for: Debian 12 has 2.13, Debian 13 has 3.7.
#pragma once

#include <catch2/catch_all.hpp>
#include <string>

namespace Catch {

using TestEventListenerBase = EventListenerBase;
using Matchers::EndsWith;
using Matchers::Equals;
using Matchers::Matches;
using Matchers::StartsWith;

/// A text that holds another one; of version 3 the name is that of a matcher of ranges.
inline auto Contains(const std::string& text, CaseSensitive is = CaseSensitive::Yes) {
  return Matchers::ContainsSubstring(text, is);
}
namespace Matchers {
inline auto Contains(const std::string& text, CaseSensitive is = CaseSensitive::Yes) {
  return ContainsSubstring(text, is);
}
}  // namespace Matchers

}  // namespace Catch

using Catch::Approx;
