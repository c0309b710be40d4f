// Thermometer reads the temperature of the bed: "T?\n" -> "23.45\n" [degC], "OPEN\n" without a probe.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/link/driver.h"
#include "drivers/link/link_probe.h"
#include "drivers/thermometer/thermometer_config.h"

namespace firn::drivers {

/// @param line a reply without its "\n" @returns degC, NaN for an open probe; nothing for a damaged line
std::optional<double> parse_bed_temperature(std::string_view line);

class ThermometerDialect final : public Dialect {
 public:
  ThermometerDialect();
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override;
};

LinkProbe thermometer_probe();

struct ThermometerOptions : ThermometerConfig {
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

struct BedTemperature {
  double celsius = 0.0;  ///< NaN = open probe
};

class Thermometer final : public Driver {
 public:
  using Measurements = std::tuple<BedTemperature>;
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit Thermometer(ThermometerOptions options);

  bool busy() const override { return false; }  // there are no commands

 private:
  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t, Effects&) override {}  // it does nothing that could be stopped
  bool idle(std::int64_t now_us, Effects& fx) override;
  bool stopping() const override { return false; }
  std::int64_t device_wake_us() const override;

  ThermometerOptions options_;
  ThermometerDialect dialect_;
  bool reads_ = false;
  std::int64_t next_read_us_ = 0;
};

}  // namespace firn::drivers
