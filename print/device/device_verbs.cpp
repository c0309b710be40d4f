#include "print/device/device_verbs.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/options/number.h"
#include "files/usage_error.h"
#include "firn/camera_command_t.hpp"
#include "firn/enums.h"
#include "firn/gas_command_t.hpp"
#include "firn/heater_command_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/laser_command_t.hpp"
#include "firn/profiler_command_t.hpp"
#include "firn/robot_command_t.hpp"
#include "firn/service_order_t.hpp"
#include "firn/stage_command_t.hpp"

namespace firn {
namespace {

using Values = std::vector<double>;

constexpr std::int32_t kMaxRows = 1'000'000;

DeviceOrder home(const DeviceCall& call, const OrderStamp& stamp) {
  if (call.node == "robot") {
    robot_command_t c{};
    c.verb = std::int8_t(RobotVerb::kHome);
    return order_of(channels::kRobotCommand, c, stamp);
  }
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kHome);
  return order_of(channels::kStageCommand, c, stamp);
}

DeviceOrder move(const DeviceCall& call, const OrderStamp& stamp) {
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kMove);
  c.x_mm = call.values[0];
  c.y_mm = call.values[1];
  c.z_mm = call.values[2];
  c.speed_mm_s = call.values[3];
  return order_of(channels::kStageCommand, c, stamp);
}

DeviceOrder expose(const DeviceCall& call, const OrderStamp& stamp) {
  lamp_command_t c{};
  c.verb = std::int8_t(LampVerb::kExpose);
  c.exposure_s = call.values[0];
  c.iris_percent = std::int32_t(std::lround(std::clamp(call.values[1], -1.0, 1e6)));
  return order_of(channels::kLampCommand, c, stamp);
}

DeviceOrder set_temperatures(const DeviceCall& call, const OrderStamp& stamp) {
  heater_command_t c{};
  c.verb = std::int8_t(HeaterVerb::kSet);
  for (int n = 0; n < 3; ++n) c.set_degC[n] = call.values[std::size_t(n)];
  return order_of(channels::kHeaterCommand, c, stamp);
}

DeviceOrder set_gas(const DeviceCall& call, const OrderStamp& stamp) {
  gas_command_t c{};
  c.verb = std::int8_t(GasVerb::kSet);
  c.atomizer_sccm = call.values[0];
  c.sheath_sccm = call.values[1];
  return order_of(channels::kGasCommand, c, stamp);
}

DeviceOrder reading(const DeviceCall&, const OrderStamp& stamp) {
  laser_command_t c{};
  c.verb = std::int8_t(LaserVerb::kReading);
  return order_of(channels::kLaserCommand, c, stamp);
}

DeviceOrder arm_profiler(const DeviceCall& call, const OrderStamp& stamp) {
  profiler_command_t c{};
  c.verb = std::int8_t(ProfilerVerb::kArm);
  c.rows = c.rows_of_scan = std::int32_t(std::clamp(call.values[0], 0.0, double(kMaxRows)));
  c.scan_id = 1;
  return order_of(channels::kProfilerCommand, c, stamp);
}

DeviceOrder end_profiles(const DeviceCall&, const OrderStamp& stamp) {
  profiler_command_t c{};
  c.verb = std::int8_t(ProfilerVerb::kEnd);
  c.scan_id = 1;
  return order_of(channels::kProfilerCommand, c, stamp);
}

DeviceOrder sweep(const DeviceCall& call, const OrderStamp& stamp) {
  camera_command_t c{};
  c.verb = std::int8_t(CameraVerb::kSweep);
  c.sweep_id = 1;
  c.frames = 1;
  if (!call.values.empty()) {
    c.frames = std::int32_t(std::clamp(call.values[0], 0.0, 1e6));
    c.delay_us = call.values[1];
    c.step_us = call.values[2];
  }
  c.gain_db = call.e.camera.gain_db;
  return order_of(channels::kCameraCommand, c, stamp);
}

// An order of the driver's own table.
DeviceOrder serve(const DeviceCall& call, const OrderStamp& stamp) {
  service_order_t c{};
  c.node = call.node;
  c.verb = call.verb;
  c.values = call.values;
  if (call.verb == "jog") c.values.push_back(call.far ? 1.0 : 0.0);
  c.n = std::int32_t(c.values.size());
  return order_of(channels::kServiceOrder, c, stamp);
}

constexpr DeviceVerb kVerbs[] = {
    {"", "identify", "", 0, "who answers, and in which state it is", nullptr, true},
    {"", "status", "", 0, "the same, and what it measures", nullptr, true},
    {"", "stop", "", 0, "makes it safe", nullptr, true},
    {"", "serial", "", 0, "who it is, with the serial number where it tells one", &serve, true},
    {"", "reset", "", 0, "sets it up anew; latched errors are cleared", &serve, true},
    {"stage", "home", "", 0, "homes the axes", &home},
    {"stage", "move", "X Y Z SPEED [mm, mm/s]", 4, "moves to a place within the limits", &move},
    {"stage", "jog", "DX DY DZ SPEED [mm, mm/s]", 4, "moves from where it is, 5 mm and 10 mm/s at most",
     &serve},
    {"stage", "where", "", 0, "its place", &serve, true},
    {"stage", "params", "", 0, "the controller's own parameters", &serve, true},
    {"stage", "pulse", "N PITCH [mm]", 2, "N pulses to the jet, one each PITCH along x", &serve},
    {"jet", "fire", "N", 1, "N droplets, those of one second at most", &serve},
    {"jet", "continuous", "SECONDS [s]", 1, "droplets until the time is over", &serve},
    {"jet", "waveform", "DWELL ECHO DWELL_US ECHO_US [V, us]", 4, "until the next connection", &serve},
    {"jet", "strobe", "DIVIDER DELAY [us]", 2, "flashes; until the next connection", &serve},
    {"lamp", "expose", "SECONDS IRIS [s, %]", 2, "opens the shutter for a time", &expose},
    {"lamp", "shutter", "SECONDS [s]", 1, "the same with the iris as it is", &serve},
    {"lamp", "on", "", 0, "lights the lamp", &serve},
    {"lamp", "off", "", 0, "closes the shutter and puts the lamp out", &serve},
    {"lamp", "iris", "PERCENT", 1, "sets the iris", &serve},
    {"lamp", "hours", "", 0, "hours of the lamp", &serve, true},
    {"laser_profiler", "read", "", 0, "its newest profile", &serve, true},
    {"laser_profiler", "errors", "", 0, "errors that it holds", &serve, true},
    {"laser_profiler", "batch", "N SECONDS [s]", 2, "N triggered profiles, or those until the time is over",
     &arm_profiler, true, &end_profiles},
    {"laser_point", "read", "", 0, "one distance", &reading, true},
    {"laser_point", "accuracy", "N", 1, "mean and scatter of N readings", &reading, true, nullptr, true},
    {"laser_point", "zero", "N", 1, "the offset that makes the mean of N readings 0", &reading, true, nullptr,
     true},
    {"camera", "read", "", 0, "one picture", &sweep, true},
    {"camera", "sweep", "N DELAY STEP [us]", 3, "N pictures at strobe delays from DELAY on", &sweep, true},
    {"camera", "setup", "EXPOSURE GAIN DELAY [us, dB, us]", 3, "for the next picture", &serve, true},
    {"robot", "home", "", 0, "power, calibration, up", &home},
    {"robot", "where", "", 0, "its joints", &serve, true},
    {"robot", "jog", "JOINT BY [deg, mm]", 2, "turns one joint from where it is, 5 deg or mm at most",
     &serve},
    {"robot", "lines", "N", 1, "lines a second that the link carries", &serve, true},
    {"valve_a", "spit", "N", 1, "N pulses, 20 ms apart", &serve},
    {"heater", "read", "", 0, "temperatures and set points", nullptr, true},
    {"heater", "set", "TIP LASER CONDUIT [degC]", 3, "set points; below -50 = off", &set_temperatures},
    {"gas", "read", "", 0, "flows, set points and pressures", nullptr, true},
    {"gas", "set", "ATOMIZER SHEATH [sccm]", 2, "flows, which go on until the next order", &set_gas},
};

std::string_view verb_kind(std::string_view node) {
  return node == "valve_b" ? "valve_a" : node == "jet_b" ? "jet" : node;
}

}  // namespace

std::vector<const DeviceVerb*> verbs_of(std::string_view node) {
  std::vector<const DeviceVerb*> verbs;
  for (const DeviceVerb& v : kVerbs)
    if (v.node.empty() || v.node == verb_kind(node)) verbs.push_back(&v);
  return verbs;
}

const DeviceVerb& device_verb(std::string_view node, std::string_view name) {
  std::string known;
  for (const DeviceVerb* v : verbs_of(node)) {
    if (v->name == name) return *v;
    known += (known.empty() ? "" : ", ") + std::string(v->name) +
             (v->values.empty() ? "" : " " + std::string(v->values));
  }
  throw UsageError(fmt::format("{} has no verb '{}'; known: {}", node, name, known));
}

Values verb_values(const DeviceVerb& verb, const std::vector<std::string>& texts) {
  if (texts.size() != verb.count)
    throw UsageError(fmt::format("{} takes {} values{}{}, not {}", verb.name, verb.count,
                                 verb.values.empty() ? "" : ": ", verb.values, texts.size()));
  Values values;
  for (const std::string& text : texts) {
    const auto v = whole_number<double>(text);
    if (!v) throw UsageError(fmt::format("{}: '{}' is no number", verb.name, text));
    values.push_back(*v);
  }
  return values;
}

}  // namespace firn
