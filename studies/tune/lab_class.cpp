#include "studies/tune/lab_class.h"

#include <algorithm>
#include <cmath>

namespace firn::tune {
namespace {

// Centres are the plant's own defaults or round numbers beside them; spreads cover the keys' ranges.
constexpr LabParameter kDroplets[] = {
    {"plant.flow", "", 1.0, 0.2, 0.5, 2.0},
    {"plant.spread", "", 1.0, 0.1, 0.75, 1.5},
    {"plant.size_std", "", 0.03, 0.7, 0.0, 0.3},
    {"plant.placement_std_mm", "mm", 0.008, 0.7, 0.0, 0.1},
    {"plant.missed_fraction", "", 0.002, 1.0, 0.0, 0.1},
    {"plant.drift", "", 0.08, 0.8, 0.002, 0.5},
    {"plant.sensor_noise_mm", "mm", 0.001, 0.8, 0.0, 0.02},
    {"plant.dropout_fraction", "", 0.005, 1.0, 0.0, 0.3},
    {"flight that the stage does not lead", "s", 0.0, 3e-4, -1e-3, 1e-3, true},
    {"pressure that a droplet takes", "", 3e-5, 1.2, 1e-6, 1e-3},
};
constexpr LabParameter kHeightChange[] = {
    {"h1 + 4 h2 + 4 h3", "mm", 0.0082, 0.2, 0.002, 0.03},
    {"4 h2 / h1", "", 0.55, 0.4, 0.02, 4.0},
    {"4 h3 / h1", "", 0.18, 0.5, 0.005, 4.0},
    {"plant.variation", "", 0.2, 0.7, 0.0, 1.0},
    {"plant.sensor_noise_mm", "mm", 0.001, 0.8, 0.0, 0.02},
    {"plant.dropout_fraction", "", 0.005, 1.0, 0.0, 0.3},
};

constexpr LabParameter kIce[] = {
    {"plant.ice.flow_water_mm3_s", "mm^3/s", 200.0, 0.1, 10.0, 250.0},
    {"plant.ice.flow_sme_mm3_s", "mm^3/s", 200.0, 0.1, 10.0, 250.0},
    {"1 + plant.ice.drift_water", "", 1.0, 0.1, 0.7, 1.3},
    {"1 + plant.ice.drift_sme", "", 1.0, 0.1, 0.7, 1.3},
    {"plant.ice.roughness", "", 0.28, 0.5, 0.0, 1.0},
    {"plant.ice.debris_per_h", "1/h", 0.4, 0.8, 0.0, 1000.0},
    {"the laser's noise", "mm", 0.015, 0.7, 0.0, 0.5},
};

void set_droplets(std::span<const double> v, Experiment& e) {
  e.plant.model = "droplets";
  e.plant.flow = v[0];
  e.plant.spread = v[1];
  e.plant.size_std = v[2];
  e.plant.placement_std_mm = v[3];
  e.plant.missed_fraction = v[4];
  e.plant.drift = v[5];
  e.plant.sensor_noise_mm = v[6];
  e.plant.dropout_fraction = v[7];
}

void droplet_nature(std::span<const double> v, plant::WorldConfig& w) {
  w.droplet.flight_time_s += v[8];
  w.nozzle.pressure_per_drop = v[9];
}

void set_height_change(std::span<const double> v, Experiment& e) {
  e.plant.model = "lu2015";
  e.plant.variation = v[3];
  e.plant.sensor_noise_mm = v[4];
  e.plant.dropout_fraction = v[5];
}

void set_ice(std::span<const double> v, Experiment& e) {
  e.plant.ice.flow_water_mm3_s = v[0];
  e.plant.ice.flow_sme_mm3_s = v[1];
  e.plant.ice.drift_water = v[2] - 1.0;
  e.plant.ice.drift_sme = v[3] - 1.0;
  e.plant.ice.roughness = v[4];
  e.plant.ice.debris_per_h = v[5];
}

void ice_noise(std::span<const double> v, plant::WorldConfig& w) { w.ice.laser.ice_noise_mm = v[6]; }

// The mean droplet of the plant is 1 + variation / 2 times as large as its constants.
void height_change_constants(std::span<const double> v, plant::WorldConfig& w) {
  const double whole_mm = v[0] / (1.0 + 0.5 * v[3]);
  w.lu2015.h1_mm = whole_mm / (1.0 + v[1] + v[2]);
  w.lu2015.h2_mm = 0.25 * v[1] * w.lu2015.h1_mm;
  w.lu2015.h3_mm = 0.25 * v[2] * w.lu2015.h1_mm;
}

constexpr LabClass kClasses[] = {
    {"droplets", "droplets that fly, land, flow and drift", kDroplets, &set_droplets, &droplet_nature},
    {"height change", "the height-change model with droplets of varying size", kHeightChange,
     &set_height_change, &height_change_constants, true},
};

}  // namespace

double LabParameter::value(double z) const {
  return std::clamp(either_sign ? centre + spread * z : centre * std::exp(spread * z), low, high);
}

std::vector<double> LabClass::values(std::span<const double> z) const {
  std::vector<double> out;
  for (std::size_t p = 0; p < parameters.size(); ++p) out.push_back(parameters[p].value(z[p]));
  return out;
}

std::span<const LabClass> lab_classes(Deposition deposition) {
  static constexpr LabClass kIceClasses[] = {
      {"ice", "valves that flow and drift over ice that freezes rough", kIce, &set_ice, &ice_noise}};
  if (deposition == Deposition::kPaths) return kIceClasses;
  if (deposition == Deposition::kDroplets) return kClasses;
  return {};
}

Experiment without_plant(Experiment e) {
  e.plant = PlantConfig{};
  e.bus = BusConfig{};
  e.devices = DevicesConfig{};
  return e;
}

}  // namespace firn::tune
