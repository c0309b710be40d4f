// decide computes one layer's decision on any surface, with a proved bound of its distance from the optimum.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace firn {

struct DecideOptions {
  std::string height, target, mask;    ///< NPY; mask may be empty: every cell
  std::string model;                   ///< TOML with [model] and, if wanted, [control]
  std::vector<std::string> overrides;  ///< --set KEY=VALUE, after the file
  std::optional<double> alpha;         ///< instead of the file's
  std::optional<int> horizon;          ///< instead of the file's
  std::string method;                  ///< instead of the file's
  bool bound = false;
  int bound_rows = 2;
  int bound_sweeps = 40;
  std::string certificate;        ///< NPY of the bound's multipliers, written
  std::string check_certificate;  ///< the same, read: prints the proved bound, decides nothing
  bool edge_bound = false;        ///< prints the least overspill at the surface's mean error, decides nothing
  std::string output;             ///< NPY of the droplets
  int threads = 1;                ///< 0: as many as the machine has; the answer is the same
  bool json = false;
};

/// Decides the next layer as the controller's process does. @returns the text to be printed: objective, that
/// of printing nothing, and with `bound` a lower bound and the proved gap; JSON with `json`.
/// @throws ConfigError, UsageError, std::invalid_argument: naming file, key, byte, shape or cell.
std::string decide(const DecideOptions& options);
int run_decide(const DecideOptions& options);

}  // namespace firn
