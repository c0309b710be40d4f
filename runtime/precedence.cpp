#include "runtime/precedence.h"

#include <sched.h>
#include <sys/resource.h>

namespace firn {
namespace {

constexpr int kNiceInstead = -10;

}  // namespace

// All three calls concern the calling thread alone: 0 is its number.
Precedence::Precedence()
    : policy_(::sched_getscheduler(0) & ~SCHED_RESET_ON_FORK), nice_(::getpriority(PRIO_PROCESS, 0)) {
  sched_param param{};
  param.sched_priority = ::sched_get_priority_min(SCHED_RR);
  real_time_ = policy_ == SCHED_OTHER && ::sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &param) == 0;
  if (policy_ != SCHED_OTHER || real_time_) return;  // it has more already, or less that somebody wanted
  param.sched_priority = 0;
  if (::setpriority(PRIO_PROCESS, 0, kNiceInstead) == 0)
    ::sched_setscheduler(0, SCHED_OTHER | SCHED_RESET_ON_FORK, &param);
}

Precedence::~Precedence() {
  const sched_param usual{};
  if (real_time_) ::sched_setscheduler(0, SCHED_OTHER | SCHED_RESET_ON_FORK, &usual);
  ::setpriority(PRIO_PROCESS, 0, nice_);
}

}  // namespace firn
