#include <catch2/catch.hpp>

#include <sched.h>
#include <sys/resource.h>

#include <thread>

#include "runtime/precedence.h"

using firn::Precedence;

namespace {

int policy() { return ::sched_getscheduler(0) & ~SCHED_RESET_ON_FORK; }
int niceness() { return ::getpriority(PRIO_PROCESS, 0); }

}  // namespace

TEST_CASE("a thread with precedence is as it was when that ends") {
  std::thread([] {
    const int policy_before = policy(), nice_before = niceness();
    { const Precedence precedence; }
    CHECK(policy() == policy_before);
    CHECK(niceness() == nice_before);
  }).join();
}

TEST_CASE("where real time is permitted a thread with precedence has it") {
  std::thread([] {
    sched_param param{};
    param.sched_priority = ::sched_get_priority_min(SCHED_RR);
    const bool permitted = policy() == SCHED_OTHER && ::sched_setscheduler(0, SCHED_RR, &param) == 0;
    param.sched_priority = 0;
    if (permitted) REQUIRE(::sched_setscheduler(0, SCHED_OTHER, &param) == 0);
    const int before = policy();
    const Precedence precedence;
    CHECK(policy() == (permitted ? SCHED_RR : before));
  }).join();
}

TEST_CASE("threads that one with precedence begins are scheduled as usual") {
  std::thread([] {
    const int nice_before = niceness();
    const Precedence precedence;
    std::thread([&] {
      CHECK(policy() == SCHED_OTHER);
      CHECK((niceness() == nice_before || niceness() == 0));
    }).join();
  }).join();
}
