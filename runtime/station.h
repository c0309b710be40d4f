// Station holds a member of the bus that is not replayed: recorder and launcher. It numbers, keeps and
// resends its messages as nodes do; its file nodes/<name>.sent holds its messages for a resume and for the
// repair of the log.
#pragma once

#include <memory>
#include <string>

#include "runtime/bus.h"
#include "runtime/heartbeat.h"
#include "runtime/outbox.h"
#include "runtime/process.h"
#include "runtime/transport.h"
#include "runtime/wal_file.h"

namespace firn {

class Station {
 public:
  /// @throws std::runtime_error if nodes/<name>.sent cannot be opened
  Station(const ProcessOptions& options, Bus& bus, Transport::Deliver deliver);

  void subscribe(std::string_view channel) { transport_.subscribe(channel); }
  /// After a resume: `message` was handled before.
  void restore_received(std::string_view channel, std::span<const std::byte> m) {
    transport_.restore_received(channel, m);
  }
  /// Listens, and starts its heartbeat.
  void join();
  void set_state(Heartbeat::State state) { heartbeat_->set_state(state); }

  template <class Message>
  void send(const Channel<Message>& channel, Message message) {
    outbox_.begin(clock_.now(), options_.incarnation);
    outbox_.send(channel, std::move(message));
    send_outbox();
  }
  /// Takes arrived messages, asks for missing ones, sends waiting ones; does not block.
  void service();
  int fd() const { return bus_.fd(); }
  std::int64_t due_us() const;  ///< wall time of the next service() that has something to do
  Time now() const { return clock_.now(); }
  const Transport& transport() const { return transport_; }
  std::vector<std::string> take_notices() { return transport_.take_notices(); }

 private:
  void send_outbox();

  ProcessOptions options_;
  Bus& bus_;
  RunClock clock_;
  WalFile sent_;
  Outbox outbox_;
  Transport transport_;
  Lossy lossy_;
  std::unique_ptr<Heartbeat> heartbeat_;
  std::uint64_t steps_ = 0;
};

}  // namespace firn
