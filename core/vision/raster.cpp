#include "core/vision/raster.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace firn::vision {
namespace {

constexpr int kNoGround = 1 << 30;
constexpr std::uint8_t kReached = 2;

// OpenCV's view of bytes that it only reads, or of the mask's own.
cv::Mat matrix(const std::vector<std::uint8_t>& cells, int columns, int rows) {
  return {rows, columns, CV_8UC1, const_cast<std::uint8_t*>(cells.data())};
}
cv::Mat matrix(const CellMask& m) { return matrix(m.cells, m.columns, m.rows); }

cv::Mat pixels_of(const Frame& f) {
  return {f.height, f.width, CV_16UC1, const_cast<std::uint16_t*>(f.pixels.data())};
}

}  // namespace

Labels label_cells(const CellMask& mask) {
  cv::Mat labels, stats, centroids;
  const int n = cv::connectedComponentsWithStats(matrix(mask), labels, stats, centroids, 8, CV_32S);
  Labels result;
  result.label.assign(labels.ptr<int>(), labels.ptr<int>() + labels.total());
  for (int k = 1; k < n; ++k)
    result.box.push_back({stats.at<int>(k, cv::CC_STAT_LEFT), stats.at<int>(k, cv::CC_STAT_TOP),
                          stats.at<int>(k, cv::CC_STAT_WIDTH), stats.at<int>(k, cv::CC_STAT_HEIGHT),
                          long(stats.at<int>(k, cv::CC_STAT_AREA))});
  return result;
}

std::vector<Component> components_of(const CellMask& mask, int x0, int y0) {
  const Labels labels = label_cells(mask);
  std::vector<Component> found;
  for (const Labels::Box& b : labels.box)
    found.push_back(
        {x0 + b.x0, y0 + b.y0, x0 + b.x0 + b.columns - 1, y0 + b.y0 + b.rows - 1, b.cells, false, {}});
  for (int j = 0; j < mask.rows; ++j)
    for (int i = 0; i < mask.columns;) {
      const int label = labels.label[mask.index(i, j)], from = i;
      while (i < mask.columns && labels.label[mask.index(i, j)] == label) ++i;
      if (label > 0) found[std::size_t(label - 1)].runs.push_back({y0 + j, x0 + from, x0 + i - 1});
    }
  return found;
}

void fill_holes(Silhouette& s) {
  cv::Mat padded, inside = matrix(s.mask, s.columns, s.rows);
  cv::copyMakeBorder(inside, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  cv::floodFill(padded, {0, 0}, kReached, nullptr, 0, 0, 4);
  cv::compare(padded({1, 1, s.columns, s.rows}), kReached, inside, cv::CMP_NE);
}

std::vector<int> squared_distances(const Silhouette& s) {
  cv::Mat padded, distance;
  cv::copyMakeBorder(matrix(s.mask, s.columns, s.rows), padded, !s.top, !s.bottom, !s.left, !s.right,
                     cv::BORDER_CONSTANT, 0);
  std::vector<int> result(s.mask.size(), kNoGround);
  if (cv::countNonZero(padded) == padded.rows * padded.cols) return result;
  cv::distanceTransform(padded, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  for (int j = 0; j < s.rows; ++j)
    for (int i = 0; i < s.columns; ++i) {
      const double d = double(distance.at<float>(j + !s.top, i + !s.left));
      result[std::size_t(j) * std::size_t(s.columns) + std::size_t(i)] = int(std::lround(d * d));
    }
  return result;
}

CellSums connected_sums(CellMask& mask, int i, int j) {
  cv::Mat cells = matrix(mask), reached;
  cv::Rect box;
  cv::floodFill(cells, {i, j}, kReached, &box, 0, 0, 4);
  cv::compare(cells(box), kReached, reached, cv::CMP_EQ);
  const cv::Moments m = cv::moments(reached, true);
  const double x = box.x, y = box.y;
  return {m.m00,
          m.m10 + x * m.m00,
          m.m01 + y * m.m00,
          m.m20 + 2 * x * m.m10 + x * x * m.m00,
          m.m11 + x * m.m01 + y * m.m10 + x * y * m.m00,
          m.m02 + 2 * y * m.m01 + y * y * m.m00,
          box.x == 0,
          box.y == 0,
          box.x + box.width == mask.columns,
          box.y + box.height == mask.rows};
}

CellMask dilated(const CellMask& mask) {
  cv::Mat octagon(7, 7, CV_8UC1, cv::Scalar(1));
  for (const int far : {0, 6})
    for (const int k : {0, 1, 5, 6}) octagon.at<std::uint8_t>(far, k) = 0;
  for (const int far : {1, 5})
    for (const int k : {0, 6}) octagon.at<std::uint8_t>(far, k) = 0;
  CellMask wide(mask.columns, mask.rows);
  cv::Mat to = matrix(wide);
  cv::dilate(matrix(mask), to, octagon);
  return wide;
}

Frame inverted_frame(const Frame& f) {
  Frame g{f.width, f.height, f.white, std::vector<std::uint16_t>(f.pixels.size())};
  cv::Mat to = pixels_of(g);
  cv::subtract(cv::Scalar(f.white), pixels_of(f), to);
  return g;
}

}  // namespace firn::vision
