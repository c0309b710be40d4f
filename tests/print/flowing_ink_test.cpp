// Interlock 12 of droplets in whole prints of labs whose ink flows farther than the planner's model says.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "config/include.h"
#include "firn/deposition_report_t.hpp"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"

using namespace firn;

namespace {

struct FlowLab {
  const char *flow, *kappa_side, *steps, *noise_mm, *dropout;
};
// Held-out labs 1023, 1041, 1036 and 1022 of the world graph flow (experiments/worlds/inkjet.toml).
constexpr FlowLab kFlowLabs[] = {{"0.809794", "0.0495962", "15", "0.00381517", "0.0292261"},
                                 {"1.18863", "0.0498032", "16", "0.00216584", "0.0146807"},
                                 {"0.823026", "0.00829574", "12", "0.00156837", "0.0220061"},
                                 {"1.07239", "0.0413507", "16", "0.00157691", "0.0284233"}};

struct FlowedPrint {
  runs::RunResult result;
  int layers = 0;
};

FlowedPrint flowed(const FlowLab& lab, std::vector<std::string> settings) {
  const std::filesystem::path folder = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";
  for (const auto& [key, value] : {std::pair{"flow", lab.flow},
                                   {"graph_flow.kappa_side", lab.kappa_side},
                                   {"graph_flow.steps", lab.steps},
                                   {"sensor_noise_mm", lab.noise_mm},
                                   {"dropout_fraction", lab.dropout}})
    settings.push_back(std::string("plant.") + key + "=" + value);
  settings.insert(settings.end(), {"plant.model=graph_flow", "part.height_mm=0.1"});
  const Experiment e = load_experiment(folder / "cylinder.toml", settings);
  FlowedPrint p;
  MemoryPrintOptions o;
  o.tap = [&](std::string_view channel, std::span<const std::byte> bytes) {
    deposition_report_t d{};
    if (channel == "DEPOSITION_REPORT" && d.decode(bytes.data(), 0, int(bytes.size())) > 0)
      p.layers = int(d.layer);
  };
  p.result = print_in_memory(full_product(), e, make_inputs(full_product(), e, folder), o).result;
  return p;
}

}  // namespace

TEST_CASE("No print is stopped where wet ink flows off the cells of its droplets", "[I12]") {
  for (const FlowLab& lab : kFlowLabs)
    for (const char* scheme : {"threshold", "smf"}) {
      const FlowedPrint p = flowed(lab, {std::string("control.scheme=") + scheme, "control.smf.ki_star=0"});
      INFO(scheme << " at flow " << lab.flow << ", layer " << p.layers << ": " << p.result.reason);
      CHECK(p.result.outcome != "stopped safely");
    }
}

TEST_CASE("A nozzle that dies where wet ink flows far is found within two layers", "[I12]") {
  for (const FlowLab& lab : kFlowLabs)
    for (const int dies : {1, 4, 9}) {
      const FlowedPrint p =
          flowed(lab, {"control.scheme=smf", "plant.nozzle.dead_layer=" + std::to_string(dies)});
      INFO("flow " << lab.flow << ", dead from layer " << dies);
      CHECK_THAT(p.result.reason, Catch::Contains("the nozzle is dead"));
      CHECK(p.layers < dies + 2);
    }
}
