#include "config/labs.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string>

#include "config/aerosol_lab.h"
#include "config/lab_checks.h"
#include "core/options/for_people.h"

namespace firn {
namespace {

// The file of an ink-jet lab does not contain lab.kind: the dump is the same as before kinds were introduced.
constexpr std::string_view kInkjetKeys[] = {
    "run.",     "grid.",           "part.",    "geometry.", "model.",     "actuation.", "control.",
    "process.", "stage.",          "jet.",     "jet_b.",    "estimator.", "lamp.",      "plant.",
    "bus.",     "laser_profiler.", "devices.", "camera.",   "watch.",     "hosts.",     "nodes."};
constexpr std::string_view kNotInkjet[] = {"plant.ice.",
                                           "plant.aerosol.",
                                           "control.smf.speed_range",
                                           "control.smf.version",
                                           "control.foresee.",
                                           "devices.robot.",
                                           "devices.valve_a.",
                                           "devices.valve_b.",
                                           "devices.laser_point.",
                                           "devices.heater.",
                                           "process.most_beside_share",
                                           "process.beside_mm",
                                           "devices.gas.",
                                           "process.most_path_error_mm"};
constexpr std::string_view kInkjetCoupled[] = {"stage", "jet", "jet_b", "laser_profiler"};
constexpr std::string_view kIceCoupled[] = {"robot", "valve_a", "valve_b", "laser_point"};
constexpr LabProcess kInkjetProcesses[] = {
    {"stage"},
    {"jet"},
    {"jet_b", &has_two_jets},
    {"laser_profiler"},
    {"lamp"},
    {"camera", [](const Experiment& e) { return on(e.camera.use); }},
    {"droplet_watch", [](const Experiment& e) { return on(e.camera.use); }},
    {"droplet_estimator", [](const Experiment& e) { return e.estimator.droplets != "off"; }},
};

constexpr std::string_view kIceKeys[] = {"run.",
                                         "bus.",
                                         "hosts.",
                                         "nodes.",
                                         "lab.",
                                         "ice.",
                                         "robot.",
                                         "valve_a.",
                                         "valve_b.",
                                         "laser_point.",
                                         "heater.",
                                         "flow.",
                                         "calibration.",
                                         "plant.ice.",
                                         "plant.seed",
                                         "control.scheme",
                                         "control.smoothing",
                                         "control.target_offset_mm",
                                         "control.smf.kp",
                                         "control.smf.ki_star",
                                         "control.smf.kd_star",
                                         "control.smf.output_limit",
                                         "control.smf.integral_limit",
                                         "control.smf.speed_range",
                                         "control.smf.version",
                                         "control.foresee.",
                                         "control.extra.",
                                         "process.max_rescans",
                                         "process.min_measured_fraction",
                                         "process.most_rise_share",
                                         "devices.robot.",
                                         "devices.valve_a.",
                                         "devices.valve_b.",
                                         "devices.laser_point.",
                                         "devices.heater."};
constexpr std::string_view kNotIce[] = {"heater.platen_degC"};
constexpr LabProcess kIceProcesses[] = {{"robot"},  {"valve_a"},      {"valve_b"},       {"laser_point"},
                                        {"heater"}, {"path_planner"}, {"flow_estimator"}};

constexpr LabKind kInkjetLab{"inkjet",
                             "droplets on a stage [Lu 2015]",
                             Deposition::kDroplets,
                             kInkjetKeys,
                             kNotInkjet,
                             kInkjetProcesses,
                             &check_inkjet_lab,
                             nullptr,
                             kInkjetCoupled};
constexpr LabKind kIceLab{"ice",
                          "the robot arm that prints ice [Barnett 2012]",
                          Deposition::kPaths,
                          kIceKeys,
                          kNotIce,
                          kIceProcesses,
                          &check_ice_lab,
                          nullptr,
                          kIceCoupled,
                          {"pulses", "the nominal height", true}};

constexpr const LabKind* kLabs[] = {
    &kInkjetLab,
    &kIceLab,
    &kAerosolLab,
};

}  // namespace

std::string LabWords::length(double um) const {
  constexpr double kMmPerUm = 1e-3;
  return in_mm ? for_people(um * kMmPerUm) + " mm" : for_people(um) + " um";
}

std::span<const LabKind* const> lab_kinds() { return kLabs; }

const LabKind& lab_kind(std::string_view name) {
  std::string known;
  for (const LabKind* lab : kLabs) {
    if (lab->name == name) return *lab;
    known += (known.empty() ? "" : ", ") + std::string(lab->name);
  }
  throw std::invalid_argument("lab.kind = \"" + std::string(name) + "\" is not one of " + known);
}

const LabKind& lab_of(const Experiment& e) { return lab_kind(e.lab.kind); }

const LabWords& lab_words(std::string_view name) {
  const auto lab = std::ranges::find(kLabs, name, &LabKind::name);
  return (lab == std::end(kLabs) ? kLabs[0] : *lab)->words;
}

bool takes_part(const Experiment& e, std::string_view node) {
  const auto named = [&](const LabProcess& p) { return p.node == node; };
  const LabKind& lab = lab_of(e);
  if (const auto p = std::ranges::find_if(lab.processes, named); p != lab.processes.end())
    return !p->wanted || p->wanted(e);
  return std::ranges::none_of(kLabs,
                              [&](const LabKind* l) { return std::ranges::any_of(l->processes, named); });
}

}  // namespace firn
