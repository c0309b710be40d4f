// Rows of a stage that is a GRBL board: assumptions of its driver that no settings tell.
#include "config/device_kinds.h"
#include "print/bringup/bringup.h"

namespace firn {
namespace {

// The driver compares them when it connects, and is not safe with others.
BringupFinding settings_fit(BringupLab& lab, const std::string& node) {
  const std::string why = lab.drive(node, "params");
  return {why.empty(), why.empty() ? "as the lab file" : why, "the lab file's steps, rates and acceleration",
          "the setting that is named, at the board ($N=...) or in [stage]"};
}

bool fires(const Experiment& e, std::string_view) { return on(e.stage.laser_output); }
bool scans(const Experiment& e, std::string_view) { return on(e.stage.scan_box); }

constexpr BringupRow kGrblRows[] = {
    {61, "stage", "steps/mm, rates, acceleration and laser mode are the lab file's", "stage.counts_per_mm",
     &settings_fit},
    {62, "stage", "a stop in a move brakes, and `where` tells a place that a dial gauge confirms [C]",
     "GrblStage::hold"},
    {63, "stage",
     "the laser output is low after power-on, reset and hold, and high once a droplet, at an oscilloscope "
     "[S]",
     "stage.laser_output", nullptr, &fires},
    {64, "stage",
     "the box gives one pulse each grid.pitch_y_mm of Y from where the coolant output went on, none without "
     "[P]",
     "stage.scan_box", nullptr, &scans},
};

}  // namespace

std::span<const BringupRow> grbl_rows() { return kGrblRows; }

}  // namespace firn
