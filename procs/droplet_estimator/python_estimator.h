// PythonEstimator runs a class in a Python file as the estimator of droplets (estimator.droplets =
// "python:FILE.py:CLASS"; contract: python/lib/firn/contract.py).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "estimators/droplet/droplet_estimator.h"
#include "python/host/python_host.h"
#include "runtime/node.h"

namespace firn {

/// The record of one layer that an estimator is given.
struct PrintedLayer {
  const std::vector<droplet::Pass>& passes;
  const HeightMap& height;  ///< NaN where nothing was measured
  const std::vector<droplet::Use>& use;
  int layer = 0, attempt = 0;
  double noise_std_mm = 0.0;
};

class PythonEstimator {
 public:
  /// @param inputs with the file and the modules that it imports
  /// @throws std::invalid_argument: a file that is no input; std::runtime_error: the plug-in is not there, or
  /// with the traceback of an exception
  PythonEstimator(const Experiment& experiment, const Mask& mask, const Blobs& inputs);

  /// @returns the estimate after the layer. @throws std::runtime_error with the traceback of an exception;
  /// naming an answer that is none, and a call that took too long
  const droplet::Estimate& learn(const PrintedLayer& layer);

 private:
  GridSpec grid_;
  std::unique_ptr<python::Object> object_;
  droplet::Estimate estimate_;
  int learned_ = -1;  ///< newest layer
};

}  // namespace firn
