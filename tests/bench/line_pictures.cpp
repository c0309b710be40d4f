// Measures how core/vision reads lines in rendered pictures, drawn at random.
//   line_pictures [PICTURES=500 [SEED=7400000 [FLAT=1]]]; FLAT = 0: without pictures of the bare substrate
// The settings of core/vision/line_picture.cpp were chosen on seeds below 50000.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <string_view>
#include <vector>

#include "core/vision/line_picture.h"
#include "plant/aerosol/line_picture.h"
#include "tests/bench/bench.h"
#include "tests/bench/drawn_light.h"

namespace firn::bench::line_pictures {

using namespace firn;
using namespace firn::plant;
using namespace firn::vision;

namespace {

constexpr int kBare = 9;
constexpr LightRange kLight{1.8, 0.85, 0.03, 9};

struct Wave {
  double amplitude = 0.0, per_px = 0.0, phase = 0.0;
  double at(double a) const { return amplitude * std::sin(per_px * a + phase); }
};

// A line in px, along (a) and across (c) from the middle of the wanted one.
struct DrawnLine {
  double sigma_px = 9.0, peak = 2.0;  // optical depths at the middle
  double offset_px = 0.0, tilt = 0.0;
  Wave wander, breath, flow;
  double halo_share = 0.0, halo_wide = 4.0;
  double neighbour_px = 0.0;  // 0: there is none
  struct Missing {
    double from = 0.0, to = 0.0, soft = 1.0;
  };
  std::vector<Missing> missing;
  struct Spot {
    double a = 0.0, c = 0.0, radius = 1.0;
  };
  std::vector<Spot> spots;

  double sigma(double a) const { return sigma_px * (1 + breath.at(a)); }
  double middle(double a) const { return offset_px + tilt * a + wander.at(a); }
  double amount(double a) const {
    double m = 1 + flow.at(a);
    for (const Missing& g : missing)
      m *= 1 - 0.5 * (std::erf((a - g.from) / g.soft) - std::erf((a - g.to) / g.soft)) * 0.999;
    return m;
  }
  double depth(double a, double c) const {
    const auto section = [&](double x) {
      const double s = sigma(a), h = halo_wide * s;
      return (1 - halo_share) * std::exp(-0.5 * x * x / (s * s)) +
             halo_share / halo_wide * std::exp(-0.5 * x * x / (h * h));
    };
    double d = section(c - middle(a)) * peak * amount(a);
    if (neighbour_px != 0.0) d += peak * section(c - neighbour_px);
    for (const Spot& s : spots)
      if ((a - s.a) * (a - s.a) + (c - s.c) * (c - s.c) < s.radius * s.radius) d += 1.0;
    return d;
  }
};

struct DrawnPicture {
  LineCamera camera;
  LineView view;
  LinePictureOptions options;
  DrawnLine line;
  double contrast(double a, double c) const { return ink_contrast(line.depth(a, c), 1.0); }
};

DrawnPicture draw_line(std::uint64_t seed) {
  RandomStream r(seed, Purpose::kTest, 2);
  DrawnPicture d;
  LineCamera& c = d.camera;
  c.um_per_px = r.uniform(2.5, 5);
  draw_light(r, kLight, c);
  c.contrast = r.uniform(0.7, 0.98);
  c.bright = r.uniform() < 0.2;
  draw_noise(r, c);
  c.optical_depth_mm = 1.0;  // thickness is drawn in optical depths
  draw_dirt(r, kLight, c);

  DrawnLine& l = d.line;
  const double width_px = r.uniform(14, 36);
  l.sigma_px = width_px / 2.3548;
  l.peak = std::pow(10.0, r.uniform(-0.5, 1.1));
  l.offset_px = r.uniform(-12, 12);
  l.tilt = r.uniform(-0.008, 0.008);
  l.wander = {r.uniform(0, 0.6), 2 * std::numbers::pi / r.uniform(40, 200), r.uniform(0, 6)};
  l.breath = {r.uniform(0, 0.03), 2 * std::numbers::pi / r.uniform(60, 300), r.uniform(0, 6)};
  l.flow = {r.uniform(0, 0.05), 2 * std::numbers::pi / r.uniform(60, 300), r.uniform(0, 6)};
  l.halo_share = r.uniform(0, 0.12);
  l.halo_wide = r.uniform(3, 4.5);
  LineView& v = d.view;
  v.width_px = width_px * r.uniform(0.85, 1.2);
  v.window_px = std::min(150.0, r.uniform(4.0, 6.0) * width_px);
  if (r.uniform() < 0.3) l.neighbour_px = (r.uniform() < 0.5 ? -2 : 2) * v.window_px;
  const double side = r.uniform();
  double angle = side < 0.4 ? 0.0 : side < 0.6 ? 0.5 * std::numbers::pi : r.uniform(0, 6.28);
  v.direction = side < 0.4   ? Point{1, 0}
                : side < 0.6 ? Point{0, -1}
                             : Point{std::cos(angle), -std::sin(angle)};
  v.middle = {0.5 * (c.width - 1) + r.uniform(-10, 10), 0.5 * (c.height - 1) + r.uniform(-10, 10)};
  v.length_px = r.uniform(140, 280);
  const double half = 0.5 * v.length_px;
  if (r.uniform() < 0.35)
    for (std::uint32_t k = 1 + r.below(2); k > 0; --k) {
      const double length = r.uniform(6, 40), from = r.uniform(-half + 12, half - 12 - length);
      const bool apart = std::ranges::all_of(
          l.missing, [&](const auto& g) { return from > g.to + 15 || from + length < g.from - 15; });
      if (apart) l.missing.push_back({from, from + length, r.uniform(0.7, 2.5)});
    }
  if (r.uniform() < 0.3)
    for (std::uint32_t k = 4 + r.below(25); k > 0; --k)
      l.spots.push_back({r.uniform(-half, half), r.uniform(-v.window_px, v.window_px), r.uniform(0.7, 2.2)});
  d.options.blur_px = c.blur_px + 0.1 * r.normal();
  return d;
}

Frame frame_of_lines(TakenPicture&& p) { return {p.width, p.height, p.white, std::move(p.pixels)}; }

struct Truth {
  double left = 0.0, right = 0.0, overspray = 0.0;
  std::vector<LineGap> gaps;
};

// The same words on the surface itself: no blur, noise or light.
Truth truth_of(const DrawnPicture& d) {
  Truth t;
  const double half = 0.5 * std::floor(d.view.length_px), window = std::floor(d.view.window_px);
  const double nominal = 2.3548 * d.line.sigma_px;
  const auto in_gap = [&](double a, double clear) {
    return std::ranges::any_of(d.line.missing,
                               [&](const auto& g) { return a > g.from - clear && a < g.to + clear; });
  };
  int rows = 0;
  double all = 0.0, beside = 0.0;
  for (double a = -half + 0.5; a < half; a += 1.0) {
    if (in_gap(a, 8.0)) continue;
    const double m = d.line.middle(a), peak = d.contrast(a, m);
    double edge[2];
    for (const int side : {0, 1}) {
      double in = m, out = m + (side == 0 ? -2 : 2) * nominal;
      for (int n = 0; n < 20; ++n) {
        const double half = 0.5 * (in + out);
        (d.contrast(a, half) >= 0.5 * peak ? in : out) = half;
      }
      edge[side] = 0.5 * (in + out);
    }
    t.right += edge[0];
    t.left += edge[1];
    ++rows;
    const double width = edge[1] - edge[0], middle = 0.5 * (edge[0] + edge[1]);
    for (double c = -window; c <= window; c += 1.0) {
      const double k = d.contrast(a, c);
      all += k;
      if (std::abs(c - middle) > 1.3 * width) beside += k;
    }
  }
  t.left /= rows;
  t.right /= rows;
  t.overspray = beside / all;
  for (const auto& g : d.line.missing) {
    const auto crossing = [&](double a, double step) {
      const auto level = [&](double at) {
        double sum = 0.0;
        for (int k = -4; k <= 4; ++k) {
          const double c = d.line.middle(at) + 0.3 * (t.left - t.right) * k / 4.0;
          DrawnLine whole = d.line;
          whole.missing.clear();
          sum += d.contrast(at, c) / ink_contrast(whole.depth(at, c), 1.0) / 9;
        }
        return sum;
      };
      while (level(a) < 0.5) a += step;
      return a;
    };
    const double middle = 0.5 * (g.from + g.to);
    t.gaps.push_back({crossing(middle, -0.02) + half - 0.5, crossing(middle, 0.02) + half - 0.5, 0.0});
  }
  return t;
}

struct Score {
  std::vector<double> error;  // in the unit of the limit
  double sum = 0.0;
  int covered = 0, within = 0;
  void add(double off, double std, double limit) {
    covered += std::abs(off) <= 1.96 * std;
    within += std::abs(off) <= limit;
    sum += off / limit;
    error.push_back(std::abs(off) / limit);
  }
  void print(const char* name, const char* limit) {
    if (error.empty()) return;
    std::sort(error.begin(), error.end());
    double square = 0;
    for (const double e : error) square += e * e;
    const double n = double(error.size());
    std::printf(
        "%-12s n %4zu  within %s: %5.1f %%  mean %+.3f  rms %.3f  99th %.3f  worst %.3f of it  95 %% "
        "intervals cover %.1f %%\n",
        name, error.size(), limit, 100 * within / n, sum / n, std::sqrt(square / n),
        error[error.size() * 99 / 100], error.back(), 100 * covered / n);
  }
};

}  // namespace

FIRN_BENCH(line_pictures) {
  std::uint64_t numbers[3] = {500, 7400000, 1};
  for (int k = 1; k < argc; ++k) {
    const std::string_view text = argv[k];
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), numbers[std::min(k, 3) - 1]);
    if (k > 3 || error != std::errc{} || end != text.data() + text.size() || numbers[0] > 1'000'000) {
      std::fprintf(stderr, "usage: line_pictures [PICTURES [SEED [FLAT]]], PICTURES at most 1000000\n");
      return text == "--help" ? 0 : 2;
    }
  }
  const bool verbose = std::getenv("VERBOSE") != nullptr;
  Score width, edges, gaps, overspray;
  int unseen = 0, missed = 0, wrong = 0, wanted = 0, empty_seen = 0;
  double ms = 0.0;
  for (std::uint64_t k = 0; k < numbers[0]; ++k) {
    const std::uint64_t seed = numbers[1] + k;
    const DrawnPicture d = draw_line(seed);
    std::vector<Frame> bare;
    for (int b = 0; b < kBare; ++b)
      bare.push_back(frame_of_lines(render_lines(d.camera, nullptr, seed, 100 + std::uint32_t(b))));
    std::vector<const Frame*> pointers;
    for (const Frame& f : bare) pointers.push_back(&f);
    const Frame flat = flat_field(pointers);
    const Frame* light = numbers[2] != 0 ? &flat : nullptr;
    const Point u = d.view.direction, left{u.y, -u.x};
    const double scale = d.camera.um_per_px / 1e3;
    const auto thickness = [&](std::span<const double> x_mm, std::span<const double> y_mm,
                               std::span<double> ink_mm) {
      for (std::size_t n = 0; n < ink_mm.size(); ++n) {
        const double x = x_mm[n] / scale + 0.5 * (d.camera.width - 1) - d.view.middle.x,
                     y = -y_mm[n] / scale + 0.5 * (d.camera.height - 1) - d.view.middle.y;
        ink_mm[n] = d.line.depth(x * u.x + y * u.y, x * left.x + y * left.y);
      }
    };
    const Frame frame = frame_of_lines(render_lines(d.camera, thickness, seed, 0));
    const double began = 1e3 * double(std::clock()) / CLOCKS_PER_SEC;
    const LinePictureReading r = measure_line_picture(frame, light, d.view, d.options);
    ms += 1e3 * double(std::clock()) / CLOCKS_PER_SEC - began;
    empty_seen += measure_line_picture(bare[0], light, d.view, d.options).seen;
    if (!r.seen) {
      ++unseen;
      if (verbose)
        std::printf("  %llu unseen: peak %.2f contrast %.2f light %.2f\n", (unsigned long long)seed,
                    d.line.peak, d.camera.contrast, d.camera.light);
      continue;
    }
    const Truth t = truth_of(d);
    const double true_width = t.left - t.right;
    width.add(r.width_px / true_width - 1, r.width_std_px / true_width, 0.03);
    edges.add(r.left_px - t.left, r.left_std_px, 0.5);
    edges.add(r.right_px - t.right, r.right_std_px, 0.5);
    overspray.add(r.overspray - t.overspray, r.overspray_std, 0.03);
    std::vector<bool> used(r.gaps.size());
    for (const LineGap& g : t.gaps) {
      ++wanted;
      bool found = false;
      for (std::size_t n = 0; n < r.gaps.size() && !found; ++n)
        if (!used[n] && r.gaps[n].from_px < g.to_px && r.gaps[n].to_px > g.from_px) {
          found = used[n] = true;
          gaps.add(r.gaps[n].from_px - g.from_px, r.gaps[n].std_px, 1.0);
          gaps.add(r.gaps[n].to_px - g.to_px, r.gaps[n].std_px, 1.0);
        }
      missed += !found;
      if (!found && verbose)
        std::printf("  %llu gap %.1f to %.1f missed\n", (unsigned long long)seed, g.from_px, g.to_px);
    }
    for (const bool one : used) wrong += !one;
    if (verbose && (std::abs(r.width_px / true_width - 1) > 0.02 || std::abs(r.left_px - t.left) > 0.4 ||
                    std::abs(r.right_px - t.right) > 0.4 || std::abs(r.overspray - t.overspray) > 0.03 ||
                    std::ranges::count(used, false) > 0))
      std::printf(
          "  %llu width %.2f (%.2f +- %.2f) left %.2f (%.2f +- %.2f) right %.2f (%.2f) over %.3f (%.3f +- "
          "%.3f) gaps "
          "%zu (%zu) peak %.2f contrast %.2f bright %d light %.2f blur %.2f (%.2f) dir %.2f %.2f noise %.3f "
          "%.3f halo %.2f\n",
          (unsigned long long)seed, true_width, r.width_px, r.width_std_px, t.left, r.left_px, r.left_std_px,
          t.right, r.right_px, t.overspray, r.overspray, r.overspray_std, t.gaps.size(), r.gaps.size(),
          d.line.peak, d.camera.contrast, d.camera.bright, d.camera.light, d.camera.blur_px,
          d.options.blur_px, u.x, u.y, d.camera.read_noise, d.camera.shot_noise, d.line.halo_share);
  }
  std::printf(
      "%llu pictures of lines, %d not seen; %d lines in as many bare pictures; %.2f ms CPU a picture\n",
      (unsigned long long)numbers[0], unseen, empty_seen, ms / double(numbers[0]));
  width.print("width", "3 %");
  edges.print("edge", "0.5 px");
  overspray.print("overspray", "0.03");
  gaps.print("gap's end", "1 px");
  std::printf("gaps: %d, %d missed, %d false\n", wanted, missed, wrong);
  return 0;
}

}  // namespace firn::bench::line_pictures
