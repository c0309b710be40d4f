#include "print/print_judge.h"

#include <fmt/core.h>

#include "files/exit_codes.h"
#include "lcmtypes/told_heights.h"

namespace firn {
namespace {

constexpr double kVerdictUm = 1e3;  // per mm

}  // namespace

double usual_tolerance_um(const Product& product, const Experiment& e) {
  return print_lab(product, e).tolerance_um(e);
}

PrintJudge::PrintJudge(const Product& product, const Experiment& e, double asked_um)
    : words_(lab_words(e.lab.kind)),
      asked_(asked_um > 0.0),
      tolerance_um_(asked_ ? asked_um : usual_tolerance_um(product, e)) {}

void PrintJudge::take(const layer_metrics_t& m) {
  error_.reset();
  if (!heights_told(m)) return;
  error_ = runs::MapError{m.mean_error_mm * kVerdictUm, m.rms_mm * kVerdictUm, m.std_mm * kVerdictUm,
                          m.rms_inside_mm * kVerdictUm, m.rms_rim_mm * kVerdictUm};
}

void PrintJudge::judge(runs::RunResult& r) const {
  r.error = error_;
  if (tolerance_um_ > 0.0) r.tolerance_um = tolerance_um_;
  if (r.outcome != "finished") return;
  if (!error_) {
    if (!asked_) return;
    r.status = kFailed;
    r.reason += "; nothing was measured that the tolerance could judge";
  } else if (within_tolerance(r) == false) {
    r.outcome = "out of tolerance";
    r.status = kOutOfTolerance;
    r.reason = fmt::format("RMS {} of the last map, more than {}{}; {}", words_.length(error_->rms_um),
                           words_.length(tolerance_um_), asked_ ? "" : ", one layer", r.reason);
  }
}

}  // namespace firn
