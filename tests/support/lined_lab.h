// LinedLab is an ice lab whose instruments stand behind serial lines and a TCP port, with the block on its
// table and a cup on a balance: what `firn calibrate` finds there by the clock is held against simulated
// time.
#pragma once

#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <streambuf>
#include <string>
#include <utility>
#include <vector>

#include "print/device/lab_experiment.h"
#include "print/device/simulated_instruments.h"
#include "studies/calibrate/lab_calibrations.h"
#include "tests/cli/run_firn.h"
#include "tests/live/port_bridge.h"

namespace firn::test {

/// The person at stdin, who reads the balance anew for each line.
class BalanceReader : public std::streambuf {
 public:
  explicit BalanceReader(SimulatedInstruments& world) : world_(world), before_(std::cin.rdbuf(this)) {}
  ~BalanceReader() override { std::cin.rdbuf(before_); }
  BalanceReader(const BalanceReader&) = delete;
  BalanceReader& operator=(const BalanceReader&) = delete;

 private:
  int_type underflow() override {
    line_ = std::to_string(world_.weighed_mg(0, ++weighing_)) + "\n";
    setg(line_.data(), line_.data(), line_.data() + line_.size());
    return traits_type::to_int_type(line_[0]);
  }

  SimulatedInstruments& world_;
  std::streambuf* before_;
  std::string line_;
  int weighing_ = 0;
};

class LinedLab {
 public:
  /// The simulated surface lies about (x, y), part frame. @param keys of the lab, besides
  LinedLab(std::vector<std::string> keys, double x_mm, double y_mm, double width_mm, double depth_mm)
      : keys_(with_tip_warm(std::move(keys))),
        world_(lab_calibrations::with_jig(lab_calibrations::with_field(load_lab_experiment(kIce, keys_), x_mm,
                                                                       y_mm, width_mm, depth_mm))) {}

  Said calibrate(const std::string& what, bool real, const std::vector<std::string>& more) {
    std::vector<std::string> words{
        "calibrate", what, kIce,
        "--json",    "-o", (fresh_folder("calibrate-lines-" + what) / "lab.toml").string()};
    words.insert(words.end(), more.begin(), more.end());
    for (const std::string& key : keys_) words.insert(words.end(), {"--set", key});
    const std::pair<const char*, std::string> ports[] = {{"robot", robot_.address()},
                                                         {"valve_a", valve_a_.address(115200)},
                                                         {"valve_b", valve_b_.address(115200)},
                                                         {"laser_point", laser_.address(115200)},
                                                         {"heater", heater_.address(9600)}};
    for (const auto& [node, address] : ports)
      if (real)
        words.insert(words.end(), {"--set", "devices." + std::string(node) + ".port=\"" + address + "\""});
    const BalanceReader person(world_);
    return firn_says(words);
  }

 private:
  static std::vector<std::string> with_tip_warm(std::vector<std::string> keys) {
    keys.push_back("heater.low_degC=-40");  // at once
    return keys;
  }

  std::vector<std::string> keys_;
  SimulatedInstruments world_;
  PortBridge robot_{PortBridge::Kind::kTcp, world_.address("robot").place};
  PortBridge valve_a_{PortBridge::Kind::kSerial, world_.address("valve_a").place};
  PortBridge valve_b_{PortBridge::Kind::kSerial, world_.address("valve_b").place};
  PortBridge laser_{PortBridge::Kind::kSerial, world_.address("laser_point").place};
  PortBridge heater_{PortBridge::Kind::kSerial, world_.address("heater").place};
};

/// A value that was found twice, with the sum of both 95 % half widths.
struct FoundTwice {
  std::string key;
  double real = 0.0, simulated = 0.0, half_95 = 0.0;
  bool alike() const { return std::abs(real - simulated) <= half_95; }
};

/// @param real, simulated what `firn calibrate --json` said
inline std::vector<FoundTwice> found_twice(const nlohmann::json& real, const nlohmann::json& simulated) {
  const auto flat = [](const nlohmann::json& value) {
    return value.is_array() ? value.get<std::vector<double>>() : std::vector<double>{value.get<double>()};
  };
  std::vector<FoundTwice> all;
  for (std::size_t n = 0; n < std::min(real["keys"].size(), simulated["keys"].size()); ++n) {
    const nlohmann::json &a = real["keys"][n], &b = simulated["keys"][n];
    const std::vector<double> values = flat(a["value"]), others = flat(b["value"]), half = flat(a["half_95"]),
                              other_half = flat(b["half_95"]);
    for (std::size_t k = 0; k < std::min(values.size(), others.size()); ++k)
      all.push_back({a["key"].get<std::string>(), values[k], others[k], half[k] + other_half[k]});
  }
  return all;
}

}  // namespace firn::test
