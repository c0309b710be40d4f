// Precedence lets a thread that a stop or a lease passes through go before the machine's other work.
#pragma once

namespace firn {

/// While it lives, the calling thread is scheduled in real time (SCHED_RR, lowest priority) where the system
/// permits it: CAP_SYS_NICE, or rtprio in /etc/security/limits.conf. Else at nice -10, where that is
/// permitted, else as before. Threads and processes that it begins are scheduled as usual. To be ended by its
/// thread.
class Precedence {
 public:
  Precedence();
  ~Precedence();
  Precedence(const Precedence&) = delete;
  Precedence& operator=(const Precedence&) = delete;

 private:
  int policy_, nice_;  // of before
  bool real_time_;
};

}  // namespace firn
