#include "estimators/flow/flow_blocks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "core/statistics/median.h"

namespace firn::flow {
namespace {

constexpr double kBare = 0.3;  // of the usual volume: cells with less lie beside the beads
constexpr int kMinShare = 7;   // one part in so many of a square

cv::Mat spread(const HeightMap& map, int reach) {
  const cv::Mat from(map.spec.ny, map.spec.nx, CV_64F, const_cast<double*>(map.cells.data()));
  cv::Mat to;
  cv::boxFilter(from, to, CV_64F, {2 * reach + 1, 2 * reach + 1}, {-1, -1}, true, cv::BORDER_CONSTANT);
  return to;
}

// Cells that beads have covered, and all about them; nothing lies beside the grid.
cv::Mat inside(const cv::Mat& laid, int rim) {
  std::vector<double> some;
  std::copy_if(laid.begin<double>(), laid.end<double>(), std::back_inserter(some),
               [](double v) { return v > 0.0; });
  if (some.empty()) return cv::Mat(laid.size(), CV_8U, cv::Scalar(0));
  const double usual = statistics::upper_median(some);
  cv::Mat in;
  cv::erode(laid >= kBare * usual, in, cv::Mat::ones(2 * rim + 1, 2 * rim + 1, CV_8U), {-1, -1}, 1,
            cv::BORDER_CONSTANT, cv::Scalar(0));
  return in;
}

}  // namespace

std::vector<FlowBlock> flow_blocks(const FlowInterval& interval, const BlockOptions& o) {
  const GridSpec& g = interval.rise_mm.spec;
  const cv::Mat nominal[2] = {spread(interval.nominal_mm[0], o.spread),
                              spread(interval.nominal_mm[1], o.spread)};
  const cv::Mat in = inside(nominal[0] + nominal[1], o.rim);
  std::vector<FlowBlock> blocks;
  for (int j = 0; j < g.ny; j += o.side)
    for (int i = 0; i < g.nx; i += o.side) {
      FlowBlock b;
      int cells = 0;
      for (int y = j; y < std::min(g.ny, j + o.side); ++y)
        for (int x = i; x < std::min(g.nx, i + o.side); ++x) {
          const double rise = interval.rise_mm.at(x, y);
          if (!in.at<std::uint8_t>(y, x) || !std::isfinite(rise)) continue;
          ++cells;
          b.rise_mm += rise;
          for (int v = 0; v < 2; ++v) b.nominal_mm[v] += nominal[v].at<double>(y, x);
        }
      if (kMinShare * cells < o.side * o.side) continue;
      b.rise_mm /= cells;
      b.nominal_mm[0] /= cells;
      b.nominal_mm[1] /= cells;
      b.share = double(cells) / (double(o.side) * o.side);
      blocks.push_back(b);
    }
  return blocks;
}

}  // namespace firn::flow
