#include "cli/calibrate_command.h"

#include <cstdio>
#include <optional>
#include <stdexcept>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "cli/sealed_run.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "firn/enums.h"
#include "firn/height_map_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "lcmtypes/convert.h"
#include "runs/folder/config_change.h"
#include "runs/read/run_reader.h"

namespace firn {
namespace {

struct Seen {
  std::optional<HeightMap> bare, last;
  int last_layer = 0;
  std::optional<DropletPattern> marks;
  std::optional<MaterialMap> materials;
};

Seen read(const std::filesystem::path& run) {
  const runs::RunReader messages(run);
  Seen seen;
  messages.each<height_map_t>(channels::kHeightMap.name, [&](const height_map_t& m) {
    if (m.layer == 0) seen.bare = height_of(m);  // the last attempt counts
    if (m.layer > 0 && m.layer >= seen.last_layer) {
      seen.last = height_of(m);
      seen.last_layer = m.layer;
    }
  });
  messages.each<layer_plan_t>(channels::kLayerPlan.name, [&](const layer_plan_t& m) {
    if (m.layer != 1 || PlanDecision(m.decision) != PlanDecision::kPrint) return;
    seen.marks = drops_of(m);
    if (!m.material.empty()) seen.materials = materials_of(m);
  });
  return seen;
}

std::vector<registration::MarkSite> sites(const DropletPattern& marks, const MaterialMap& materials) {
  std::vector<registration::MarkSite> out;
  for (int j = 0; j < marks.spec.ny; ++j)
    for (int i = 0; i < marks.spec.nx; ++i)
      if (marks.at(i, j))
        out.push_back({marks.spec.x_mm(i), marks.spec.y_mm(j), Material(materials.at(i, j))});
  return out;
}

std::string number(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

}  // namespace

Calibration calibrate(const std::filesystem::path& run) {
  try {
    const std::string config = runs::recorded_config(run);
    if (config.empty())
      throw std::invalid_argument(run.string() + ": no configuration is recorded in nodes/");
    const Experiment e = parse_experiment(config, "the recorded configuration");
    if (e.control.scheme != "registration")
      throw std::invalid_argument(run.string() + " is no registration print: its control.scheme is \"" +
                                  e.control.scheme + "\"");
    const Seen seen = read(run);
    if (!seen.bare || !seen.last || !seen.marks || !seen.materials)
      throw std::invalid_argument(run.string() + " holds no printed and measured marks");
    Calibration c;
    c.off = registration::measure_offset(*seen.bare, *seen.last, sites(*seen.marks, *seen.materials));
    c.believed_x_mm = e.jet_b.offset_x_mm;
    c.believed_y_mm = e.jet_b.offset_y_mm;
    return c;
  } catch (const std::invalid_argument& problem) {
    throw UsageError(problem.what());
  }
}

std::string proposal(const Calibration& c, const std::string& run_name) {
  const auto row = [](const char* key, double value, const registration::Interval& i) {
    return std::string(key) + " = " + number(value, 5) + "  # 95 %: +- " + number(i.ci95_half_width_mm, 5) +
           " mm\n";
  };
  return "# Where nozzle B stands relative to nozzle A, measured by firn calibrate from " +
         std::to_string(c.off.marks_a) + " and " + std::to_string(c.off.marks_b) + " marks of\n# run " +
         run_name + ".\n[jet_b]\n" + row("offset_x_mm", c.offset_x_mm(), c.off.x) +
         row("offset_y_mm", c.offset_y_mm(), c.off.y);
}

int run_calibrate(const CalibrateOptions& options) {
  if (is_lab_calibration(options.run)) {
    CalibrateLabOptions lab = options.lab;
    lab.what = options.run;
    lab.output = options.output;
    lab.json = options.json;
    return run_calibrate_lab(lab);
  }
  if (!std::filesystem::is_directory(options.run)) {
    std::string names;
    for (const std::string_view name : lab_calibration_names())
      names += (names.empty() ? "" : ", ") + std::string(name);
    throw UsageError(options.run + " is neither a run folder nor one of " + names);
  }
  const auto still = use_sealed_run(options.run, options.unsealed);
  const Calibration c = calibrate(options.run);
  const std::filesystem::path run = std::filesystem::weakly_canonical(options.run);
  const std::string path = options.output.empty() ? (run / "jet_b.toml").string() : options.output;
  write_file_atomically(path, proposal(c, run.filename().string()));
  if (options.json) {
    const auto axis = [](double value, double believed, const registration::Interval& i) {
      return nlohmann::ordered_json{{"offset_mm", value},
                                    {"believed_mm", believed},
                                    {"off_by_mm", i.value_mm},
                                    {"sigma_mm", i.sigma_mm},
                                    {"half_95_mm", i.ci95_half_width_mm}};
    };
    const nlohmann::ordered_json out = {{"x", axis(c.offset_x_mm(), c.believed_x_mm, c.off.x)},
                                        {"y", axis(c.offset_y_mm(), c.believed_y_mm, c.off.y)},
                                        {"marks_a", c.off.marks_a},
                                        {"marks_b", c.off.marks_b},
                                        {"skipped", c.off.skipped},
                                        {"proposal", path}};
    std::printf("%s\n", out.dump(2).c_str());
    return kOk;
  }
  const auto line = [](const char* axis, double value, double believed, const registration::Interval& i) {
    std::printf("%s  %11s mm  +- %s (95 %%)   the lab believes %s: off by %s um\n", axis,
                number(value, 5).c_str(), number(i.ci95_half_width_mm, 5).c_str(),
                number(believed, 5).c_str(), number(1000.0 * i.value_mm, 1).c_str());
  };
  std::printf("nozzle B relative to nozzle A, from %d and %d marks%s\n", c.off.marks_a, c.off.marks_b,
              c.off.skipped ? (", " + std::to_string(c.off.skipped) + " not found").c_str() : "");
  line("x", c.offset_x_mm(), c.believed_x_mm, c.off.x);
  line("y", c.offset_y_mm(), c.believed_y_mm, c.off.y);
  std::printf("for the lab file: %s\n", path.c_str());
  return kOk;
}

void declare_calibrate(OptionSet& options) {
  auto& o = options.calls(run_calibrate);
  std::string names;
  for (const std::string_view name : lab_calibration_names())
    names += (names.empty() ? "" : ", ") + std::string(name);
  options.option("RUN", o.run, "run folder of a registration print; or a calibration of a lab: " + names)
      .required();
  options.option("LAB", o.lab.lab,
                 "lab or experiment file; default: labs/ice-cobra600.toml, of jet labs/inkjet-lu2015.toml");
  options.option("-o,--output", o.output,
                 "proposal for the lab file; default: RUN/jet_b.toml, LAB with .proposed.toml");
  options.flag("--write", o.lab.write, "into LAB itself");
  options.option("--valve", o.lab.valve, "valve-latency, flow-curve: a (water) or b (scaffold)")
      .show_default()
      .one_of({"a", "b"});
  options
      .option("--repeats", o.lab.run.repeats,
              "passes, weighings or sweeps of each kind; default: the calibration's own")
      .within(1, 1000);
  options.option("--speeds", o.lab.run.speeds_mm_s, "S,S,... [mm/s] of its passes")
      .separated_by(',')
      .within(1.0, 1000.0);
  options
      .option("--frequencies", o.lab.run.frequencies_hz,
              "flow-curve: F,F,... [Hz]; default: 20 up to a pulse a tick")
      .separated_by(',')
      .within(1.0, 1000.0);
  options
      .option("--dwells", o.lab.run.dwells_us, "jet: T,T,... [us]; default: 13 from 0.4 to 2 times the lab's")
      .separated_by(',')
      .within(1.0, 3000.0);
  options
      .option("--voltages", o.lab.run.voltages_v,
              "jet: U,U,... [V]; default: 11 from 0.6 to 1.6 times the lab's")
      .separated_by(',')
      .within(-100.0, 100.0);
  options
      .option("--velocity", o.lab.run.velocity_m_s,
              "jet: of the droplets [m/s]; default: the middle of watch.velocity_least_m_s and _most_m_s")
      .within(0.1, 20.0);
  options.option("--rounds", o.lab.run.rounds, "level-table: so often turned as told and measured again")
      .show_default()
      .within(1, 20);
  options.option("--seed", o.lab.run.seed, "of where passes begin and the order of things").show_default();
  options.option("--plot", o.lab.plot,
                 "residuals, of jet the velocities, SVG; with --json and -: in the answer");
  options.override_option(o.lab.overrides);
  declare_unsealed(options, o.unsealed);
  options.json_flag(o.json);
}

}  // namespace firn
