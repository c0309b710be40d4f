// SomeJet is a jet of the kind that its settings name.
#pragma once

#include "drivers/jet/jet_driver.h"

namespace firn::drivers {

/// A jet for a node, which knows its driver's type only as this.
class SomeJet {
 public:
  using Measurements = JetDriver::Measurements;
  /// @throws std::invalid_argument naming the setting and its range
  explicit SomeJet(const JetOptions& config) : jet_(traits_of(config.kind).make(config)) {}

  void opened(std::int64_t now_us, Effects& fx) { jet_->opened(now_us, fx); }
  void closed(std::int64_t now_us, Effects& fx) { jet_->closed(now_us, fx); }
  void received(std::span<const std::byte> bytes, std::int64_t now_us, Effects& fx) {
    jet_->received(bytes, now_us, fx);
  }
  void woke(std::int64_t now_us, Effects& fx) { jet_->woke(now_us, fx); }
  void safe_stop(std::int64_t now_us, Effects& fx) { jet_->safe_stop(now_us, fx); }
  void serve(std::string_view verb, std::span<const double> values, std::int64_t now_us, Effects& fx) {
    jet_->serve(verb, values, now_us, fx);
  }
  DeviceState state() const { return jet_->state(); }
  const std::string& identity() const { return jet_->identity(); }
  bool answered() const { return jet_->answered(); }
  const std::string& last_not_understood() const { return jet_->last_not_understood(); }
  bool safe() const { return jet_->safe(); }

  JetDriver& jet() { return *jet_; }

 private:
  std::unique_ptr<JetDriver> jet_;
};

}  // namespace firn::drivers
