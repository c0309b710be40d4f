#include "page/api_v1.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "files/json.h"
#include "page/web_rules.h"

namespace firn::page {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kBelow = "/api/v1";

bool is_route(const ApiRoute& route, std::string_view method, std::string_view target) {
  if (route.method != method) return false;
  const auto wanted = path_parts(route.path), given = path_parts(target);
  return std::ranges::equal(wanted, given, [](const std::string& w, const std::string& g) {
    return w == g || (w.starts_with('{') && !g.empty());
  });
}

// A label's value: backslash, quote and line end are escaped.
std::string label(std::string_view text) {
  std::string all = "\"";
  for (const char c : text) {
    if (c == '\\' || c == '"') all += '\\';
    all += c == '\n' ? "\\n" : std::string(1, c);
  }
  return all + "\"";
}

std::string head(std::string_view name, std::string_view help) {
  return fmt::format("# HELP {0} {1}\n# TYPE {0} gauge\n", name, help);
}

}  // namespace

std::optional<std::string> without_version(std::string_view method, std::string_view target) {
  if (target != kBelow && !target.starts_with(std::string(kBelow) + "/")) return std::string(target);
  if (std::ranges::none_of(kApiV1, [&](const ApiRoute& r) { return is_route(r, method, target); }))
    return std::nullopt;
  return "/api" + std::string(target.substr(kBelow.size()));
}

bool is_websocket_target(std::string_view target) {
  const std::string_view path = target.substr(0, target.find('?'));
  return path == "/ws" || is_route({"GET", "/api/v1/runs/{run}/events"}, "GET", path);
}

std::string websocket_run(std::string_view target) {
  return target.starts_with(kBelow) ? path_parts(target).at(3) : run_of(target);
}

std::string metrics_text(const std::string& list) {
  std::map<std::string, int> outcomes;
  std::string layers, errors;
  const Json all = Json::parse(list);
  for (const Json& run : all.at("runs")) {
    ++outcomes[run.value("outcome", "unreadable")];
    if (!run.value("live", false)) continue;
    const std::string of = fmt::format("{{run={},scheme={},state={}}}", label(run.value("label", "")),
                                       label(run.value("scheme", "")), label(run.value("state", "")));
    layers += fmt::format("firn_print_layers{} {}\n", of, run.value("layers", 0));
    if (run.at("rms_um").is_number())
      errors += fmt::format("firn_print_rms_um{} {}\n", of, run.at("rms_um").get<double>());
  }
  std::string text = head("firn_runs", "Run folders by the way that their prints ended.");
  for (const auto& [outcome, count] : outcomes)
    text += fmt::format("firn_runs{{outcome={}}} {}\n", label(outcome), count);
  return text + head("firn_print_layers", "Layers of a print that goes on.") + layers +
         head("firn_print_rms_um", "RMS error of the last map of a print that goes on, in um.") + errors;
}

}  // namespace firn::page
