#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "plant/world/serve.h"
#include "plant/world/world.h"

namespace firn::plant {
namespace {

template <class T>
T number(const std::string& name, const std::string& text) {
  T value{};
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
  if (r.ec != std::errc() || r.ptr != text.data() + text.size())
    throw std::invalid_argument(name + " = " + text + ": a number is needed");
  return value;
}

}  // namespace

ServeOptions parse_serve_options(const std::vector<std::string>& arguments) {
  ServeOptions o;
  for (std::size_t n = 0; n < arguments.size(); n += 2) {
    const std::string& name = arguments[n];
    if (n + 1 == arguments.size()) throw std::invalid_argument(name + ": a value is missing");
    const std::string& value = arguments[n + 1];
    if (name == "--run")
      o.run = value;
    else if (name == "--io")
      o.io = value;
    else if (name == "--control-fd")
      o.control_fd = number<int>(name, value);
    else if (name == "--epoch-ns")
      o.epoch_ns = number<std::int64_t>(name, value);
    else if (name == "--offset-us")
      o.offset_us = number<std::int64_t>(name, value);
    else if (name == "--time-scale")
      o.time_scale = number<double>(name, value);
    else if (name == "--port")
      o.elsewhere.insert(value.substr(0, value.find('=')));
    else if (name != "--incarnation" && name != "--run-id" && name != "--bus" && name != "--node" &&
             name != "--blob" && name != "--faults")
      throw std::invalid_argument("unknown argument " + name);
  }
  if (o.run.empty()) throw std::invalid_argument("--run is missing: the run folder");
  if (!(o.time_scale > 0.0 && o.time_scale <= 1e6))
    throw std::invalid_argument("--time-scale must be above 0, at most 1e6");
  if (o.io.empty()) o.io = o.run / "io";
  return o;
}

std::string truth_line(const Truth& truth) {
  char text[64];
  const GridSpec& g = truth.height.spec;
  std::string line = "TRUTH " + std::to_string(truth.exposures) + " " + std::to_string(truth.droplets_fired);
  const auto add = [&](double value) {
    std::snprintf(text, sizeof text, " %a", value);
    line += text;
  };
  add(truth.volume_mm3);
  line += " " + std::to_string(g.nx) + " " + std::to_string(g.ny);
  for (const double v : {g.pitch_x_mm, g.pitch_y_mm, g.origin_x_mm, g.origin_y_mm}) add(v);
  for (const double h : truth.height.cells) add(h);
  return line;
}

}  // namespace firn::plant
