// Product lists the parts that a program prints with: labs, nodes, readers of meshes. Its main() hands it in.
#pragma once

#include <filesystem>
#include <span>

#include "config/experiment.h"
#include "drivers/link/link_probe.h"
#include "print/inputs/mesh_inputs.h"
#include "print/labs/print_lab.h"
#include "runtime/node.h"

namespace firn {

struct NamedMaker {
  NodeId id;
  MakeNode make;
  drivers::LinkProbe (*probe)() =
      nullptr;  ///< of an instrument that is known at its port; jets: of their kinds
};

struct Product {
  std::span<const PrintLab* const> labs;
  std::span<const NamedMaker> nodes;
  const MeshInputs* meshes = nullptr;  ///< nullptr: a program without a slicer
};

/// Returns the row of an experiment's lab. @throws std::invalid_argument: lab.kind has no row
const PrintLab& print_lab(const Product& product, const Experiment& experiment);

/// Returns the inputs of a print, by the row of its lab.
Blobs make_inputs(const Product& product, const Experiment& experiment, const std::filesystem::path& folder);
void complete_experiment(const Product& product, Experiment& experiment, const Blobs& inputs);
/// @throws UsageError naming the place in the inputs and the limit
void check_inputs(const Product& product, const Experiment& experiment, const Blobs& inputs);

}  // namespace firn
