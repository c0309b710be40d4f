#include "runtime/heartbeat.h"

#include <chrono>
#include <csignal>
#include <iterator>

#include "core/options/enumerators.h"
#include "firn/heartbeat_t.hpp"
#include "firn/journal_t.hpp"

namespace firn {
namespace {

constexpr std::int64_t kPeriodUs = 100'000;
constexpr const char* kEventWords[] = {"",     "start",      "message", "wake-up", "instrument bytes",
                                       "link", "local stop", "refused"};
static_assert(std::size(kEventWords) == kTableSize<EventKind>);

}  // namespace

Heartbeat::Heartbeat(NodeId node, std::int64_t run_id, std::int32_t incarnation, const RunClock& clock,
                     Bus& bus)
    : node_(node), run_id_(run_id), incarnation_(incarnation), clock_(clock), bus_(bus) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);  // signals are for the main thread
  thread_ = std::thread([this] { run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

Heartbeat::~Heartbeat() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Heartbeat::update(std::uint64_t steps, const TransportStats& stats, std::vector<Transport::Last> last) {
  const std::lock_guard lock(mutex_);
  steps_ = steps;
  stats_ = stats;
  last_ = std::move(last);
}

void Heartbeat::note(const Step& step) {
  const std::lock_guard lock(mutex_);
  step_ = step;
}

void Heartbeat::run() {
  std::unique_lock lock(mutex_);
  while (!over_) {
    const auto bytes = encode();
    bus_.publish(channels::heartbeat(node_).name, bytes);
    if (step_.number != journal_told_) {
      journal_told_ = step_.number;
      bus_.publish(channels::journal(node_).name, encode_journal());
    }
    // All processes of a machine beat at the same instants: who hears them wakes up once for all.
    const std::chrono::microseconds left(kPeriodUs - monotonic_us() % kPeriodUs);
    wake_.wait_for(lock, left, [this] { return over_; });
  }
}

std::vector<std::byte> Heartbeat::encode() {
  heartbeat_t m{};
  m.header.run_id = run_id_;
  m.header.incarnation = incarnation_;
  m.header.seq = ++seq_;
  m.header.utime_us = clock_.now().us;
  m.node = info(node_).name;
  m.state = std::int8_t(state_.load());
  m.busy_since_us = busy_since_us_;
  m.steps = std::int64_t(steps_);
  m.lost = std::int64_t(stats_.missing);
  m.resent = std::int64_t(stats_.resent);
  for (const Transport::Last& l : last_) {
    m.channel.emplace_back(l.channel);
    m.last_seq.push_back(l.seq);
  }
  m.n = std::int32_t(last_.size());
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  return bytes;
}

std::vector<std::byte> Heartbeat::encode_journal() {
  journal_t m{};
  m.header.run_id = run_id_;
  m.header.incarnation = incarnation_;
  m.header.seq = ++journal_seq_;
  m.header.utime_us = clock_.now().us;
  m.step = std::int64_t(step_.number);
  m.event = step_.channel.empty() ? kEventWords[std::size_t(step_.kind)] : std::string(step_.channel);
  m.outputs = step_.outputs;
  m.output_bytes = step_.output_bytes;
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  return bytes;
}

}  // namespace firn
