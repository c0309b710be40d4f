// world_config computes a world's parameters from an experiment's configuration.
#pragma once

#include "config/experiment.h"
#include "plant/config/world_config.h"
#include "runtime/node.h"

namespace firn::plant {

/// Reads nature's parameters from [plant] and the instruments' from the lab's sections. The controllers'
/// beliefs ([model]) do not reach nature.
WorldConfig world_config(const Experiment& experiment);
/// The same with the files of a nature in Python.
/// @throws std::invalid_argument: its file is no input
WorldConfig world_config(const Experiment& experiment, const Blobs& inputs);

}  // namespace firn::plant
