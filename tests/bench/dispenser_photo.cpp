#include "tests/bench/dispenser_photo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/grid/random.h"

namespace firn {
namespace {

using vision::PictureState;

class Painter {
 public:
  explicit Painter(std::uint64_t seed) : r_(seed, Purpose::kTest) {}

  DispenserPhoto draw() {
    choose_picture();
    choose_scene();
    draw_nozzle();
    draw_liquid();
    if (has(PhotoTrait::kReflection)) reflect();
    take();
    colour();
    encode();
    return std::move(p_);
  }

 private:
  bool has(PhotoTrait t) const { return p_.has(t); }
  bool maybe(PhotoTrait t, double chance) {
    p_.traits[std::size_t(t)] = r_.uniform() < chance;
    return has(t);
  }
  void set(PhotoTrait t) { p_.traits[std::size_t(t)] = true; }

  void choose_picture() {
    static constexpr int kSizes[][2] = {{320, 240},   {640, 480},  {800, 600},
                                        {1280, 1024}, {1024, 768}, {1920, 1080}};
    const auto [w, h] = kSizes[r_.below(std::size(kSizes))];
    width_ = w;
    height_ = h;
    if (w == 320) set(PhotoTrait::kSmallPicture);
    const std::uint32_t side = r_.uniform() < 0.6 ? 0 : 1 + r_.below(3);  // top; bottom, left, right
    if (side > 0) set(PhotoTrait::kNozzleAtSide);
    depth_ = side < 2 ? h : w;
    breadth_ = side < 2 ? w : h;
    const double tilt = r_.uniform(-0.08, 0.08), c = std::cos(tilt), s = std::sin(tilt);
    const double m = breadth_ * r_.uniform(0.42, 0.58);
    flight_ = std::array<cv::Point2d, 4>{{{s, c}, {s, -c}, {c, s}, {-c, s}}}[side];
    origin_ = std::array<cv::Point2d, 4>{{{m, 0}, {m, h - 1.0}, {0, m}, {w - 1.0, m}}}[side];
    maybe(PhotoTrait::kDarkField, 0.3);
    ground_ = has(PhotoTrait::kDarkField) ? r_.uniform(0.03, 0.12) : r_.uniform(0.5, 0.85);
    liquid_ = has(PhotoTrait::kDarkField) ? r_.uniform(0.5, 0.9) : r_.uniform(0.05, 0.25) * ground_;
    grey_ = cv::Mat(h, w, CV_32F, cv::Scalar(ground_));
  }

  void choose_scene() {
    const double d = std::min(depth_, breadth_);
    radius_ = std::max(7.0, r_.uniform(0.025, 0.075) * d);
    edge_ = depth_ * r_.uniform(0.05, 0.14);
    along_ = depth_ * r_.uniform(0.42, 0.6);
    const double pick = r_.uniform();
    if (pick < 0.22)
      set(PhotoTrait::kSatellites);
    else if (pick < 0.36)
      set(PhotoTrait::kTrain);
    else if (pick < 0.48)
      set(PhotoTrait::kTail);
    else if (pick < 0.60)
      set(PhotoTrait::kLigament);
    else if (pick < 0.70)
      set(PhotoTrait::kBeads);
    else if (pick < 0.78)
      set(PhotoTrait::kTwoJoined);
    else if (pick < 0.84)
      set(PhotoTrait::kNoDrop);
    else if (pick < 0.92)
      set(PhotoTrait::kMeniscus);
    if (!has(PhotoTrait::kDarkField))
      maybe(PhotoTrait::kSpecularMiddle, 0.6);
    else
      maybe(PhotoTrait::kSpecularMiddle, 0.4);
    middle_ = r_.uniform(0.15, 0.65);
    const bool joined = has(PhotoTrait::kLigament) || has(PhotoTrait::kBeads) || has(PhotoTrait::kMeniscus);
    if (!joined) maybe(PhotoTrait::kReflection, 0.15);
    maybe(PhotoTrait::kVignette, 0.25);
    maybe(PhotoTrait::kMotionBlur, 0.2);
    maybe(PhotoTrait::kDefocus, 0.1);
    if (!joined) maybe(PhotoTrait::kNoNozzle, 0.12);
    if (!has(PhotoTrait::kNoNozzle) && !maybe(PhotoTrait::kTaperedNozzle, 0.3))
      maybe(PhotoTrait::kGlassNozzle, 0.2);
    nozzle_ = radius_ * (r_.uniform() < 0.4 ? r_.uniform(0.6, 1.3) : r_.uniform(1.5, 5.0));
  }

  // Paints where `inside` (along the flight from the nozzle's side, across it) is positive [px].
  template <class Inside>
  void paint(double level, const Inside& inside, double share = 1.0) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const double dx = x - origin_.x, dy = y - origin_.y;
        const double s =
            share * std::clamp(0.5 + inside(dx * flight_.x + dy * flight_.y, dx * flight_.y - dy * flight_.x),
                               0.0, 1.0);
        float& v = grey_.at<float>(y, x);
        v = float(v * (1.0 - s) + level * s);
      }
  }
  void disc(double level, double along, double across, double radius, double share = 1.0) {
    paint(
        level, [=](double a, double b) { return radius - std::hypot(a - along, b - across); }, share);
  }
  void stem(double level, double from, double to, double half_from, double half_to, double across = 0.0) {
    paint(level, [=](double a, double b) {
      const double q = std::clamp((a - from) / (to - from), 0.0, 1.0);
      return std::min({half_from + q * (half_to - half_from) - std::abs(b - across), a - from, to - a});
    });
  }

  void draw_nozzle() {
    if (has(PhotoTrait::kNoNozzle)) return;
    const double outer = has(PhotoTrait::kTaperedNozzle) ? nozzle_ * r_.uniform(1.3, 3.0) : nozzle_;
    stem(liquid_, -60, edge_, outer, nozzle_);
    if (has(PhotoTrait::kGlassNozzle))
      stem(0.7 * ground_ + 0.3 * liquid_, -60, edge_ - 2, 0.5 * nozzle_, 0.5 * nozzle_);
  }

  void droplet(double along, double across, double radius) {
    disc(liquid_, along, across, radius);
    if (!has(PhotoTrait::kSpecularMiddle)) return;
    const double off = r_.uniform(-0.1, 0.1) * radius;
    disc(has(PhotoTrait::kDarkField) ? 0.5 * (ground_ + liquid_) : r_.uniform(0.7, 1.15) * ground_,
         along + off, across - off, middle_ * radius);
  }

  void add_main(double along, double across, double radius) {
    p_.main.push_back({origin_.x + along * flight_.x + across * flight_.y,
                       origin_.y + along * flight_.y - across * flight_.x, radius});
  }

  void draw_liquid() {
    p_.state = PictureState::kDrop;
    const double gap = along_ - edge_ - radius_;
    if (has(PhotoTrait::kNoDrop) || has(PhotoTrait::kMeniscus)) {
      p_.state = PictureState::kNoDrop;
      if (has(PhotoTrait::kMeniscus)) {
        const double cap = nozzle_ * r_.uniform(0.2, 0.5), half = 0.9 * nozzle_,
                     ball = (half * half + cap * cap) / (2 * cap);
        const double edge = edge_;
        paint(liquid_, [=](double a, double b) {
          return std::min(ball - std::hypot(a - (edge + cap - ball), b), a - edge + 2);
        });
      }
      return;
    }
    if (has(PhotoTrait::kTrain)) {
      const double pitch = radius_ * r_.uniform(2.6, 4.5), wander = r_.uniform(0.0, 0.3) * radius_;
      for (double a = edge_ + 2.5 * radius_; a + 1.6 * radius_ < 0.85 * depth_ && p_.main.size() < 7;
           a += pitch) {
        const double across = r_.uniform(-wander, wander);
        droplet(a, across, radius_);
        add_main(a, across, radius_);
      }
      return;
    }
    double across = r_.uniform(-0.5, 0.5) * radius_;
    if (has(PhotoTrait::kLigament) || has(PhotoTrait::kBeads)) {
      p_.state = PictureState::kNotBrokenOff;
      if (has(PhotoTrait::kNoNozzle)) edge_ = -9;
      across = 0.0;
      const double half = std::max(1.6, r_.uniform(0.07, 0.25) * radius_);
      stem(liquid_, edge_ - 3, along_, half * 1.4, half);
      if (has(PhotoTrait::kBeads))
        for (std::uint32_t k = 1 + r_.below(3), n = k + 1; k > 0; --k)
          disc(liquid_, edge_ + gap * k / n, 0, std::max(half * 1.3, radius_ * r_.uniform(0.25, 0.5)));
    }
    if (has(PhotoTrait::kTail))
      stem(liquid_, along_ - std::min(gap * 0.8, radius_ * r_.uniform(1.6, 5.0)), along_,
           0.04 * radius_ + 0.7, r_.uniform(0.12, 0.3) * radius_, across);
    if (has(PhotoTrait::kTwoJoined)) {
      const double second = radius_ * r_.uniform(0.55, 0.85);
      droplet(along_ + (radius_ + second) * r_.uniform(0.85, 1.0), across + 0.1 * radius_, second);
    }
    if (has(PhotoTrait::kSatellites))
      for (std::uint32_t k = 1 + r_.below(4), n = k + 1; k > 0; --k)
        disc(liquid_, edge_ + gap * k / n, across + r_.uniform(-0.3, 0.3) * radius_,
             std::max(1.5, radius_ * std::min(0.45 * gap / n / radius_, r_.uniform(0.12, 0.45))));
    droplet(along_, across, radius_);
    add_main(along_, across, radius_);
  }

  // A polished substrate shows the scene again, paler.
  void reflect() {
    const double level = std::min(depth_ * 0.82,
                                  along_ + radius_ * r_.uniform(1.5, 4.0) + 0.25 * depth_ * r_.uniform()),
                 share = r_.uniform(0.35, 0.6);
    const cv::Mat scene = grey_.clone();
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const double dx = x - origin_.x, dy = y - origin_.y, a = dx * flight_.x + dy * flight_.y;
        if (a <= level) continue;
        const double far = 2 * (a - level);
        const int mx = int(std::lround(x - far * flight_.x)), my = int(std::lround(y - far * flight_.y));
        const double seen =
            mx >= 0 && my >= 0 && mx < width_ && my < height_ ? scene.at<float>(my, mx) : ground_;
        grey_.at<float>(y, x) = float(0.9 * (share * seen + (1 - share) * ground_));
      }
    const double line = 0.5 * (ground_ + liquid_);
    paint(line, [=](double a, double) { return 1.2 - std::abs(a - level); });
  }

  void take() {
    const double unit = width_ / 640.0;
    cv::GaussianBlur(grey_, grey_, {},
                     has(PhotoTrait::kDefocus)
                         ? std::min(0.25 * radius_, r_.uniform(2.0, 4.0) * unit)
                         : std::clamp(r_.uniform(0.6, 1.6) * unit, 0.6, 0.15 * radius_));
    if (has(PhotoTrait::kMotionBlur)) {
      const double length = r_.uniform(0.1, 0.6) * radius_;
      cv::Mat sum = cv::Mat::zeros(grey_.size(), CV_32F), moved;
      constexpr int kSteps = 9;
      for (int k = 0; k < kSteps; ++k) {
        const double s = length * (double(k) / (kSteps - 1) - 0.5);
        const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, s * flight_.x, 0, 1, s * flight_.y);
        cv::warpAffine(grey_, moved, shift, grey_.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
        sum += moved / kSteps;
      }
      grey_ = sum;
    }
    const double fall = has(PhotoTrait::kVignette) ? r_.uniform(0.5, 0.8) : r_.uniform(0.0, 0.25),
                 slope = r_.uniform(-0.25, 0.25), noise = r_.uniform(0.002, 0.02), cx = r_.uniform(-0.3, 0.3),
                 cy = r_.uniform(-0.3, 0.3);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const double u = 2.0 * x / width_ - 1 - cx, v = 2.0 * y / height_ - 1 - cy;
        float& at = grey_.at<float>(y, x);
        at = float(at * (1 + slope * u) * (1 - fall * std::min(1.0, 0.5 * (u * u + v * v))) +
                   noise * r_.normal());
      }
  }

  // Some cameras tint their pictures.
  void colour() {
    cv::cvtColor(grey_, shown_, cv::COLOR_GRAY2BGR);
    if (!maybe(PhotoTrait::kColour, 0.3)) return;
    const cv::Scalar tint(r_.uniform(0.5, 1.0), r_.uniform(0.9, 1.0), r_.uniform(0.6, 1.1));
    cv::multiply(shown_, tint, shown_);
  }

  void encode() {
    cv::Mat bytes;
    shown_.convertTo(bytes, CV_8UC3, 255.0);
    if (!has(PhotoTrait::kColour)) cv::cvtColor(bytes, bytes, cv::COLOR_BGR2GRAY);
    if (maybe(PhotoTrait::kPalette, 0.12)) {
      const int step = 256 / (16 << r_.below(3));
      for (auto it = bytes.datastart; it != bytes.dataend; ++it) {
        auto& b = *const_cast<unsigned char*>(it);
        b = static_cast<unsigned char>(std::min(255, b / step * step + step / 2));
      }
      cv::imencode(".png", bytes, p_.file);
      return;
    }
    const int quality = 25 + int(r_.below(71));
    if (quality < 50) set(PhotoTrait::kLowQuality);
    cv::imencode(".jpg", bytes, p_.file, {cv::IMWRITE_JPEG_QUALITY, quality});
  }

  RandomStream r_;
  DispenserPhoto p_;
  int width_ = 0, height_ = 0;
  double depth_ = 0.0, breadth_ = 0.0, ground_ = 0.0, liquid_ = 0.0, radius_ = 0.0, edge_ = 0.0, along_ = 0.0,
         nozzle_ = 0.0, middle_ = 0.0;
  cv::Point2d origin_, flight_;
  cv::Mat grey_, shown_;
};

}  // namespace

DispenserPhoto draw_dispenser(std::uint64_t seed) { return Painter(seed).draw(); }

}  // namespace firn
