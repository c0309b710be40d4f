#include <cerrno>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "core/options/arguments.h"
#include "files/run_paths.h"
#include "plant/world/serve.h"
#include "plant/world/world.h"

namespace firn::plant {
ServeOptions parse_serve_options(const std::vector<std::string>& arguments) {
  ServeOptions o;
  const auto folder = [](std::filesystem::path& to) { return [&to](const std::string& text) { to = text; }; };
  const std::function<void(const std::string&)> not_used;
  const ProcessArgument table[] = {
      {"--run", folder(o.run)},
      {"--io", folder(o.io)},
      {"--control-fd", &o.control_fd},
      {"--epoch-ns", &o.epoch_ns},
      {"--offset-us", &o.offset_us},
      {"--time-scale", &o.time_scale},
      {"--line-speed", &o.line_speed},
      {"--nature",
       [&](const std::string& text) {
         if (text != "steady") throw std::invalid_argument("--nature " + text + ": must be steady");
         o.steady = true;
       }},
      {"--instruments",
       [&](const std::string& text) {
         if (text != "quick") throw std::invalid_argument("--instruments " + text + ": must be quick");
         o.quick = true;
       }},
      {"--incarnation", not_used},
      {"--run-id", not_used},
      {"--bus", not_used},
      {"--port", [&](const std::string& text) { o.elsewhere.insert(text.substr(0, text.find('='))); }},
      {"--node", not_used},
      {"--blob",
       [&](const std::string& text) {
         const auto at = text.find('=');
         if (at == std::string::npos || at == 0)
           throw std::invalid_argument("--blob " + text + ": must be ROLE=SHA256");
         o.blobs.emplace_back(text.substr(0, at), text.substr(at + 1));
       }},
      {"--faults", not_used},
      {"--record", not_used},
  };
  read_arguments(arguments, table);
  if (o.run.empty()) throw std::invalid_argument("--run is missing: the run folder");
  if (!(o.time_scale > 0.0 && o.time_scale <= 1e6))
    throw std::invalid_argument("--time-scale must be above 0, at most 1e6");
  if (!(o.line_speed >= 1.0 && o.line_speed <= 1e6))
    throw std::invalid_argument("--line-speed must be at least 1, at most 1e6");
  if (o.io.empty()) o.io = RunPaths(o.run).ports_path();
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
