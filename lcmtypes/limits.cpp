#include "lcmtypes/limits.h"

#include <limits>

namespace firn {
namespace {

constexpr double kAny = std::numeric_limits<double>::max();       // finite
constexpr double kCount = 9007199254740992.0;                     // 2^53
constexpr double kCells = 4096.0 * 4096.0;
constexpr double kDrops = kCells * 127;
constexpr double kLayers = 1e6;
constexpr double kMm = 1e5;                                       // 100 m: no machine is larger
constexpr double kSeconds = 1e9;

constexpr Limit kLimits[] = {
    {"*", "header.run_id", -kAny, kAny},
    {"*", "header.incarnation", 0, 1e6},
    {"*", "header.seq", 1, kCount},
    {"*", "header.utime_us", 0, kCount},
    {"*", "sample_utime_us", 0, kCount},
    {"*", "layer", 0, kLayers},
    {"*", "attempt", 0, 1e6},
    {"*", "map_id", 0, kCount},
    {"*", "scan_id", 0, kCount},
    {"*", "command_id", 0, kCount},
    {"*", "enable_epoch", 0, kCount},
    {"*", "iterations", 0, kCount},

    // Only a pass, and only a plan to print, needs its grid.
    {"stage_command_t", "grid.nx", 0, 4096},
    {"stage_command_t", "grid.ny", 0, 4096},
    {"stage_command_t", "grid.pitch_x_mm", 0, 100},
    {"stage_command_t", "grid.pitch_y_mm", 0, 100},
    {"stage_command_t", "grid.pitch_x_mm", 0, 100, true, false, "verb", 1, 1},
    {"stage_command_t", "grid.pitch_y_mm", 0, 100, true, false, "verb", 1, 1},
    {"layer_plan_t", "grid.nx", 0, 4096},
    {"layer_plan_t", "grid.ny", 0, 4096},
    {"layer_plan_t", "grid.pitch_x_mm", 0, 100},
    {"layer_plan_t", "grid.pitch_y_mm", 0, 100},
    {"layer_plan_t", "grid.pitch_x_mm", 0, 100, true, false, "decision", 0, 0},
    {"layer_plan_t", "grid.pitch_y_mm", 0, 100, true, false, "decision", 0, 0},
    {"*", "grid.nx", 1, 4096},
    {"*", "grid.ny", 1, 4096},
    {"*", "grid.pitch_x_mm", 0, 100, true},
    {"*", "grid.pitch_y_mm", 0, 100, true},
    {"*", "grid.origin_x_mm", -kMm, kMm},
    {"*", "grid.origin_y_mm", -kMm, kMm},
    {"grid_t", "nx", 1, 4096},
    {"grid_t", "ny", 1, 4096},
    {"grid_t", "pitch_x_mm", 0, 100, true},
    {"grid_t", "pitch_y_mm", 0, 100, true},
    {"grid_t", "origin_x_mm", -kMm, kMm},
    {"grid_t", "origin_y_mm", -kMm, kMm},
    {"header_t", "run_id", -kAny, kAny},
    {"header_t", "incarnation", 0, 1e6},
    {"header_t", "seq", 1, kCount},
    {"header_t", "utime_us", 0, kCount},

    {"height_map_t", "n", 1, kCells},
    {"height_map_t", "noise_std_mm", 0, 100},
    {"height_map_t", "measured_fraction", 0, 1},
    {"height_map_t", "height_mm", -kMm, kMm, false, true},
    {"height_map_t", "quality", 0, 2},

    {"height_profile_t", "n", 0, 1e6},
    {"height_profile_t", "row", 0, 1e6},
    {"height_profile_t", "rows", 1, 1e6},
    {"height_profile_t", "x0_mm", -kMm, kMm},
    {"height_profile_t", "dx_mm", 0, 100, true},
    {"height_profile_t", "y_mm", -kMm, kMm},
    {"height_profile_t", "trigger_count", -1, kCount},
    {"height_profile_t", "encoder_count", -kCount, kCount},
    {"height_profile_t", "z_mm", -kMm, kMm, false, true},
    {"scan_done_t", "rows_expected", 0, 1e6},
    {"scan_done_t", "rows_received", 0, 1e6},

    {"layer_plan_t", "n", 0, kCells},
    {"layer_plan_t", "n", 1, kCells, false, false, "decision", 0, 0},
    {"layer_plan_t", "decision", 0, 2},
    {"layer_plan_t", "passes", 0, 127},
    {"layer_plan_t", "objective_mm", -kAny, kAny},
    {"layer_plan_t", "objective_none_mm", -kAny, kAny},
    {"layer_plan_t", "drops", 0, 127},

    {"stage_command_t", "n", 0, kCells},
    {"stage_command_t", "n", 1, kCells, false, false, "verb", 1, 1},
    {"stage_command_t", "n", 0, 0, false, false, "verb", 2, 4},
    {"stage_command_t", "verb", 1, 4},
    {"stage_command_t", "pass", 0, 127},
    {"stage_command_t", "rows", 0, 1e6},
    {"stage_command_t", "rows", 1, 1e6, false, false, "verb", 2, 2},
    {"stage_command_t", "x_mm", -kMm, kMm},
    {"stage_command_t", "y_mm", -kMm, kMm},
    {"stage_command_t", "z_mm", -kMm, kMm},
    {"stage_command_t", "speed_mm_s", 0, 1000},
    {"stage_command_t", "speed_mm_s", 0, 1000, true, false, "verb", 1, 3},
    {"stage_command_t", "drops", 0, 127},
    {"jet_command_t", "verb", 1, 2},
    {"jet_command_t", "pass", 0, 127},
    {"jet_command_t", "expected", 0, kDrops},
    {"profiler_command_t", "verb", 1, 2},
    {"profiler_command_t", "rows", 0, 1e6},
    {"profiler_command_t", "y0_mm", -kMm, kMm},
    {"profiler_command_t", "pitch_y_mm", 0, 100},
    {"lamp_command_t", "verb", 1, 1},
    {"lamp_command_t", "exposure_s", 0, 3600},
    {"lamp_command_t", "iris_percent", 1, 100},
    {"operator_command_t", "verb", 1, 1},

    {"answer_t", "outcome", 0, 5},
    {"answer_t", "counted", -1, kDrops},
    {"answer_t", "expected", -1, kDrops},
    {"answer_t", "unknown_from", 0, kDrops},
    {"answer_t", "unknown_to", 0, kDrops},
    {"answer_t", "code", -kAny, kAny},
    {"device_state_t", "state", 0, 9},

    {"deposition_report_t", "n", 0, kCells},
    {"deposition_report_t", "pass", 0, 127},
    {"deposition_report_t", "passes", 0, 127},
    {"deposition_report_t", "outcome", 0, 5},
    {"deposition_report_t", "commanded", 0, kDrops},
    {"deposition_report_t", "triggered_stage", -1, kDrops},
    {"deposition_report_t", "triggered_jet", -1, kDrops},
    {"deposition_report_t", "confirmed", -1, kDrops},
    {"deposition_report_t", "unknown_from", 0, kDrops},
    {"deposition_report_t", "unknown_to", 0, kDrops},
    {"deposition_report_t", "drops", 0, 1},

    {"layer_metrics_t", "target_mean_mm", -kMm, kMm},
    {"layer_metrics_t", "mean_height_mm", -kMm, kMm},
    {"layer_metrics_t", "mean_error_mm", -kMm, kMm},
    {"layer_metrics_t", "rms_mm", 0, kMm},
    {"layer_metrics_t", "std_mm", 0, kMm},
    {"layer_metrics_t", "min_error_mm", -kMm, kMm},
    {"layer_metrics_t", "max_error_mm", -kMm, kMm},
    {"layer_metrics_t", "volume_mm3", -kAny, kAny},
    {"layer_metrics_t", "drops", 0, kDrops},
    {"layer_metrics_t", "drops_total", 0, kCount},
    {"layer_metrics_t", "objective_mm", -kAny, kAny},
    {"layer_metrics_t", "deposit_s", 0, kSeconds},
    {"layer_metrics_t", "cure_s", 0, kSeconds},
    {"layer_metrics_t", "scan_s", 0, kSeconds},
    {"layer_metrics_t", "decide_s", 0, kSeconds},
    {"layer_metrics_t", "layers_expected", 0, kLayers},

    {"enable_t", "enabled", 0, 1},
    {"enable_t", "lease_s", 0, 60, true},
    {"fault_t", "severity", 0, 2},
    {"fault_t", "code", -kAny, kAny},
    {"heartbeat_t", "n", 0, 10000},
    {"heartbeat_t", "state", 0, 2},
    {"heartbeat_t", "busy_since_us", 0, kCount},
    {"heartbeat_t", "steps", 0, kCount},
    {"heartbeat_t", "lost", 0, kCount},
    {"heartbeat_t", "resent", 0, kCount},
    {"heartbeat_t", "last_seq", 0, kCount},
    {"resend_request_t", "n", 0, 10000},
    {"resend_request_t", "from_seq", 1, kCount},
    {"resend_request_t", "to_seq", 1, kCount},
    {"run_end_t", "outcome", 0, 3},
    {"run_end_t", "layers", 0, kLayers},
    {"journal_t", "step", 0, kCount},
    {"journal_t", "outputs", 0, 1e6},
    {"journal_t", "output_bytes", 0, kCount},

    {"preview_t", "n", 1, 15000},
    {"preview_t", "height_mm", -kMm, kMm, false, true},
    {"sim_truth_t", "n", 1, kCells},
    {"sim_truth_t", "droplets_fired", 0, kCount},
    {"sim_truth_t", "volume_mm3", -kAny, kAny},
    {"sim_truth_t", "height_mm", -kMm, kMm, false, true},

    {"tile_t", "size", 1, 65000},
    {"tile_t", "run_id", -kAny, kAny},
    {"tile_t", "incarnation", 0, 1e6},
    {"tile_t", "seq", 1, kCount},
    {"tile_t", "index", 0, 1e6},
    {"tile_t", "count", 1, 1e6},
    {"tile_t", "total_bytes", 1, 268435456},  // 256 MiB: a 4096 x 4096 map takes 80
    {"tile_t", "checksum", -kAny, kAny},
    {"tile_t", "data", 0, 255},
};

using K = Relation::Kind;
constexpr Relation kRelations[] = {
    {"height_map_t", K::kCells, "n", "grid.nx", "grid.ny"},
    {"deposition_report_t", K::kCells, "n", "grid.nx", "grid.ny"},
    {"preview_t", K::kCells, "n", "grid.nx", "grid.ny"},
    {"sim_truth_t", K::kCells, "n", "grid.nx", "grid.ny"},
    {"stage_command_t", K::kCells, "n", "grid.nx", "grid.ny", "verb", 1, 1},
    {"layer_plan_t", K::kCells, "n", "grid.nx", "grid.ny", "decision", 0, 0},
    {"layer_plan_t", K::kCellsOrNone, "n", "grid.nx", "grid.ny", "decision", 1, 2},
    {"layer_plan_t", K::kAllNotAbove, "drops", "passes"},
    {"height_profile_t", K::kLess, "row", "rows"},
    {"answer_t", K::kNotAbove, "unknown_from", "unknown_to"},
    {"deposition_report_t", K::kNotAbove, "unknown_from", "unknown_to"},
    {"resend_request_t", K::kNotAbove, "from_seq", "to_seq"},
    {"tile_t", K::kLess, "index", "count"},
    {"tile_t", K::kNotAbove, "size", "total_bytes"},
};

}  // namespace

std::span<const Limit> limits() { return kLimits; }
std::span<const Relation> relations() { return kRelations; }

}  // namespace firn
