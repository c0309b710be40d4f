// Driver holds the common part of all drivers: the link, opening anew with backoff, the state and its
// announcement. A driver is a pure state machine: bytes and the time come in, bytes, events and the next wake
// go out.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>

#include "drivers/link/link.h"
#include "drivers/link/service.h"

namespace firn::drivers {

class Driver {
 public:
  using Measurements = std::tuple<>;  ///< a driver that measures lists its own types
  virtual ~Driver() = default;
  Driver(const Driver&) = delete;  // the link refers to the driver's dialect
  Driver& operator=(const Driver&) = delete;

  void opened(std::int64_t now_us, Effects& fx);
  void closed(std::int64_t now_us, Effects& fx);
  void received(std::span<const std::byte> bytes, std::int64_t now_us, Effects& fx);
  void woke(std::int64_t now_us, Effects& fx);
  /// A driver whose protocol is spoken by a program has two ports: the calls above are of the program's,
  /// these of the instrument's line.
  virtual bool has_line() const { return false; }
  void line_opened(std::int64_t now_us, Effects& fx);
  void line_closed(std::int64_t now_us, Effects& fx);
  void line_received(std::span<const std::byte> bytes, std::int64_t now_us, Effects& fx);
  /// Makes the instrument safe. Allowed in every state, as often as wanted; goes ahead of everything else.
  /// The state becomes kSafe when the instrument has confirmed it.
  void safe_stop(std::int64_t now_us, Effects& fx);

  /// A person's order outside of a print, by name; a Result follows. "reset": the connection is made anew,
  /// and with it every setting. All others are refused unless the instrument is safe.
  void serve(std::string_view verb, std::span<const double> values, std::int64_t now_us, Effects& fx);

  DeviceState state() const { return state_; }
  /// Returns the state as a sentence says it: (the jet is) "not identified yet"; after a loss with its cause:
  /// "disconnected (port closed)", "not identified yet, since its connection was lost (port closed)".
  std::string standing() const;
  const std::string& identity() const { return identity_; }  ///< as the instrument gave it
  /// A good reply of the instrument has come since the port was opened.
  virtual bool answered() const { return answered_; }
  /// The last line that came for an answer and was none, shown; empty: none.
  const std::string& last_not_understood() const { return link_.not_understood(); }
  /// A command was accepted and its Result is still to come.
  virtual bool busy() const = 0;
  /// The instrument has confirmed that nothing moves, fires or shines, and no stop is under way.
  bool safe() const { return state_ == DeviceState::kSafe && !stopping(); }

  /// A print goes on after a pause, of which no time counts.
  virtual void resumed() {}

 protected:
  explicit Driver(const Dialect& dialect) : link_(dialect) {}

  virtual void connected(std::int64_t now_us, Effects& fx) = 0;  ///< the port is open: begin to identify
  virtual void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                     Effects& fx) = 0;
  /// No good reply came. The link recovers by itself; requests queued now are sent after that.
  virtual void failed(const Request& request, std::int64_t now_us, Effects& fx) = 0;
  virtual void unsolicited(std::span<const std::byte>, std::int64_t, Effects&) {}
  virtual void line_is(bool /*open*/, std::int64_t, Effects&) {}
  virtual void line_said(std::span<const std::byte>, std::int64_t, Effects&) {}
  virtual void lost(std::int64_t now_us, Effects& fx) = 0;  ///< the port is closed
  virtual void stop(std::int64_t now_us, Effects& fx) = 0;  ///< safe_stop of the device
  /// The link is idle. @returns true if something was queued.
  virtual bool idle(std::int64_t now_us, Effects& fx) = 0;
  virtual bool stopping() const = 0;                ///< a stop is under way
  virtual void tick(std::int64_t, Effects&) {}      ///< before anything else, in every call
  virtual std::int64_t device_wake_us() const = 0;  ///< 0 = none

  /// One of the instrument's own orders of serve(): ends in run_service(), a command, or refuse_service().
  virtual void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
                       Effects& fx);
  virtual void permit_reset() {}  ///< the person's reset: latched errors may be cleared
  void run_service(Service service);
  static void refuse_service(std::int32_t code, std::string text, Effects& fx, Figure figure = {});

  void set_state(DeviceState state, std::string_view text, Effects& fx);
  void fault(Severity severity, std::int32_t code, std::string text, Effects& fx, Figure figure = {});
  /// Gives the port up: it is opened anew after a pause.
  void reconnect(std::int64_t now_us, Effects& fx, std::string_view why);
  /// Returns "; not understood: 'A 1.2'": the last line of link_.not_understood(); empty: none.
  std::string not_understood() const;
  void identified() { backoff_us_ = kFirstBackoff; }

  /// Every public call ends with it: handles the events of the link, sends, and sets the next wake.
  void pump(std::int64_t now_us, Effects& fx);

  Link link_;
  std::string identity_;

 private:
  static constexpr std::int64_t kFirstBackoff = 100'000, kLongestBackoff = 5'000'000;

  void went_down(std::int64_t now_us, Effects& fx, std::string_view why);
  // service.cpp
  void service_reply(const LinkEvent& event, std::int64_t now_us, Effects& fx);
  bool advance_service(std::int64_t now_us, Effects& fx);
  void cut_service(std::int64_t now_us, Effects& fx);
  void end_service(Outcome outcome, std::int32_t code, std::string text, Effects& fx);

  DeviceState state_ = DeviceState::kDisconnected;
  DeviceState before_suspect_ = DeviceState::kDisconnected;
  bool answered_ = false;
  std::string lost_why_;  // of a connection that served, and is not there again yet
  std::int64_t reopen_at_us_ = 0;
  std::int64_t backoff_us_ = kFirstBackoff;

  enum class ServiceStep : std::uint8_t { kBegin, kHold, kEnd };
  std::optional<Service> service_;
  decltype(Service::tell) ending_tell_;  // of a service that a stop has cut: its end must be acknowledged
  ServiceStep service_step_ = ServiceStep::kBegin;
  std::int64_t service_until_us_ = 0;  // kHold
  std::string service_text_;
};

}  // namespace firn::drivers
