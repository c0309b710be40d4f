// Prints of lines with gas and a heated platen: their order, their faults, stops by name and the way back.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "cli/replay_command.h"
#include "config/include.h"
#include "firn/answer_t.hpp"
#include "firn/enums.h"
#include "firn/gas_command_t.hpp"
#include "firn/gas_flow_t.hpp"
#include "firn/heater_command_t.hpp"
#include "firn/line_plan_t.hpp"
#include "firn/stage_command_t.hpp"
#include "firn/temperature_t.hpp"
#include "plant/record/record.h"
#include "print/folder/run_report.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "replay/print_verdict.h"
#include "runs/read/run_reader.h"
#include "tests/files/record/scratch.h"

using namespace firn;
using firn::test::Scratch;

namespace {

/// Two short lines in few layers, with gas and platen as the lab file has them.
struct SuppliedLines {
  Scratch scratch{"supplied"};
  Experiment experiment;
  runs::RunFolder run;

  explicit SuppliedLines(std::vector<std::string> more = {})
      : experiment(load(std::move(more))),
        run(runs::RunFolder::create(scratch / "runs", experiment,
                                    make_inputs(full_product(), experiment, kFolder), {"test"})) {}

  static inline const std::filesystem::path kFolder = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";

  static Experiment load(std::vector<std::string> more) {
    std::vector<std::string> set{"aerosol.job=aerosol-lines.json", "aerosol.layers=3", "grid.nx=250",
                                 "grid.ny=80"};
    set.insert(set.end(), more.begin(), more.end());
    return load_experiment(kFolder / "aerosol-meander.toml", set);
  }
  LabRunReport go(const std::vector<std::string>& faults = {}, bool resume = false) {
    LabRunOptions o;
    o.resume = resume;
    o.faults = parse_lab_faults(faults, experiment);
    return run_in_lab(full_product(), run, o);
  }
  std::vector<plant::FiringRecord> firings() const {
    return plant::read_history(run.world_record_path()).firings;
  }
  void check_record() const {
    ReplayCommandOptions r;
    r.run = run.path().string();
    const replay::RunVerdict verdict = replay_verdict(full_product(), r);
    INFO(replay::to_text(verdict));
    CHECK(verdict.identical());
    const replay::AuditVerdict audit = replay::audit_run(run.path());
    INFO(replay::to_text(audit));
    CHECK(audit.clean());
  }
  template <class Message>
  std::vector<Message> all(std::string_view channel) const {
    std::vector<Message> out;
    runs::RunReader(run.path()).each<Message>(channel, [&](const Message& m) { out.push_back(m); });
    return out;
  }
};

/// A moment at which the shutter is open in layer 2 of a print that nothing disturbs.
double open_moment_s() {
  static const double moment = [] {
    SuppliedLines lines;
    REQUIRE(lines.go().result.status == 0);
    return double(lines.firings().at(1).first_us) * 1e-6 + 0.3;
  }();
  return moment;
}

struct SupplyFault {
  const char* port;
  int code;
  const char* name;  ///< in the reason
  double within_s;   ///< from the fault to the end of the firing
  const char* more = "gas.use=\"on\"";
};

/// Stopped by its name with the shutter closed; after its mending the print goes on to its end.
void check_supply_fault(const SupplyFault& fault) {
  CAPTURE(fault.port, fault.code);
  const double moment_s = open_moment_s();  // a print of its own, before the folder of this one
  SuppliedLines lines({fault.more});
  const std::string moment = std::to_string(moment_s), port = fault.port;
  const LabRunReport stopped = lines.go({moment + " " + port + " trip " + std::to_string(fault.code)});
  INFO(stopped.result.reason);
  CHECK(stopped.result.status == 3);
  CHECK_THAT(stopped.result.reason, Catch::Contains(fault.name));
  for (const plant::FiringRecord& f : lines.firings()) CHECK(f.end_us > 0);
  const double over_s = double(lines.firings().back().end_us) * 1e-6 - moment_s;
  WARN(port << " trip " << fault.code << ": the shutter is closed " << over_s
            << " s after the fault: " << stopped.result.reason);
  CHECK(over_s < fault.within_s);
  const LabRunReport report = lines.go({"0 " + port + " trip 0"}, true);
  INFO(report.result.reason);
  CHECK_FALSE(runs::can_go_on(report.result));
  CHECK(report.result.layers == 3);
  lines.check_record();
}

}  // namespace

TEST_CASE(
    "The platen is warm and both gases flow before homing, no way begins on gas that is not steady, and none "
    "flows at the end",
    "[line][I16]") {
  SuppliedLines lines;
  REQUIRE(lines.go().result.status == 0);
  lines.check_record();
  const auto gas = lines.all<gas_command_t>(channels::kGasCommand.name);
  const auto heat = lines.all<heater_command_t>(channels::kHeaterCommand.name);
  const auto stage = lines.all<stage_command_t>(channels::kStageCommand.name);
  const auto flows = lines.all<gas_flow_t>(channels::kGasFlow.name);
  const auto answers = lines.all<answer_t>(channels::answer(NodeId::kGas).name);
  REQUIRE(heat.size() == 1);
  REQUIRE(gas.size() == 1 + 3 + 1);
  CHECK(heat[0].set_degC[0] == lines.experiment.heater.platen_degC);
  CHECK(heat[0].set_degC[1] == -50.0);
  double warm_s = 0.0;
  for (const temperature_t& t : lines.all<temperature_t>(channels::kTemperature.name))
    if (warm_s == 0.0 && t.degC[0] >= lines.experiment.heater.low_degC)
      warm_s = double(t.header.utime_us) * 1e-6;
  CHECK(warm_s > 10.0);
  CHECK(double(gas[0].header.utime_us) * 1e-6 >= warm_s);
  REQUIRE(answers.size() == gas.size());
  const std::int64_t there_us = answers[0].header.utime_us;
  std::size_t ways = 0;
  for (const stage_command_t& c : stage) {
    CHECK(c.header.utime_us >= there_us);
    if (StageVerb(c.verb) != StageVerb::kTrace) continue;
    ++ways;
    CHECK(double(c.header.utime_us - there_us) * 1e-6 >= lines.experiment.gas.steady_s);
    CHECK(c.header.utime_us >= answers[ways].header.utime_us);
    // The newest reading before the way, and all until its end a little later.
    const gas_flow_t* newest = nullptr;
    for (const gas_flow_t& f : flows)
      if (f.header.utime_us <= c.header.utime_us) newest = &f;
    REQUIRE(newest);
    CHECK(newest->sccm[0] == Approx(lines.experiment.gas.atomizer_sccm).epsilon(0.05));
    CHECK(newest->sccm[1] == Approx(lines.experiment.gas.sheath_sccm).epsilon(0.05));
  }
  CHECK(ways == 3);
  CHECK(gas.back().atomizer_sccm == 0.0);
  CHECK(gas.back().sheath_sccm == 0.0);
  CHECK(Outcome(answers.back().outcome) == Outcome::kDone);
}

TEST_CASE("A way waits until the gas has flowed for gas.steady_s", "[line]") {
  SuppliedLines lines({"gas.steady_s=600", "aerosol.layers=1"});
  REQUIRE(lines.go().result.status == 0);
  const std::int64_t there_us = lines.all<answer_t>(channels::answer(NodeId::kGas).name)[0].header.utime_us;
  for (const stage_command_t& c : lines.all<stage_command_t>(channels::kStageCommand.name))
    if (StageVerb(c.verb) == StageVerb::kTrace)
      CHECK(double(c.header.utime_us - there_us) * 1e-6 == Approx(600.0).margin(1.0));
}

TEST_CASE(
    "Ink's gas lost, sheath lost, clogged, held, mute: the shutter closes, the print stops by name and goes "
    "on",
    "[line][I16]") {
  check_supply_fault(GENERATE(SupplyFault{"gas", 1, "atomizer", 2.5}, SupplyFault{"gas", 2, "sheath", 2.5},
                              SupplyFault{"gas", 3, "it clogs", 8.0}, SupplyFault{"gas", 5, "HLD", 1.0},
                              SupplyFault{"gas", 6, "gas", 5.0}));
}

TEST_CASE("A platen whose thermocouple opens stops the print by name, and it goes on", "[line][I10]") {
  check_supply_fault({"heater", 4, "platen: open thermocouple", 4.0});
}

TEST_CASE("A layer's own sheath gas is set and flows for gas.steady_s before its way", "[line]") {
  SuppliedLines lines({"aerosol.width_by=gas", "plant.aerosol.nozzle_mm=0.31", "aerosol.layers=2"});
  REQUIRE(lines.go().result.status == 0);
  lines.check_record();
  const auto plans = lines.all<line_plan_t>(channels::kLinePlan.name);
  const auto gas = lines.all<gas_command_t>(channels::kGasCommand.name);
  const auto answers = lines.all<answer_t>(channels::answer(NodeId::kGas).name);
  const auto stage = lines.all<stage_command_t>(channels::kStageCommand.name);
  REQUIRE(gas.size() == 1 + 2 + 1);
  CHECK(plans.at(1).sheath_share > 1.05);
  for (std::size_t layer = 0; layer < 2; ++layer)
    CHECK(gas[1 + layer].sheath_sccm == plans[layer].sheath_share * lines.experiment.gas.sheath_sccm);
  const auto last = std::find_if(stage.rbegin(), stage.rend(), [](const stage_command_t& c) {
    return StageVerb(c.verb) == StageVerb::kTrace;
  });
  REQUIRE(last != stage.rend());
  CHECK(double(last->header.utime_us - answers[2].header.utime_us) * 1e-6 >= lines.experiment.gas.steady_s);
}

TEST_CASE("A lab without gas and platen heater prints as before they were", "[line]") {
  SuppliedLines lines({"gas.use=\"off\"", "heater.platen_degC=-50"});
  REQUIRE(lines.go().result.status == 0);
  lines.check_record();
  CHECK(lines.all<gas_command_t>(channels::kGasCommand.name).empty());
  CHECK(lines.all<heater_command_t>(channels::kHeaterCommand.name).empty());
}
