// run_verb carries out one verb of a person on an instrument, from the opening of its port to the report.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "files/port_address.h"
#include "firn/camera_frame_t.hpp"
#include "firn/device_state_t.hpp"
#include "firn/gas_flow_t.hpp"
#include "firn/height_profile_t.hpp"
#include "firn/temperature_t.hpp"
#include "print/device/device_verbs.h"
#include "print/labs/product.h"

namespace firn {

struct DeviceJob {
  const Product& product;
  Experiment e = {};
  std::string node = {};
  const DeviceVerb* verb = nullptr;
  std::vector<double> values = {};
  bool far = false;
  double within_s = 120.0;  ///< longest wait for the end of an order
};

struct DeviceSinks {
  std::function<void(const std::string& line, bool ordered)> tape;  ///< as DeviceSession; after the order?
  std::function<void(const std::string&)> note;
  std::function<void(const device_state_t&)> state;  ///< at each change
  std::function<bool()> interrupted;
  bool watch = false;  ///< status: goes on until interrupted
};

struct DeviceReport {
  int status = 0;    ///< files/exit_codes.h
  std::string text;  ///< of the outcome
  std::optional<device_state_t> state;
  std::optional<temperature_t> temperature;
  std::optional<gas_flow_t> gas;
  std::vector<height_profile_t> profiles;
  std::vector<camera_frame_t> frames;
  std::vector<double> readings_mm;  ///< of the point laser; NaN = no value
};

/// @throws std::runtime_error: the host of a TCP port is not known; UsageError: the lab has no such node, or
/// a value is beyond the range of the order's message; then no port is opened
DeviceReport run_verb(const DeviceJob& job, const PortAddress& address, const DeviceSinks& sinks);

/// Returns "mean 0.0123, standard deviation 0.0004, from … to … mm; 100 of 100 readings", or of a zero the
/// key that takes it.
std::string readings_text(const DeviceJob& job, const std::vector<double>& readings_mm);

}  // namespace firn
