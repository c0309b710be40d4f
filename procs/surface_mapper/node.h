// SurfaceMapper computes the height map of a scan: HEIGHT_PROFILE, SCAN_DONE -> HEIGHT_MAP, HEIGHT_PREVIEW.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "estimators/surface/robust_smoothing.h"
#include "estimators/surface/surface_map.h"
#include "firn/height_profile_t.hpp"
#include "firn/preview_t.hpp"
#include "firn/scan_done_t.hpp"
#include "runtime/node.h"

namespace firn {

/// Gathers the profiles of one scan and answers SCAN_DONE with the map. Profiles and SCAN_DONE have separate
/// channels, so rows may arrive after SCAN_DONE. The node waits up to 2 s of run time for the rows that
/// SCAN_DONE counted, then maps the received rows (missing cells are filled and marked as guessed;
/// measured_fraction reports the share of the others, rows_received the rows). The map does not depend on the
/// order of rows. Repeated rows, rows out of order and rows of an older scan change nothing (the check at
/// decode rejects malformed rows). With control.smoothing on, the part's cells hold the robust DCT smoothing
/// of the measured ones (guessed cells and those off the mask have no weight). A newer scan_id drops the
/// unfinished scan. One map per scan; map_id counts the maps.
class SurfaceMapper final : public Node {
 public:
  SurfaceMapper(const Experiment& experiment, Mask mask);
  void on(const height_profile_t&, Time now, Outbox&);
  void on(const scan_done_t&, Time now, Outbox&);
  void wake(TimerId, Time now, Outbox&) override;

 private:
  bool enter_scan(std::int64_t scan_id, Outbox&);  ///< false: an older scan, or this one is mapped already
  void publish(Outbox&);
  void smooth(surface::SurfaceEstimate& estimate);

  GridSpec grid_;
  double wait_s_;
  surface::MapOptions options_;
  Mask mask_;
  std::optional<surface::RobustSmoother> smoother_;  ///< with control.smoothing
  surface::SurfaceMap map_;
  std::int64_t scan_id_ = -1;  ///< of the scan being gathered or mapped last
  bool mapped_ = true;
  std::vector<std::uint8_t> seen_;  ///< rows of this scan that have come
  std::int32_t rows_in_ = 0;
  std::int64_t last_sample_us_ = 0;
  bool done_ = false;
  scan_done_t scan_done_{};
  std::int64_t maps_ = 0;
};

/// Returns the height map reduced to at most 60 kB by averaging blocks of cells.
preview_t preview_of(const HeightMap& height, std::int32_t layer);

std::unique_ptr<Node> make_surface_mapper(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
