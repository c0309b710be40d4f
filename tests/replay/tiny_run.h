// Records a small closed loop of four nodes and an instrument into a run folder by the Lab. The tests of
// replay damage and change this run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "replay/replayer.h"

namespace firn::test {

struct TinyOptions {
  int layers = 6;
  double kp = 1.0;
  std::int64_t run_id = 77;
  bool log = true;
  int resumes = 0;  ///< incarnations after the first; each ends at a quiet moment
};

inline constexpr int kTinyColumns = 6;  // of the grid
inline constexpr int kTinyRows = 4;

/// Replays such a run by its own nodes: scheduler, surface_mapper, controller, laser_profiler.
replay::RunVerdict replay_tiny(const std::filesystem::path& run, replay::ReplayOptions options = {});

/// Records into `folder` (made anew): experiment.toml, inputs/, nodes/, log.lcm.
void record_tiny_run(const std::filesystem::path& folder, const TinyOptions& options = {});

/// A fresh folder under the build folder.
std::filesystem::path scratch_folder(const std::string& name);

}  // namespace firn::test
