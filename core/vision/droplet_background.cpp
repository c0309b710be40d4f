// The static background of core/vision/droplets.h: nozzle and dirt that stay while droplets pass.
#include <algorithm>
#include <cmath>

#include "core/vision/droplets.h"

namespace firn::vision {
namespace {

// Chosen on rendered sweeps (tests/bench/droplet_pictures.cpp, seeds below 50,000).
constexpr double kInnerDisc = 0.4;      // radius over the droplet's diameter: clear of the rim's blur
constexpr double kDirtDarkness = 0.75;  // share of a droplet's opacity that all pictures have at dirt
constexpr double kShadow = 0.12;        // mean opacity that a droplet which moves too slowly leaves behind
constexpr double kStill_px = 2.0;       // a main droplet that moves less from picture to picture is dirt
constexpr std::size_t kShadowPictures = 6;  // that are searched for shadows, evenly spread
constexpr int kShadowedPart = 4;            // a background with shadows of more than 1 / 4 of them is none
// Least size of an object at the edge that is the nozzle; a smaller one is dirt.
constexpr long kMinNozzle_px = 150;   // area
constexpr double kNozzleShare = 0.1;  // of the largest one's area

// Mean opacity of a disc about a droplet's place, within its rim.
double mean_opacity(const Scene& scene, const Droplet& d) {
  const double r = kInnerDisc * d.diameter_px;
  const Frame& f = scene.frame();
  double sum = 0.0;
  int n = 0;
  for (int y = std::max(0, int(d.y - r)); y <= std::min(f.height - 1, int(d.y + r)); ++y)
    for (int x = std::max(0, int(d.x - r)); x <= std::min(f.width - 1, int(d.x + r)); ++x)
      if ((x - d.x) * (x - d.x) + (y - d.y) * (y - d.y) <= r * r) {
        sum += scene.opacity(x, y);
        ++n;
      }
  return n > 0 ? sum / n : 0.0;
}

// Is each of the pictures nearly as dark at the droplet's place as its own picture is? Then it is dirt, which
// noise makes a droplet in some of them.
// @param own its picture
bool stays_dark(const std::vector<const Frame*>& pictures, std::size_t own, const Droplet& d,
                Polarity polarity) {
  std::vector<double> opacity;
  for (const Frame* f : pictures) {
    Frame inverted;
    const Illumination illumination = measure_illumination(*f, polarity, inverted);
    opacity.push_back(
        illumination.empty
            ? 0.0
            : mean_opacity(Scene(illumination.inverted ? inverted : *f, illumination, nullptr), d));
  }
  return std::ranges::all_of(opacity, [&](double o) { return o > kDirtDarkness * opacity[own]; });
}

// Is there a shadow in the background where droplets are that move from picture to picture?
bool leaves_shadow(std::span<const Frame* const> frames, const Background& b, const DropletOptions& options) {
  struct Main {
    Droplet droplet;
    std::size_t picture;
  };
  std::vector<const Frame*> pictures;
  std::vector<Main> mains;
  const std::size_t step = (frames.size() + kShadowPictures - 1) / kShadowPictures;
  for (std::size_t k = 0; k < frames.size(); k += step) {
    const DropletPicture p = find_droplets(*frames[k], nullptr, options);
    if (p.state == PictureState::kDrop) mains.push_back({p.main, pictures.size()});
    pictures.push_back(frames[k]);
  }
  Frame inverted;
  const Illumination illumination = measure_illumination(b.frame, Polarity::kDark, inverted);
  if (illumination.empty) return false;
  const Scene scene(b.frame, illumination, nullptr);
  int shadows = 0;
  for (const auto& [d, picture] : mains) {
    int alike = 0;
    for (const auto& [e, other] : mains)
      alike += std::abs(d.x - e.x) < kStill_px && std::abs(d.y - e.y) < kStill_px;
    if (2 * alike > int(mains.size())) continue;  // dirt that stays where it is
    if (mean_opacity(scene, d) > kShadow &&
        !stays_dark(pictures, picture, d, b.inverted ? Polarity::kBright : Polarity::kDark))
      ++shadows;
  }
  return kShadowedPart * shadows > int(mains.size());
}

}  // namespace

Background known_background(const Frame& frame, Polarity objects) {
  if (!is_valid(frame)) return {};
  Background b{frame, std::vector<std::uint8_t>(frame.pixels.size()), false};
  Frame inverted;
  const Illumination illumination = measure_illumination(frame, objects, inverted);
  b.inverted = illumination.inverted;
  if (b.inverted) b.frame = std::move(inverted);
  if (illumination.empty) return b;
  const Scene scene(b.frame, illumination, nullptr);
  const std::vector<Component> components = find_components(scene, kObjectOpacity);
  long largest = 0;
  for (const Component& c : components)
    if (c.at_edge) largest = std::max(largest, c.area);
  for (const Component& c : components) {
    if (!c.at_edge || c.area < kMinNozzle_px || double(c.area) < kNozzleShare * double(largest)) continue;
    for (const Run& r : c.runs)
      std::fill_n(b.nozzle.begin() + std::ptrdiff_t(b.frame.index(r.x0, r.y)), r.x1 - r.x0 + 1,
                  std::uint8_t(1));
  }
  return b;
}

std::optional<Background> find_background(std::span<const Frame* const> frames, bool moves,
                                          const DropletOptions& options) {
  if (frames.empty()) return std::nullopt;
  for (const Frame* f : frames)
    if (!is_valid(*f)) return std::nullopt;
  // The side of the ground on which objects lie is decided by a picture with a droplet, not by the
  // background.
  Frame inverted;
  const bool bright = measure_illumination(*frames.front(), options.polarity, inverted).inverted;
  const Frame still = static_picture(frames, bright);
  if (still.pixels.empty()) return std::nullopt;
  if (!moves && find_droplets(still, nullptr, options).state != PictureState::kNoDrop) return std::nullopt;
  Background b = known_background(still, bright ? Polarity::kBright : Polarity::kDark);
  if (leaves_shadow(frames, b, options)) return std::nullopt;
  return b;
}

}  // namespace firn::vision
