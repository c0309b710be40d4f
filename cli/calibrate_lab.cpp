#include "cli/calibrate_lab.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "cli/calibrate_far.h"
#include "cli/output_files.h"
#include "config/devices.h"
#include "config/error.h"
#include "config/include.h"
#include "core/options/number.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/lab_file.h"
#include "files/trimmed.h"
#include "files/usage_error.h"
#include "print/device/lab_experiment.h"
#include "print/progress.h"
#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "studies/calibrate/calibration_lab.h"
#include "studies/reproduce/reproduce.h"

namespace firn {
namespace {

using Calibrate = LabCalibration (*)(const Experiment&, const std::string&, const LabCalibrationOptions&);
struct Kind {
  std::string_view name;
  Calibrate run;  ///< in the ice lab, with the text of its machine
  LabCalibration (*jet)(const Experiment&, const LabCalibrationOptions&) = nullptr;  ///< in an ink-jet lab
};
constexpr std::string_view kPlotInAnswer = "-";
constexpr std::string_view kIceFile = "labs/ice-cobra600.toml", kInkjetFile = "labs/inkjet-lu2015.toml";
constexpr Kind kKinds[] = {
    {"laser-offset", &calibrate_laser_offset}, {"laser-latency", &calibrate_laser_latency},
    {"level-table", &calibrate_table},         {"valve-latency", &calibrate_valve_latency},
    {"flow-curve", &calibrate_flow_curve},     {"jet", nullptr, &calibrate_jet}};

std::string joined(const std::vector<double>& values, int digits, bool list) {
  if (!list) return fmt::format("{:.{}f}", values.at(0), digits);
  std::string s = "[";
  for (std::size_t n = 0; n < values.size(); ++n)
    s += (n ? ", " : "") + fmt::format("{:.{}f}", values[n], digits);
  return s + "]";
}

std::vector<LabKey> lab_keys(const LabCalibration& c) {
  std::vector<LabKey> keys;
  for (const FoundKey& k : c.keys) {
    const bool told =
        std::any_of(k.ci95_half_width.begin(), k.ci95_half_width.end(), [](double h) { return h > 0.0; });
    std::string comment = "firn calibrate " + c.what;
    if (told) comment += fmt::format("; 95 %: +- {} {}", joined(k.ci95_half_width, k.digits, k.list), k.unit);
    keys.push_back({k.section, k.key, joined(k.value, k.digits, k.list), comment});
  }
  return keys;
}

nlohmann::ordered_json calibration_json(const LabCalibration& c) {
  nlohmann::ordered_json keys = nlohmann::ordered_json::array(), also = keys;
  for (const FoundKey& k : c.keys) {
    const auto values = [&](const std::vector<double>& v) {
      return k.list ? nlohmann::ordered_json(v) : nlohmann::ordered_json(v.at(0));
    };
    keys.push_back({{"key", k.section + "." + k.key},
                    {"unit", k.unit},
                    {"digits", k.digits},
                    {"value", values(k.value)},
                    {"half_95", values(k.ci95_half_width)},
                    {"believed", values(k.believed)}});
  }
  for (const auto& [name, e] : c.also)
    also.push_back({{"what", name}, {"value", e.value}, {"std", e.std}, {"half_95", e.ci95_half_width}});
  return {{"what", c.what},
          {"keys", keys},
          {"also", also},
          {"lines", c.lines},
          {"level", c.level},
          {"data", c.data},
          {"outliers", c.outliers},
          {"residual_std", c.residual_std},
          {"residual_unit", c.residual_unit},
          {"lab_s", c.lab_s}};
}

void print_calibration(const LabCalibration& c) {
  for (const FoundKey& k : c.keys) {
    const std::string name = k.section + "." + k.key;
    if (!k.list) {
      fmt::print("{:<26} {:>12} {} +- {} (95 %)   the lab believes {}: off by {:+.{}f}\n", name,
                 joined(k.value, k.digits, false), k.unit, joined(k.ci95_half_width, k.digits, false),
                 joined(k.believed, k.digits, false), k.value[0] - k.believed[0], k.digits);
    } else if (std::any_of(k.ci95_half_width.begin(), k.ci95_half_width.end(),
                           [](double h) { return h > 0.0; })) {
      for (std::size_t n = 0; n < k.value.size(); ++n)
        fmt::print("{:<26} {:>10.3f} Hz {:>10.3f} {} +- {:.3f} (95 %)\n", n == 0 ? name : "",
                   c.keys[0].value[n], k.value[n], k.unit, k.ci95_half_width[n]);
    }
  }
  for (const auto& [name, e] : c.also) {
    if (e.ci95_half_width > 0.0)
      fmt::print("  {}: {:.6g} +- {:.2g} (95 %)\n", name, e.value, e.ci95_half_width);
    else
      fmt::print("  {}: {:.6g}\n", name, e.value);
  }
  for (const std::string& line : c.lines) fmt::print("{}\n", line);
  fmt::print("{} data, {} of them left out as outliers; residual {:.3g} {}; {:.0f} s of the lab's time\n",
             c.data, c.outliers, c.residual_std, c.residual_unit, c.lab_s);
}

// An option that the calibration does not read was meant for another one.
void refuse_unread_options(const CalibrateLabOptions& o) {
  const auto only = [&](bool given, const char* option, std::initializer_list<std::string_view> of) {
    if (!given || std::find(of.begin(), of.end(), o.what) != of.end()) return;
    std::string names;
    for (const std::string_view name : of) names += (names.empty() ? "" : ", ") + std::string(name);
    throw UsageError(std::string(option) + ": not of " + o.what + ", but of " + names);
  };
  only(!o.run.speeds_mm_s.empty(), "--speeds", {"laser-offset", "laser-latency", "valve-latency"});
  only(!o.run.frequencies_hz.empty(), "--frequencies", {"flow-curve"});
  only(!o.run.dwells_us.empty(), "--dwells", {"jet"});
  only(!o.run.voltages_v.empty(), "--voltages", {"jet"});
  only(o.run.velocity_m_s > 0.0, "--velocity", {"jet"});
  only(o.run.rounds > 1, "--rounds", {"level-table"});
  only(o.valve != "a", "--valve", {"valve-latency", "flow-curve"});
}

std::filesystem::path proposal_of(const CalibrateLabOptions& o, const std::filesystem::path& lab) {
  if (o.write) return lab;
  return !o.output.empty() ? std::filesystem::path(o.output)
                           : std::filesystem::path(lab).replace_extension(".proposed.toml");
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  if (std::filesystem::exists(path) && !std::filesystem::is_regular_file(path))
    throw UsageError(path.string() + " is no regular file");
  std::ofstream file(path, std::ios::trunc);
  file << text;
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

Experiment ice_lab(const CalibrateLabOptions& o, const std::string& lab) {
  std::vector<std::string> overrides{"ice.mesh=\"-\""};  // nothing is printed
  overrides.insert(overrides.end(), o.overrides.begin(), o.overrides.end());
  try {
    return load_experiment(lab, overrides);
  } catch (const ConfigError&) {  // of an ink-jet lab, that there is no mesh in it is the lesser news
    bool other = false;
    try {
      other = !has_calibrations(load_experiment(lab));
    } catch (const ConfigError&) {
    }
    if (other) throw UsageError(lab + " is no ice lab's: " + o.what + " is a calibration of that");
    throw;
  }
}

Experiment inkjet_lab(const CalibrateLabOptions& o, const std::string& lab) {
  Experiment e = load_lab_experiment(lab, o.overrides);
  if (!takes_part(e, "jet"))
    throw UsageError(lab + " is no ink-jet lab's: " + o.what + " is a calibration of that");
  return e;
}

// The person at the terminal is the balance of a lab with real ports.
double read_balance(int material, int weighing) {
  for (std::string line;;) {
    std::fprintf(stderr, "weighing %d, cup of %s: reading of the balance [mg]? ", weighing,
                 material == 0 ? "water" : "scaffold");
    if (!std::getline(std::cin, line)) throw std::runtime_error("the balance was not read");
    if (const auto mg = whole_number<double>(trimmed(line))) return *mg;
  }
}

}  // namespace

std::vector<std::string_view> lab_calibration_names() {
  std::vector<std::string_view> names;
  for (const Kind& k : kKinds) names.push_back(k.name);
  return names;
}

bool is_lab_calibration(std::string_view name) {
  return std::any_of(std::begin(kKinds), std::end(kKinds), [&](const Kind& k) { return k.name == name; });
}

std::string residual_svg(const LabCalibration& c) {
  double x0 = 1e300, x1 = -1e300, most = 0.0;
  for (const auto& g : c.plot.groups)
    for (std::size_t n = 0; n < g.x.size(); ++n) {
      x0 = std::min(x0, g.x[n]);
      x1 = std::max(x1, g.x[n]);
      most = std::max(most, std::abs(g.y[n]));
    }
  const double pad = 0.05 * std::max(x1 - x0, 1e-9);
  const report::Frame frame{78, 40, 620, 330};
  const report::Axis x(x0 - pad, x1 + pad, frame.left, frame.right, 7),
      y(-1.1 * most - 1e-9, 1.1 * most + 1e-9, frame.bottom, frame.top, 6);
  std::string s = report::svg_open(650, 420, "residuals of firn calibrate " + c.what);
  s += report::svg_text(0.5 * (frame.left + frame.right), 22, "middle", "name",
                        fmt::format("{}: {} data, standard deviation {:.3g} {}", c.what, c.data,
                                    c.residual_std, c.residual_unit));
  s += report::draw_axes(frame, x, y, c.plot.x_name, c.plot.y_name);
  s += fmt::format("<path class=\"axis\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>", frame.left, y.px(0.0), frame.right);
  double at = frame.left;
  for (std::size_t g = 0; g < c.plot.groups.size(); ++g) {
    const auto& group = c.plot.groups[g];
    const auto mark = [&](double px, double py) {  // told apart without colour too
      if (g % 3 == 0)
        return fmt::format(
            "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.2\" fill=\"none\" stroke=\"var(--c{})\" "
            "stroke-width=\"1.4\"/>",
            px, py, g % 6);
      if (g % 3 == 1)
        return fmt::format(
            "<path d=\"M{:.1f} {:.1f}l6 6m0 -6l-6 6\" fill=\"none\" stroke=\"var(--c{})\" "
            "stroke-width=\"1.4\"/>",
            px - 3, py - 3, g % 6);
      return fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"6\" height=\"6\" fill=\"none\" stroke=\"var(--c{})\" "
          "stroke-width=\"1.4\"/>",
          px - 3, py - 3, g % 6);
    };
    for (std::size_t n = 0; n < group.x.size(); ++n) s += mark(x.px(group.x[n]), y.px(group.y[n]));
    s += mark(at + 4, 394) + report::svg_text(at + 14, 398, "start", "tick", group.label);
    at += 160;
  }
  return s + "</svg>";
}

int run_calibrate_lab(const CalibrateLabOptions& asked) {
  CalibrateLabOptions o = asked;
  const bool plot_in_answer = o.plot == kPlotInAnswer;
  if (plot_in_answer && !o.json) throw UsageError("--plot -: of an answer by --json");
  if (plot_in_answer) o.plot.clear();
  const auto kind =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& k) { return k.name == o.what; });
  if (kind == std::end(kKinds)) throw UsageError("there is no calibration \"" + o.what + "\"");
  if (o.write && !o.output.empty())
    throw UsageError("--write writes into the lab file: -o has no place beside it");
  const std::filesystem::path lab = !o.lab.empty() ? o.lab : std::string(kind->jet ? kInkjetFile : kIceFile);
  refuse_unread_options(o);
  const Experiment e = kind->jet ? inkjet_lab(o, lab.string()) : ice_lab(o, lab.string());
  const std::string written = proposal_of(o, lab).string();
  check_output_files({lab}, {o.write ? std::string() : written, o.plot});
  if (o.write) check_output_files({}, {written, o.plot});
  check_writable({written, o.plot});
  JobProgress progress(o.what);
  LabCalibrationOptions run = o.run;
  run.material = o.valve == "b" ? 1 : 0;
  run.progress = [&](double share) { progress.show(share, ""); };
  if (!outside_ports(e).empty()) {
    std::fprintf(stderr, "%s\n", ports_text(e).c_str());
    run.weigh = &read_balance;
    if (run.rounds > 1)
      throw UsageError(
          "--rounds: feet and screws of a real table are turned by a person; then run this again");
  }
  const std::string host = host_of_calibration(e);
  const std::string machine = kind->jet ? "" : read_config_text(lab.parent_path() / e.ice.machine);
  LabCalibration c;
  try {
    c = !host.empty() ? calibrate_at_host(e, host, asked, machine)
        : kind->jet   ? kind->jet(e, run)
                      : kind->run(e, machine, run);
  } catch (const calibration::Unidentifiable& why) {
    progress.done();
    if (o.json)
      std::printf("%s\n",
                  nlohmann::ordered_json{{"what", o.what}, {"uninformative", why.what()}}.dump(2).c_str());
    else
      std::fprintf(stderr, "firn calibrate %s: uninformative, nothing is proposed: %s\n", o.what.c_str(),
                   why.what());
    return kFailed;
  }
  progress.done();
  const auto picture_of = [](const LabCalibration& of) {
    return of.picture.empty() ? residual_svg(of) : of.picture;
  };
  if (!o.plot.empty()) write_text(o.plot, report::standalone_svg(picture_of(c)));
  std::filesystem::path proposal;
  std::string changes;
  if (!c.keys.empty()) {
    const std::string before = text_of(lab), after = with_keys(before, lab_keys(c));
    changes = changed_lines(before, after);
    proposal = proposal_of(o, lab);
    write_text(proposal, after);
  }
  if (o.json) {
    nlohmann::ordered_json out = calibration_json(c);
    if (!proposal.empty()) out["proposal"] = proposal.string();
    if (!o.plot.empty()) out["plot"] = o.plot;
    if (plot_in_answer) out["svg"] = picture_of(c);
    std::printf("%s\n", out.dump(2).c_str());
    return kOk;
  }
  print_calibration(c);
  if (!proposal.empty())
    fmt::print("{} {}:\n{}", o.write ? "written into" : "proposed in", proposal.string(), changes);
  return kOk;
}

}  // namespace firn
