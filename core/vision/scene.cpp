#include "core/vision/scene.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/statistics/median.h"
#include "core/vision/raster.h"

namespace firn::vision {
namespace {

// Values without another reason were chosen on rendered pictures (tests/bench/droplet_pictures.cpp, seeds
// below 50,000).
constexpr int kRatioLattice = 96;   // samples along the longer side
constexpr int kMinRatioLevel = 20;  // 1 / 20 of white: a darker pixel's ratio is noise
constexpr std::size_t kMinRatioSamples = 16;
constexpr double kCandidateShare = 0.9;  // of the level: a background's texture exceeds the smooth ground
constexpr double kMinDepthShare = 0.3;   // of the typical depth: darker ground has no opacity
constexpr std::size_t kMinStaticPictures = 5;
// Rank of the static level in a pixel's pictures: a ligament, a droplet and its satellites pass in 3 of 10.
constexpr std::size_t kGroundTenths = 7;
constexpr double kMovedShare = 0.08;   // of white by which a pixel differs from the static picture
constexpr std::size_t kMovedPart = 5;  // 1 / 5 of the pixels: more differ in another scene

// Median ratio of two pictures over a lattice of pixels, weighted by nothing: objects that move are outliers.
double brightness_ratio(const Frame& a, const Frame& b) {
  std::vector<double> ratio;
  const int step = std::max(1, std::max(a.width, a.height) / kRatioLattice);
  for (int y = step / 2; y < a.height; y += step)
    for (int x = step / 2; x < a.width; x += step)
      if (b.at(x, y) > a.white / kMinRatioLevel) ratio.push_back(double(a.at(x, y)) / double(b.at(x, y)));
  return ratio.size() < kMinRatioSamples ? 1.0 : statistics::median(ratio);
}

bool precedes(const Component& a, const Component& b) {
  const Run &p = a.runs.front(), &q = b.runs.front();
  return p.y != q.y ? p.y < q.y : p.x0 < q.x0;
}

// The blocks that may hold a pixel above the level, labelled; boxes in blocks.
Labels candidate_blocks(const Illumination& illumination, double level) {
  const double depth_share = kCandidateShare * level;
  CellMask blocks(illumination.columns, illumination.rows);
  for (std::size_t i = 0; i < blocks.cells.size(); ++i) {
    const double g = double(illumination.ground[i]);
    blocks.cells[i] = double(illumination.min_pixel[i]) < g - depth_share * (g - illumination.dark);
  }
  Labels labels = label_cells(blocks);
  long all = 0;
  for (const Labels::Box& b : labels.box) all += long(b.columns) * b.rows;
  if (all <= long(blocks.cells.size())) return labels;
  // Boxes within boxes: one box is less work.
  for (int& l : labels.label) l = std::min(l, 1);
  labels.box = {{0, 0, illumination.columns, illumination.rows, 0}};
  return labels;
}

}  // namespace

Scene::Scene(const Frame& frame, const Illumination& illumination, const Background* background)
    : frame_(frame), illumination_(illumination), background_(background) {
  if (background_) gain_ = brightness_ratio(frame, background_->frame);
  min_depth_ = std::max(1.0, kMinDepthShare * illumination.depth);
}

int Scene::grey_threshold(int x, int y, double level) const {
  const double g = ground(x, y), depth = g - illumination_.dark;
  if (!(depth > min_depth_)) return -1;
  const auto above = [&](int pixel) { return (g - double(pixel)) / depth > level; };
  int pixel = int(std::clamp(g - level * depth, 0.0, 65535.0));  // the place in exact numbers
  while (pixel >= 0 && !above(pixel)) --pixel;
  while (pixel < 65535 && above(pixel + 1)) ++pixel;
  return pixel;
}

double Scene::opacity(double x, double y) const {
  x = std::clamp(x, 0.0, double(frame_.width - 1));
  y = std::clamp(y, 0.0, double(frame_.height - 1));
  const int x0 = std::min(int(x), frame_.width - 2), y0 = std::min(int(y), frame_.height - 2);
  const double u = x - x0, v = y - y0;
  return (1 - v) * ((1 - u) * opacity(x0, y0) + u * opacity(x0 + 1, y0)) +
         v * ((1 - u) * opacity(x0, y0 + 1) + u * opacity(x0 + 1, y0 + 1));
}

// Most of a picture is ground, which the blocks show: pixels are labelled in the boxes of the others alone.
std::vector<Component> find_components(const Scene& scene, double level) {
  const Illumination& illumination = scene.illumination();
  const Frame& frame = scene.frame();
  const Labels blocks = candidate_blocks(illumination, level);
  std::vector<Component> components;
  for (std::size_t n = 0; n < blocks.box.size(); ++n) {
    const Labels::Box& box = blocks.box[n];
    const int x0 = box.x0 * kBlock, y0 = box.y0 * kBlock;
    CellMask above(std::min(frame.width - x0, box.columns * kBlock),
                   std::min(frame.height - y0, box.rows * kBlock));
    std::vector<int> limit(std::size_t(box.columns));
    for (int y = y0; y < y0 + above.rows; ++y)
      for (int bx = box.x0; bx < box.x0 + box.columns; ++bx) {
        if (blocks.label[std::size_t(y / kBlock) * std::size_t(illumination.columns) + std::size_t(bx)] !=
            int(n + 1))
          continue;
        const int from = bx * kBlock, to = std::min(frame.width, from + kBlock);
        std::uint8_t* cell = &above.cells[above.index(from - x0, y - y0)];
        if (scene.has_background()) {
          for (int x = from; x < to; ++x) *cell++ = scene.opacity(x, y) > level;
        } else {
          if (y % kBlock == 0) limit[std::size_t(bx - box.x0)] = scene.grey_threshold(from, y, level);
          const std::uint16_t* pixel = &frame.pixels[frame.index(from, y)];
          for (int x = from; x < to; ++x) *cell++ = int(*pixel++) <= limit[std::size_t(bx - box.x0)];
        }
      }
    std::ranges::move(components_of(above, x0, y0), std::back_inserter(components));
  }
  std::ranges::sort(components, precedes);
  for (Component& c : components)
    c.at_edge = c.x0 == 0 || c.y0 == 0 || c.x1 == frame.width - 1 || c.y1 == frame.height - 1;
  return components;
}

Frame static_picture(std::span<const Frame* const> frames, bool bright) {
  Frame result;
  if (frames.size() < kMinStaticPictures) return result;
  const Frame& first = *frames.front();
  std::vector<double> gain;
  for (const Frame* f : frames) {
    if (f->width != first.width || f->height != first.height || f->white != first.white) return result;
    gain.push_back(brightness_ratio(first, *f));
  }
  result = first;
  std::vector<std::uint16_t> v(frames.size());
  // A pixel is the ground's in most pictures and darkened (or lit) by moving objects in the others.
  const std::size_t n = frames.size();
  const std::size_t rank = bright ? (10 - kGroundTenths) * (n - 1) / 10 : (kGroundTenths * (n - 1) + 9) / 10;
  for (std::size_t i = 0; i < result.pixels.size(); ++i) {
    for (std::size_t k = 0; k < frames.size(); ++k)
      v[k] = std::uint16_t(std::min(65535.0, gain[k] * double(frames[k]->pixels[i]) + 0.5));
    const auto at = v.begin() + std::ptrdiff_t(rank);
    std::nth_element(v.begin(), at, v.end());
    result.pixels[i] = *at;
  }
  const double limit = kMovedShare * first.white;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    long differ = 0;
    for (std::size_t i = 0; i < result.pixels.size(); ++i)
      differ += std::abs(gain[k] * double(frames[k]->pixels[i]) - double(result.pixels[i])) > limit;
    if (differ > long(result.pixels.size() / kMovedPart)) return Frame{};
  }
  return result;
}

}  // namespace firn::vision
