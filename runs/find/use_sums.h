// sum_use sums the use of many run folders: ink by batch, and hours by instrument.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "config/meta.h"

namespace firn::runs {

/// One counter. A simulated print uses up no real ink and wears no real lamp: those are counted apart.
struct UseSum {
  enum class Of : std::uint8_t { kBatch, kInstrument };
  Of of = Of::kBatch;
  std::string name;  ///< "ink TPGDA, batch 7"; "lamp"
  std::string port;  ///< of an instrument, or of the one that deposited: "simulated", or an address
  int runs = 0;
  double volume_mm3 = 0.0;
  double hours = 0.0;  ///< of an instrument
};

struct UseSums {
  std::vector<UseSum> sums;  ///< batches, then instruments, by their names
  int unread = 0;            ///< runs without a figure: they print, or their records cannot be read
};

/// Sums over the run folders in `places` from their own files: result.json, or the log of a run that an older
/// program printed. A run that lies in several places counts once, by its number.
/// @param progress receives the fraction that is read @param interrupted is asked before each run; true ends
/// it
/// @throws UsageError: no such folder
UseSums sum_use(const std::vector<std::filesystem::path>& places,
                const std::function<void(double)>& progress = {},
                const std::function<bool()>& interrupted = {});

/// Returns the name of the counter of a batch: "ink TPGDA, batch 7"; empty without ink and batch.
std::string batch_name(const Meta& meta);

/// A counter that comes near its limit.
struct UseWarning {
  const UseSum* sum = nullptr;
  double used = 0.0, limit = 0.0;  ///< in `unit`
  std::string unit;                ///< "mm^3", "h"

  std::string words() const;  ///< "ink TPGDA, batch 7: 46100 of 50000 mm^3 (92 %)"
};
/// @returns the counters from warn_percent of their limits on
std::vector<UseWarning> use_warnings(const UseSums& sums, const UseLimits& limits);

}  // namespace firn::runs
