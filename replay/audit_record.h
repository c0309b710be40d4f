// AuditRecord holds the records of a run's nodes about its droplets, from all write-ahead files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/material.h"
#include "core/grid/offsets.h"

namespace firn::runs {
class RunReader;
}

namespace firn::replay {

/// Holds a STAGE_COMMAND of verb "pass": the order to raster these cells.
struct PassOrder {
  std::int64_t t_us = 0;
  std::int32_t layer = 0, attempt = 0, pass = 0;
  GridSpec grid;
  std::vector<std::uint32_t> cells;     ///< in firing order
  Placement placement = {};             ///< of the droplets in these cells
  std::vector<StagePlace> places = {};  ///< of the stage at each droplet; empty: all are in the centres
};

/// Holds a JET_COMMAND that arms the jet for a pass.
struct ArmOrder {
  std::int64_t t_us = 0;
  bool small = false;  ///< with the waveform of small droplets
};

/// Holds a DEPOSITION_REPORT.
struct PassReport {
  std::int64_t t_us = 0;
  std::int32_t layer = 0, attempt = 0, pass = 0;
  std::int64_t map_id = 0;
  std::int64_t unknown_from = 0, unknown_to = 0;
};

/// Holds the part of its layer that a pass was, from DEPOSITION_REPORT.
struct PassPart {
  std::int32_t layer = 0, attempt = 0, pass = 0, passes = 0;
  std::int32_t round = 0, sub_pattern = 0, sub_patterns = 1;
  Material material = Material::kA;
};

/// Holds a LAYER_PLAN with the decision to print.
struct PlannedLayer {
  std::int64_t t_us = 0;
  std::int32_t layer = 0;
  std::int32_t passes = 0;
  std::int64_t map_id = 0;
  DropletPattern drops;
  MaterialMap materials;   ///< has no cells if there is one ink
  OffsetMap offsets = {};  ///< has no cells if all droplets are in the centres
};

struct MeasuredMap {
  std::int64_t t_us = 0;
  std::int32_t layer = 0;
  std::int64_t map_id = 0;
  std::int64_t sample_us = 0;  ///< time of its last profile
};

struct Stop {
  std::int64_t t_us = 0;
  std::string cause;
  std::int32_t incarnation = 0;  ///< of its sender
};

struct Lease {
  std::int64_t t_us = 0;
  std::int64_t until_us = 0;  ///< at most t_us where the lease is taken back
};

struct AuditRecord {
  std::vector<PassOrder> orders;  // each list in order of time
  std::vector<PassReport> reports;
  std::vector<PassPart> parts;  ///< empty where a layer is one pattern of one ink and one size of droplet
  std::vector<ArmOrder> arms;   ///< of the first jet; empty where there is one size of droplet
  std::vector<PlannedLayer> plans;
  std::vector<MeasuredMap> maps;
  std::vector<Stop> stops;           ///< SAFE_STOP and FAULT_* that stop, by incarnation, time
  std::vector<Lease> leases;         ///< ENABLE
  std::vector<std::int64_t> starts;  ///< of each incarnation
  bool finished = false;             ///< RUN_END with outcome finished or ended early
  std::int64_t end_us =
      std::numeric_limits<std::int64_t>::max();  ///< of that RUN_END; the stop after it is the orderly one
  std::vector<std::string> operator_orders;      ///< "pause at 12.345 s", in order of time
  std::vector<std::string> forged;               ///< RunReader::forged
  std::vector<std::string> damage;               ///< "nodes/jet.wal, byte 12: checksum does not hold"
};

/// Returns the operator's commands of a run: "pause at 12.345 s".
std::vector<std::string> operator_orders(const runs::RunReader& messages);

/// Reads the record. A message counts if any write-ahead file holds it, its publisher's or a receiver's.
/// @param places of the run's offsets (actuation.offsets)
/// @throws std::invalid_argument for a folder without nodes/, record::FileError
AuditRecord read_audit_record(const std::filesystem::path& run, const OffsetTable& places = {});

}  // namespace firn::replay
