// PrintJudge judges a print by its last measured map: the result that result.json keeps, and that every
// command, the page and the report show.
#pragma once

#include <optional>

#include "config/labs.h"
#include "firn/layer_metrics_t.hpp"
#include "print/labs/product.h"
#include "runs/folder/documents.h"

namespace firn {

class PrintJudge {
 public:
  /// @param asked_um tolerance of the last map's RMS that the user asks for [um]; 0: one nominal layer, which
  /// is none where the scheme prints towards no target
  PrintJudge(const Product& product, const Experiment& experiment, double asked_um);

  /// Takes a layer's metrics, in the order of the layers.
  void take(const layer_metrics_t& metrics);
  /// Takes the error of the last layer.
  void take(const std::optional<runs::MapError>& error) { error_ = error; }

  /// Adds the error and the tolerance to a result, and judges a finished print: outcome "out of tolerance"
  /// with kOutOfTolerance where the RMS is above it; kFailed where a tolerance was asked for and nothing was
  /// measured.
  void judge(runs::RunResult& result) const;

 private:
  LabWords words_;
  bool asked_;
  double tolerance_um_;
  std::optional<runs::MapError> error_;
};

/// One nominal layer [um]; 0 where a scheme prints towards no target: patterns, registration marks, a given
/// number of full layers.
double usual_tolerance_um(const Product& product, const Experiment& experiment);

}  // namespace firn
