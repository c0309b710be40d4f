#include "replay/verdict.h"

#include <algorithm>

namespace firn::replay {

const char* word(FindingKind kind) {
  switch (kind) {
    case FindingKind::kUnreadable:
      return "unreadable";
    case FindingKind::kForeign:
      return "foreign";
    case FindingKind::kMissing:
      return "missing";
    case FindingKind::kOrder:
      return "order";
    case FindingKind::kTimer:
      return "timer";
    case FindingKind::kDelivery:
      return "delivery";
    case FindingKind::kCrash:
      return "crash";
    case FindingKind::kOutput:
      return "output";
    case FindingKind::kLog:
      return "log";
  }
  return "";
}

int RunVerdict::exit_status() const {
  if (identical()) return 0;
  const auto unreadable = [](const Finding& f) { return f.kind == FindingKind::kUnreadable; };
  return damage.empty() && altered.empty() && std::ranges::all_of(findings, unreadable) ? 2 : 1;
}

}  // namespace firn::replay
