// GraphMpc computes layers by model predictive control of droplet volumes, with flow along the edges of a
// graph as its model.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "core/control/controller.h"
#include "core/control/graph/box_plan.h"
#include "core/control/prediction.h"

namespace firn::control {

inline constexpr std::array<std::string_view, 2> kGraphSolverWords{"together", "blocks"};

inline constexpr std::array kGraphMpcOptions{
    ExtraOption{"graph_horizon", std::int64_t{1}, "layers", within(1, 5), "N: layers that are planned"},
    ExtraOption{"graph_effort", 0.01, "", within(1e-6, 100), "weight of a dose, R by Q V^2"},
    ExtraOption{"graph_steps", std::int64_t{1}, "", within(1, 50), "steps of flow in a layer"},
    ExtraOption{"graph_solver", std::string_view("together"), "", Range{},
                "all cells together, or blocks that overlap (block Jacobi): the same plan",
                kGraphSolverWords},
};

/// Graph-model predictive control of droplet volumes, in the setting of Y. Guo, J. Peters, T. Oomen and S.
/// Mishra, "Distributed model predictive control for ink-jet 3D printing" (AIM 2017) and "Control-oriented
/// models for ink-jet 3D printing" (Mechatronics 56, 2018, 211), and of U. Inyang-Udoh, Y. Guo, J. Peters, T.
/// Oomen and S. Mishra, "Layer-to-layer predictive control of inkjet 3-D printing" (IEEE/ASME Trans.
/// Mechatronics 25, 2020), of which the abstracts alone were read: the formulation is ours.
///
/// Layer k + 1 minimises |r - H_{k+N}|^2 over the part + R |u|^2 over the doses 0 <= u <= 1 of N layers, r =
/// min((k + N) dh, target), H by graph_layer.h about the doses that the missing heights ask for. The first
/// layer of the plan becomes droplets by error diffusion; the next measurement shows what the rounding did.
/// Ends as MPC does when a layer at the nominal height does not better the part beyond noise. Keeps no state
/// between decisions.
class GraphMpc final : public LayerControllerBase {
 public:
  /// @throws std::invalid_argument naming the option
  GraphMpc(const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_model(const deposition::DropletModel& model) override;
  void use_threads(const ParallelFor& parallel) override { parallel_ = parallel; }
  void use_options(const ControlOptions& options) override { noise_gate_ = options.noise_gate; }

  /// The programme of a layer from a surface; doses that the missing heights ask for are in `start`.
  /// @param layer layers deposited so far
  graph::BoxProblem problem(const HeightMap& height, const MaterialMap& materials, int layer,
                            std::vector<double>& start) const;

 private:
  Setup setup_;
  double dh_mm_, noise_gate_;
  int horizon_, steps_;
  double effort_;
  bool blocks_;
  std::int64_t part_cells_;
  ParallelFor parallel_ = serially;
  Predictor predict_;
};

}  // namespace firn::control
