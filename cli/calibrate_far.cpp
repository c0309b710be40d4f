#include "cli/calibrate_far.h"

#include <fmt/format.h>

#include <map>
#include <stdexcept>

#include "config/devices.h"
#include "estimators/calibration/robust_fit.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/hosts/at_host.h"

namespace firn {
namespace {

constexpr const char* kMachineFile = "machine.toml";

std::vector<std::string> far_words(const CalibrateLabOptions& o) {
  std::vector<std::string> words{o.what,    kLabHere, "--json", "--seed", std::to_string(o.run.seed),
                                 "--valve", o.valve};
  const auto list = [&](const char* option, const std::vector<double>& values) {
    std::string text;
    for (const double v : values) text += (text.empty() ? "" : ",") + fmt::format("{}", v);
    if (!text.empty()) words.insert(words.end(), {option, text});
  };
  if (o.run.repeats > 0) words.insert(words.end(), {"--repeats", std::to_string(o.run.repeats)});
  list("--speeds", o.run.speeds_mm_s);
  list("--frequencies", o.run.frequencies_hz);
  list("--dwells", o.run.dwells_us);
  list("--voltages", o.run.voltages_v);
  if (o.run.velocity_m_s > 0.0) list("--velocity", {o.run.velocity_m_s});
  if (!o.plot.empty()) words.insert(words.end(), {"--plot", "-"});
  return words;
}

std::vector<double> values_in(const nlohmann::json& j) {
  return j.is_array() ? j.get<std::vector<double>>() : std::vector<double>{j.get<double>()};
}

}  // namespace

std::string host_of_calibration(const Experiment& lab) {
  std::map<std::string, std::string> of_host;  // an instrument of each
  for (const auto& [node, address] : outside_ports(lab)) of_host.emplace(host_of(lab, node), node);
  if (of_host.empty()) return {};
  if (of_host.size() > 1) {
    std::string all;
    for (const auto& [host, node] : of_host)
      all += (all.empty() ? "" : ", ") + node + (host.empty() ? " here" : " at host " + host);
    throw UsageError("a calibration needs its instruments at one computer, where their signals meet: " + all +
                     "; docs/hosts.md");
  }
  return of_host.begin()->first;
}

LabCalibration lab_calibration_in(const std::string& text) try {
  const nlohmann::json j = nlohmann::json::parse(text);
  if (j.contains("uninformative")) throw calibration::Unidentifiable(j["uninformative"].get<std::string>());
  LabCalibration c;
  c.what = j.at("what");
  for (const nlohmann::json& k : j.at("keys")) {
    const std::string name = k.at("key");
    const auto dot = name.find('.');
    FoundKey found;
    found.section = name.substr(0, dot);
    found.key = name.substr(dot + 1);
    found.unit = k.at("unit");
    found.value = values_in(k.at("value"));
    found.ci95_half_width = values_in(k.at("half_95"));
    found.believed = values_in(k.at("believed"));
    found.digits = k.at("digits");
    found.list = k.at("value").is_array();
    c.keys.push_back(std::move(found));
  }
  for (const nlohmann::json& also : j.at("also"))
    c.also.emplace_back(also.at("what"),
                        calibration::Estimate{also.at("value"), also.at("std"), also.at("half_95")});
  c.lines = j.at("lines").get<std::vector<std::string>>();
  c.level = j.at("level");
  c.data = j.at("data");
  c.outliers = j.at("outliers");
  c.residual_std = j.at("residual_std");
  c.residual_unit = j.at("residual_unit");
  c.lab_s = j.at("lab_s");
  c.picture = j.value("svg", "");
  return c;
} catch (const nlohmann::json::exception&) {
  throw std::runtime_error("no answer of firn calibrate --json");
}

LabCalibration calibrate_at_host(const Experiment& lab, const std::string& host,
                                 const CalibrateLabOptions& options, const std::string& machine) {
  Experiment there = lab;
  std::vector<FileOfLab> files;
  if (!machine.empty()) {
    there.ice.machine = kMachineFile;
    files.push_back({kMachineFile, machine});
  }
  std::string answer;
  const int code = run_at_host(there, host, "calibrate", far_words(options), files, &answer);
  if (answer.empty())
    throw std::runtime_error("host " + host + ": the calibration ended with exit code " +
                             std::to_string(code) + " and without a result");
  return lab_calibration_in(answer);
}

}  // namespace firn
