#include "tests/cli/lined_lab.h"

#include <algorithm>
#include <iostream>
#include <streambuf>
#include <utility>

#include "files/json.h"
#include "print/device/lab_experiment.h"
#include "studies/calibrate/lab_calibrations.h"

namespace firn::test {
namespace {

using Json = nlohmann::json;

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

std::vector<std::string> with_tip_warm(std::vector<std::string> keys) {
  keys.push_back("heater.low_degC=-40");  // at once
  return keys;
}

std::vector<double> flat(const Json& value) {
  return value.is_array() ? value.get<std::vector<double>>() : std::vector<double>{value.get<double>()};
}

}  // namespace

LinedLab::LinedLab(const std::vector<std::string>& keys, double x_mm, double y_mm, double width_mm,
                   double depth_mm)
    : keys_(with_tip_warm(keys)),
      world_(lab_calibrations::with_jig(
          lab_calibrations::with_field(load_lab_experiment(kIce, keys_), x_mm, y_mm, width_mm, depth_mm))) {}

Said LinedLab::calibrate(const std::string& what, bool real, const std::vector<std::string>& more) {
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

std::vector<FoundTwice> found_twice(const std::string& real, const std::string& simulated) {
  const Json on_lines = Json::parse(real), in_time = Json::parse(simulated);
  std::vector<FoundTwice> all;
  for (std::size_t n = 0; n < std::min(on_lines["keys"].size(), in_time["keys"].size()); ++n) {
    const Json &a = on_lines["keys"][n], &b = in_time["keys"][n];
    const std::vector<double> values = flat(a["value"]), others = flat(b["value"]), half = flat(a["half_95"]),
                              other_half = flat(b["half_95"]);
    for (std::size_t k = 0; k < std::min(values.size(), others.size()); ++k)
      all.push_back({a["key"].get<std::string>(), values[k], others[k], half[k] + other_half[k]});
  }
  return all;
}

}  // namespace firn::test
