// Some holds an instrument of one class whose kind is chosen when it is made: a node knows the class alone.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "drivers/link/driver.h"

namespace firn::drivers {

/// @tparam Interface of the class of instruments: LampDriver, JetDriver, …
template <class Interface>
class Some {
 public:
  using Measurements = typename Interface::Measurements;
  /// @pre driver is not null
  explicit Some(std::unique_ptr<Interface> driver) : driver_(std::move(driver)) {}

  void opened(std::int64_t now_us, Effects& fx) { driver_->opened(now_us, fx); }
  void closed(std::int64_t now_us, Effects& fx) { driver_->closed(now_us, fx); }
  void received(std::span<const std::byte> bytes, std::int64_t now_us, Effects& fx) {
    driver_->received(bytes, now_us, fx);
  }
  void woke(std::int64_t now_us, Effects& fx) { driver_->woke(now_us, fx); }
  bool has_line() const { return driver_->has_line(); }
  void line_opened(std::int64_t now_us, Effects& fx) { driver_->line_opened(now_us, fx); }
  void line_closed(std::int64_t now_us, Effects& fx) { driver_->line_closed(now_us, fx); }
  void line_received(std::span<const std::byte> bytes, std::int64_t now_us, Effects& fx) {
    driver_->line_received(bytes, now_us, fx);
  }
  void safe_stop(std::int64_t now_us, Effects& fx) { driver_->safe_stop(now_us, fx); }
  void serve(std::string_view verb, std::span<const double> values, std::int64_t now_us, Effects& fx) {
    driver_->serve(verb, values, now_us, fx);
  }
  void resumed() { driver_->resumed(); }
  void permit_reset() {
    if constexpr (requires(Interface & driver) { driver.permit_reset(); }) driver_->permit_reset();
  }
  DeviceState state() const { return driver_->state(); }
  const std::string& identity() const { return driver_->identity(); }
  bool answered() const { return driver_->answered(); }
  const std::string& last_not_understood() const { return driver_->last_not_understood(); }
  bool safe() const { return driver_->safe(); }

  Interface& operator*() { return *driver_; }
  Interface* operator->() { return driver_.get(); }

 private:
  std::unique_ptr<Interface> driver_;
};

}  // namespace firn::drivers
