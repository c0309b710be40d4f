#include "core/vision/scene.h"

#include <algorithm>
#include <cmath>

#include "core/statistics/median.h"

namespace firn::vision {
namespace {

// Median ratio of two pictures over a lattice of pixels, weighted by nothing: objects that move are outliers.
double brightness_ratio(const Frame& a, const Frame& b) {
  std::vector<double> ratio;
  const int step = std::max(1, std::max(a.width, a.height) / 96);
  for (int y = step / 2; y < a.height; y += step)
    for (int x = step / 2; x < a.width; x += step)
      if (b.at(x, y) > a.white / 20) ratio.push_back(double(a.at(x, y)) / double(b.at(x, y)));
  return ratio.size() < 16 ? 1.0 : statistics::median(ratio);
}

class Sets {
 public:
  int add() {
    parent_.push_back(int(parent_.size()));
    return parent_.back();
  }
  int root(int i) {
    while (parent_[std::size_t(i)] != i)
      i = parent_[std::size_t(i)] = parent_[std::size_t(parent_[std::size_t(i)])];
    return i;
  }
  void join(int a, int b) {
    a = root(a);
    b = root(b);
    if (a != b) parent_[std::size_t(std::max(a, b))] = std::min(a, b);
  }
  int size() const { return int(parent_.size()); }

 private:
  std::vector<int> parent_;
};

}  // namespace

Scene::Scene(const Frame& frame, const Light& light, const Background* background)
    : frame_(frame), light_(light), background_(background) {
  if (background_) gain_ = brightness_ratio(frame, background_->frame);
  least_depth_ = std::max(1.0, 0.3 * light.depth);
}

double Scene::ground(int x, int y) const {
  if (background_) {
    const std::size_t i = frame_.index(x, y);
    if (!background_->nozzle[i]) return gain_ * double(background_->frame.pixels[i]);
  }
  const int bx = x / kBlock, by = y / kBlock;
  return double(light_.ground[std::size_t(by) * std::size_t(light_.columns) + std::size_t(bx)]);
}

double Scene::opacity(double x, double y) const {
  x = std::clamp(x, 0.0, double(frame_.width - 1));
  y = std::clamp(y, 0.0, double(frame_.height - 1));
  const int x0 = std::min(int(x), frame_.width - 2), y0 = std::min(int(y), frame_.height - 2);
  const double u = x - x0, v = y - y0;
  return (1 - v) * ((1 - u) * opacity(x0, y0) + u * opacity(x0 + 1, y0)) +
         v * ((1 - u) * opacity(x0, y0 + 1) + u * opacity(x0 + 1, y0 + 1));
}

std::vector<Component> find_components(const Scene& scene, double level) {
  const Light& light = scene.light();
  const Frame& frame = scene.frame();
  std::vector<Run> runs;
  std::vector<std::size_t> row_begin(std::size_t(frame.height) + 1);
  std::vector<int> seen;  // blocks of a row of blocks in which a pixel may be above the level
  // A background picture can be brighter than the smooth ground by its texture.
  const double depth_share = 0.9 * level;
  for (int by = 0; by < light.rows; ++by) {
    seen.clear();
    for (int bx = 0; bx < light.columns; ++bx) {
      const std::size_t i = std::size_t(by) * std::size_t(light.columns) + std::size_t(bx);
      const double g = double(light.ground[i]);
      if (double(light.least[i]) < g - depth_share * (g - light.dark)) seen.push_back(bx);
    }
    for (int y = by * kBlock; y < std::min(frame.height, (by + 1) * kBlock); ++y) {
      row_begin[std::size_t(y)] = runs.size();
      int open = -1, next = 0;  // the run's first pixel, the first pixel behind the last block
      for (const int bx : seen) {
        if (open >= 0 && bx * kBlock > next) {
          runs.push_back({y, open, next - 1});
          open = -1;
        }
        next = (bx + 1) * kBlock;
        for (int x = bx * kBlock; x < std::min(frame.width, (bx + 1) * kBlock); ++x) {
          const bool in = scene.opacity(x, y) > level;
          if (in && open < 0) open = x;
          if (!in && open >= 0) {
            runs.push_back({y, open, x - 1});
            open = -1;
          }
        }
      }
      if (open >= 0) runs.push_back({y, open, std::min(next, frame.width) - 1});
    }
  }
  row_begin[std::size_t(frame.height)] = runs.size();

  Sets sets;
  for (std::size_t i = 0; i < runs.size(); ++i) sets.add();
  for (int y = 1; y < frame.height; ++y) {
    std::size_t above = row_begin[std::size_t(y) - 1];
    const std::size_t above_end = row_begin[std::size_t(y)];
    for (std::size_t i = above_end; i < row_begin[std::size_t(y) + 1]; ++i) {
      while (above < above_end && runs[above].x1 + 1 < runs[i].x0) ++above;
      for (std::size_t a = above; a < above_end && runs[a].x0 <= runs[i].x1 + 1; ++a)
        sets.join(int(a), int(i));
    }
  }
  std::vector<int> number(runs.size(), -1);
  std::vector<Component> components;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::size_t root = std::size_t(sets.root(int(i)));
    const Run& r = runs[i];
    if (number[root] < 0) {
      number[root] = int(components.size());
      components.push_back({r.x0, r.y, r.x1, r.y, 0, false, {}});
    }
    Component& c = components[std::size_t(number[root])];
    c.x0 = std::min(c.x0, r.x0);
    c.x1 = std::max(c.x1, r.x1);
    c.y1 = r.y;
    c.area += r.x1 - r.x0 + 1;
    c.runs.push_back(r);
  }
  for (Component& c : components)
    c.at_edge = c.x0 == 0 || c.y0 == 0 || c.x1 == frame.width - 1 || c.y1 == frame.height - 1;
  return components;
}

Frame static_picture(std::span<const Frame* const> frames, bool bright) {
  Frame result;
  if (frames.size() < 5) return result;
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
  const std::size_t rank = bright ? 3 * (n - 1) / 10 : (7 * (n - 1) + 9) / 10;
  for (std::size_t i = 0; i < result.pixels.size(); ++i) {
    for (std::size_t k = 0; k < frames.size(); ++k)
      v[k] = std::uint16_t(std::min(65535.0, gain[k] * double(frames[k]->pixels[i]) + 0.5));
    const auto at = v.begin() + std::ptrdiff_t(rank);
    std::nth_element(v.begin(), at, v.end());
    result.pixels[i] = *at;
  }
  const double limit = 0.08 * first.white;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    long differ = 0;
    for (std::size_t i = 0; i < result.pixels.size(); ++i)
      differ += std::abs(gain[k] * double(frames[k]->pixels[i]) - double(result.pixels[i])) > limit;
    if (differ > long(result.pixels.size() / 5)) return Frame{};
  }
  return result;
}

}  // namespace firn::vision
