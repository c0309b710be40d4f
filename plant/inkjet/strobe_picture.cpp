#include "plant/inkjet/strobe_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/grid/random.h"

namespace firn::plant {
namespace {

constexpr double kAir_kg_m3 = 1.2;
constexpr double kAirViscosity_Pa_s = 1.8e-5;
constexpr double kLiquid_kg_m3 = 1000.0;

// An ellipse whose axes lie along and across the flight, or a cone between two radii.
struct Shape {
  double x = 0, y = 0, along = 0, across = 0;
  double x1 = 0, y1 = 0, r0 = 0, r1 = 0;
  bool cone = false;
};

struct Axis {
  double x, y;  // flight, px of the picture
};

bool inside(const Shape& s, Axis u, double x, double y) {
  if (s.cone) {
    const double ex = s.x1 - s.x, ey = s.y1 - s.y, length2 = ex * ex + ey * ey;
    if (length2 <= 0) return false;
    const double t = ((x - s.x) * ex + (y - s.y) * ey) / length2;
    if (t < 0 || t > 1) return false;
    const double px = s.x + t * ex - x, py = s.y + t * ey - y, r = s.r0 + t * (s.r1 - s.r0);
    return px * px + py * py <= r * r;
  }
  const double a = (x - s.x) * u.x + (y - s.y) * u.y, b = -(x - s.x) * u.y + (y - s.y) * u.x;
  return a * a / (s.along * s.along) + b * b / (s.across * s.across) <= 1;
}

struct Box {
  int x0, y0, x1, y1;
};

Box box_of(const Shape& s, int w, int h) {
  double lx, hx, ly, hy;
  if (s.cone) {
    const double r = std::max(s.r0, s.r1);
    lx = std::min(s.x, s.x1) - r;
    hx = std::max(s.x, s.x1) + r;
    ly = std::min(s.y, s.y1) - r;
    hy = std::max(s.y, s.y1) + r;
  } else {
    const double r = std::max(s.along, s.across);
    lx = s.x - r;
    hx = s.x + r;
    ly = s.y - r;
    hy = s.y + r;
  }
  return {std::clamp(int(lx) - 1, 0, w), std::clamp(int(ly) - 1, 0, h), std::clamp(int(hx) + 3, 0, w),
          std::clamp(int(hy) + 3, 0, h)};
}

// Share of each pixel's area inside any of the shapes: 8 x 8 points.
void cover(std::vector<float>& field, int w, int h, const std::vector<Shape>& shapes, Axis u, float value) {
  constexpr int kPoints = 8;
  for (const Shape& s : shapes) {
    const Box b = box_of(s, w, h);
    for (int y = b.y0; y < b.y1; ++y)
      for (int x = b.x0; x < b.x1; ++x) {
        float& f = field[std::size_t(y) * std::size_t(w) + std::size_t(x)];
        if (f >= value) continue;
        int n = 0;
        for (int j = 0; j < kPoints; ++j)
          for (int i = 0; i < kPoints; ++i) {
            const double px = x - 0.5 + (i + 0.5) / kPoints, py = y - 0.5 + (j + 0.5) / kPoints;
            bool in = false;
            for (const Shape& t : shapes) in = in || inside(t, u, px, py);
            n += in;
          }
        f = std::max(f, value * float(n) / (kPoints * kPoints));
      }
  }
}

struct Drawing {
  std::vector<Shape> objects, spots;
};

void draw_jet(const StrobeCamera& c, const StrobeJet& jet, double delay, Axis u, Drawing& d,
              StrobeTruth& truth) {
  const double px = 1 / c.um_per_px, radius = 0.5 * jet.diameter_um * px;
  const auto place = [&](double um) {
    return std::pair{c.nozzle_x_px + u.x * um * px, c.nozzle_y_px + u.y * um * px};
  };
  if (delay <= 0) return;
  const Flight head = fly(jet.speed_m_s, jet.diameter_um, delay);
  const auto [x, y] = place(head.um);
  const bool free = delay >= jet.break_off_us;
  const double phase = 2 * std::numbers::pi * (delay - jet.break_off_us) / jet.stretch_period_us;
  const double stretch =
      1 + jet.stretch * std::cos(phase) * std::exp(-std::max(0.0, delay - jet.break_off_us) / 150.0);
  d.objects.push_back({x, y, radius * stretch, radius / std::sqrt(stretch)});
  truth.drop = true;
  truth.broken_off = free;
  truth.x_px = x;
  truth.y_px = y;
  truth.diameter_px = 2 * radius * std::sqrt(std::sqrt(stretch));  // of the ellipse's area
  truth.inside = x - radius > 2 && y - radius > 2 && x + radius < c.width - 3 && y + radius < c.height - 3;
  if (c.spot > 0) d.spots.push_back({x, y, radius * c.spot_radius, radius * c.spot_radius});
  const double thin = 0.5 * jet.ligament_um * px;
  if (!free) {
    const double share = delay / jet.break_off_us;
    d.objects.push_back({c.nozzle_x_px, c.nozzle_y_px - 2, 0, 0, x, y, (1 - share) * 0.8 * radius + thin,
                         std::max(thin, 0.35 * radius * (1 - share) + thin), true});
    return;
  }
  const double recoil = (delay - jet.break_off_us) / jet.recoil_us;
  if (recoil < 1) {
    const Flight at = fly(jet.speed_m_s, jet.diameter_um, jet.break_off_us);
    truth.tail_px = std::max(0.0, 0.6 * (at.um * px - radius) * (1 - recoil));
    d.objects.push_back({x - u.x * (radius + truth.tail_px), y - u.y * (radius + truth.tail_px), 0, 0, x, y,
                         0.5 * thin, 1.6 * thin, true});
  }
  for (const StrobeSatellite& s : jet.satellites) {
    const Flight at = fly(jet.speed_m_s, jet.diameter_um, jet.break_off_us);
    const Flight on = fly(s.speed_share * at.speed_m_s, s.diameter_um, delay - jet.break_off_us);
    const auto [sx, sy] = place(s.place * at.um + on.um);
    const double r = 0.5 * s.diameter_um * px;
    if (recoil < 1) continue;
    d.objects.push_back({sx, sy, r, r});
    StrobeTruth::Spot spot{sx, sy, 2 * r,
                           sx - r > 3 && sy - r > 3 && sx + r < c.width - 4 && sy + r < c.height - 4, true};
    spot.apart = std::hypot(sx - x, sy - y) - radius - r > 4 + 2 * c.blur_px &&
                 (sy - r > c.nozzle_y_px + 4 + 2 * c.blur_px || c.nozzle_um <= 0);
    truth.satellites.push_back(spot);
  }
  for (StrobeTruth::Spot& a : truth.satellites)
    for (const StrobeTruth::Spot& b : truth.satellites)
      if (&a != &b && std::hypot(a.x_px - b.x_px, a.y_px - b.y_px) <
                          0.5 * (a.diameter_px + b.diameter_px) + 4 + 2 * c.blur_px)
        a.apart = false;
}

void draw_nozzle(const StrobeCamera& c, std::vector<float>& field) {
  if (c.nozzle_um <= 0) return;
  const double half = 0.5 * c.nozzle_um / c.um_per_px;
  for (int y = 0; y < c.height && y - 0.5 < c.nozzle_y_px; ++y) {
    const double rows = std::clamp(c.nozzle_y_px - (y - 0.5), 0.0, 1.0),
                 w = half + c.nozzle_taper * (c.nozzle_y_px - y);
    for (int x = 0; x < c.width; ++x) {
      const double columns =
          std::clamp(std::min(x + 0.5, c.nozzle_x_px + w) - std::max(x - 0.5, c.nozzle_x_px - w), 0.0, 1.0);
      float& f = field[std::size_t(y) * std::size_t(c.width) + std::size_t(x)];
      f = std::max(f, float(rows * columns));
    }
  }
}

}  // namespace

Flight fly(double speed_m_s, double diameter_um, double us) {
  const double d = diameter_um * 1e-6, tau = kLiquid_kg_m3 * d * d / (18 * kAirViscosity_Pa_s);
  Flight f{0.0, speed_m_s};
  constexpr int kSteps = 64;
  const double dt = us * 1e-6 / kSteps;
  const auto slow = [&](double v) {
    const double re = kAir_kg_m3 * std::abs(v) * d / kAirViscosity_Pa_s;
    return -v / tau * (1 + 0.15 * std::pow(re, 0.687));
  };
  for (int i = 0; i < kSteps; ++i) {  // midpoint rule
    const double middle = f.speed_m_s + 0.5 * dt * slow(f.speed_m_s);
    f.um += middle * dt * 1e6;
    f.speed_m_s += dt * slow(middle);
  }
  return f;
}

StrobePicture render_strobe(const StrobeCamera& c, const StrobeJet* jet, double delay_us, std::uint64_t seed,
                            std::uint32_t exposure) {
  StrobePicture p{c.width, c.height, c.white, {}, {}};
  RandomStream random(seed, Purpose::kSensorNoise, exposure);
  const std::size_t n = std::size_t(c.width) * std::size_t(c.height);
  std::vector<float> field(n), bright(n);
  Axis u{0, 1};
  Drawing drawing;
  const double late = random.normal(), energy = random.normal();
  if (jet) {
    const double angle = jet->angle_deg * std::numbers::pi / 180;
    u = {std::sin(angle), std::cos(angle)};
    p.truth.delay_us = delay_us;
    draw_jet(c, *jet, delay_us + jet->jitter_us * late, u, drawing, p.truth);
  }
  cover(field, c.width, c.height, drawing.objects, u, 1.0f);
  draw_nozzle(c, field);
  blur_picture(field, c.width, c.height, c.blur_px);
  if (!drawing.spots.empty()) {
    cover(bright, c.width, c.height, drawing.spots, u, float(c.spot));
    blur_picture(bright, c.width, c.height, c.blur_px);
  }
  const std::vector<float> dirt = soiled(c.dirt, c.width, c.height);
  p.pixels.resize(n);
  const double strobe = 1 + c.flicker * energy;
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      const std::size_t i = std::size_t(y) * std::size_t(c.width) + std::size_t(x);
      const double fx = 2.0 * x / c.width - 1, fy = 2.0 * y / c.height - 1;
      const double ground = c.light * (1 + 0.5 * c.slope_x * fx + 0.5 * c.slope_y * fy -
                                       0.5 * c.vignette * (fx * fx + fy * fy));
      const double opaque = double(field[i]) * c.opacity * (1 - double(bright[i]));
      double level = ground * (1 - opaque) * (1 - double(dirt[i]));
      if (c.bright_objects) level = 0.06 + 0.1 * ground + ground * opaque + 0.1 * double(dirt[i]);
      level = std::max(0.0, level * strobe);
      level += c.read_noise * random.normal() + c.shot_noise * std::sqrt(level) * random.normal();
      p.pixels[i] = std::uint16_t(std::clamp(level * c.white + 0.5, 0.0, double(c.white)));
    }
  return p;
}

}  // namespace firn::plant
