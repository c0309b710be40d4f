#include "core/vision/droplets.h"

#include <algorithm>
#include <cmath>

namespace firn::vision {
namespace {

// Values without another reason were chosen on rendered and drawn pictures (tests/bench/droplet_pictures.cpp
// and droplet_photos.cpp, seeds below 50,000). Opacities and shares have no unit.

// Objects.
constexpr double kNoiseStds = 5.0;         // by which an object is above the noise
constexpr double kMaxObjectOpacity = 0.6;  // a picture whose noise asks for a higher level shows no objects
constexpr long kMinObject_px = 3;          // area
constexpr std::size_t kMaxObjects = 300;   // the largest ones: bounds the work of a picture of specks
constexpr long kMinEntering_px = 64;       // area of an object at the picture's edge that may be a nozzle

// Silhouettes.
constexpr int kMaxCells = 60'000;      // of a silhouette's lattice: bounds the work of a large droplet
constexpr std::size_t kRimTenths = 9;  // of an object's pixels that are paler than its rim
constexpr long kRimSamples = 4000;     // pixels of which the rank is taken, at least
constexpr double kMinRim = 0.2,
                 kMaxOutline = 0.5;  // the silhouette is drawn at half of the rim, within these

// Heads: bulges with an edge that can be measured.
constexpr double kMinHeadRadius_px = 3.5;  // of the inscribed circle: a smaller one is a spot
constexpr double kMaxElongation = 3.0;     // of its core: a longer one is a fibre or a ligament
constexpr double kMinCovered = 0.45;       // share of the circumference where the edge is seen
constexpr double kMaxRoughness = 0.08, kMaxRoughness_px = 0.3;  // of the edge: share of the diameter, plus
constexpr double kMaxBlur = 0.35;           // of the diameter: what spreads farther has no plateau
constexpr double kMinTail = 0.35;           // of the diameter: a shorter one is the edge's roughness
constexpr double kMeniscusReach = 0.75;     // of the diameter: a head nearer to the nozzle's edge hangs on it
constexpr std::size_t kMeniscusBulges = 2;  // nozzle and liquid; a ligament has more

// The choice of the main droplet. Liquid refracts the light away at its rim, so droplets are about as dark
// as each other; dirt is paler or lies out of focus. Rank: diameter * hang * min(1, opacity / (kMinDarkness *
// darkest))^3 * min(1, kSharpness * sharpest / blur)^2.
constexpr double kMinDarkness = 0.65;  // opacity of a droplet over that of the darkest one
constexpr double kSharpness = 1.8;     // blur of a droplet over that of the sharpest one
constexpr double kSharp_px = 0.8;      // edge spread below which sharpness says nothing
constexpr double kMeniscusRank = 0.5, kJoinedRank = 0.8;
constexpr double kUsualBlur_px = 1.2;  // where no head shows the picture's own

// Spots: objects without a measurable edge.
constexpr double kMinSpotDarkness = 0.6;  // of the peak that a sharp disc of this area has
constexpr double kSpotBlur_px2 = 0.1;     // about the variance of a pixel's own square, 1 / 12
constexpr double kMaxSpotAxes = 9.0;      // of the principal moments, axes 3 : 1: more is a fibre
constexpr double kSpotMoment_px2 = 0.3;   // lest a spot of few pixels pass for a fibre

// The side of the ground on which objects lie.
constexpr double kMinOpposite = 0.01;  // contrast of the weaker side from which on it is tried, too
constexpr int kSidedLattice = 64;      // samples along the picture's shorter side
constexpr int kSidedRatio = 3;         // of the light of two fifths of the picture: it comes from one side

struct Candidate {
  Droplet droplet;
  Outline outline;
  bool hangs = false;  // on the nozzle without a ligament: a meniscus
};

// The opacity that a tenth of the component's pixels exceed.
double rim_opacity(const Scene& scene, const Component& c) {
  std::vector<float> v;
  const long step = std::max(1L, c.area / kRimSamples);
  long next = 0;  // pixels to go
  for (const Run& r : c.runs) {
    long x = r.x0 + next;
    for (; x <= r.x1; x += step) v.push_back(float(scene.opacity(int(x), r.y)));
    next = x - r.x1 - 1;
  }
  const auto at = v.begin() + std::ptrdiff_t(v.size() * kRimTenths / 10);
  std::nth_element(v.begin(), at, v.end());
  return double(*at);
}

// 1 - exp(-x) by its series: the peak of a blurred disc over its plateau.
double disc_peak(double x) { return 1.0 - 1.0 / (1 + x * (1 + x / 2 * (1 + x / 3 * (1 + x / 4)))); }

Droplet droplet_of(const Outline& o, bool joined) {
  Droplet d;
  d.x = o.x;
  d.y = o.y;
  d.x_std = o.x_std;
  d.y_std = o.y_std;
  d.diameter_px = o.diameter_px;
  d.diameter_std_px = o.diameter_std_px;
  d.opacity = o.opacity;
  d.joined = joined;
  return d;
}

// The components that may be droplets, ligaments or nozzles.
struct Objects {
  std::vector<Component> components;
  std::vector<std::size_t> by_area;  // numbers of components, the largest first
};

Objects find_objects(const Scene& scene) {
  Objects found;
  const double level = std::max(kObjectOpacity, kNoiseStds * scene.noise());
  if (level > kMaxObjectOpacity) return found;
  found.components = find_components(scene, level);
  const std::vector<Component>& c = found.components;
  for (std::size_t i = 0; i < c.size(); ++i)
    if (c[i].area >= kMinObject_px) found.by_area.push_back(i);
  std::stable_sort(found.by_area.begin(), found.by_area.end(),
                   [&](std::size_t a, std::size_t b) { return c[a].area > c[b].area; });
  if (found.by_area.size() > kMaxObjects) found.by_area.resize(kMaxObjects);
  return found;
}

// Tells droplets, satellites, ligaments and nozzle among the objects of one scene.
class DropletFinder {
 public:
  DropletFinder(const Scene& scene, const Objects& objects, const DropletOptions& options)
      : scene_(scene), objects_(objects), options_(options) {}

  void find(DropletPicture& p) {
    find_nozzle(p);
    for (const std::size_t i : objects_.by_area) find_heads(objects_.components[i], p);
    const Candidate* head = best(heads_);
    measure_spots(head);
    if (const Candidate* main = head ? head : best(small_)) {
      set_main(*main, p);
      set_others(*main, p);
    }
  }

 private:
  void find_nozzle(DropletPicture& p) {
    for (const std::size_t i : objects_.by_area) {
      const Component& c = objects_.components[i];
      if (!c.at_edge || c.area < kMinEntering_px) continue;
      p.nozzle = measure_nozzle(scene_, c);
      if (p.nozzle.found) break;
    }
  }

  // The bulges of an object that have an edge; it is a spot if its only one is too small.
  void find_heads(const Component& c, DropletPicture& p) {
    const double outline = std::min(kMaxOutline, 0.5 * std::max(rim_opacity(scene_, c), kMinRim));
    const Silhouette s = make_silhouette(scene_, c, outline, kMaxCells);
    const std::vector<Bulge> bulges = find_bulges(s);
    const bool joined = c.at_edge;
    if (bulges.size() == 1 && bulges.front().at_edge) ++p.cut_off;
    for (const Bulge& b : bulges) {
      if (b.at_edge) continue;
      if (b.radius_px < kMinHeadRadius_px || b.elongation > kMaxElongation) {
        if (!joined && bulges.size() == 1) spots_.push_back(&c);
        continue;
      }
      const Outline o = measure_outline(scene_, s, b);
      if (!is_droplet(o)) continue;
      Candidate found{droplet_of(o, joined), o, false};
      const double tail = b.reach_px - 0.5 * o.diameter_px;
      if (tail > kMinTail * o.diameter_px) found.droplet.tail_px = tail;
      found.hangs = joined && bulges.size() <= kMeniscusBulges && p.nozzle.found &&
                    along_flight({o.x, o.y}, p.nozzle) < kMeniscusReach * o.diameter_px;
      heads_.push_back(found);
    }
  }

  bool is_droplet(const Outline& o) const {
    return o.found && o.opacity >= options_.min_opacity && o.covered >= kMinCovered &&
           o.roughness_px <= kMaxRoughness * o.diameter_px + kMaxRoughness_px &&
           o.blur_px <= kMaxBlur * o.diameter_px;
  }

  static double along_flight(Point at, const Nozzle& n) {
    return (at.x - n.edge.x) * n.flight.x + (at.y - n.edge.y) * n.flight.y;
  }

  // The candidate of the highest rank that is large enough; nullptr: none.
  const Candidate* best(const std::vector<Candidate>& candidates) const {
    double darkest = 0.0, sharpest = 1e9;
    for (const Candidate& c : heads_) {
      darkest = std::max(darkest, std::min(1.0, c.outline.opacity));
      sharpest = std::min(sharpest, std::max(kSharp_px, c.outline.blur_px));
    }
    const auto rank = [&](const Candidate& c) {
      const double dark = std::min(1.0, c.outline.opacity / (kMinDarkness * darkest));
      const double sharp = std::min(1.0, kSharpness * sharpest / std::max(kSharp_px, c.outline.blur_px));
      return c.outline.diameter_px *
             (c.hangs            ? kMeniscusRank
              : c.droplet.joined ? kJoinedRank
                                 : 1.0) *
             dark * dark * dark * sharp * sharp;
    };
    const Candidate* chosen = nullptr;
    for (const Candidate& c : candidates)
      if (c.outline.diameter_px >= options_.min_main_px && (!chosen || rank(c) > rank(*chosen))) chosen = &c;
    return chosen;
  }

  // @param main gives the blur and the level of opaque, or nullptr
  void measure_spots(const Candidate* main) {
    const double opaque = main ? main->outline.opacity : 1.0,
                 blur = main ? main->outline.blur_px : kUsualBlur_px;
    for (const Component* c : spots_) {
      const Outline o = integrate_spot(scene_, *c, opaque);
      if (!o.found || o.diameter_px < options_.min_satellite_px) continue;
      // As dark as a sharp disc of this size would be; dirt and what is out of focus is paler.
      const double radius = 0.5 * o.diameter_px,
                   sharp = disc_peak(radius * radius / (2 * (blur * blur + kSpotBlur_px2)));
      if (o.opacity < std::max(kMinSpotDarkness * opaque * sharp, kNoiseStds * scene_.noise())) continue;
      if (is_fibre(o)) continue;
      small_.push_back({droplet_of(o, false), o, false});
    }
  }

  // By the principal moments: those along x and y are alike for a fibre that lies aslant.
  static bool is_fibre(const Outline& o) {
    const double mean = 0.5 * (o.xx + o.yy), half = 0.5 * (o.xx - o.yy),
                 apart = std::sqrt(half * half + o.xy * o.xy), longest = mean + apart,
                 shortest = std::max(0.0, mean - apart);
    return longest > kMaxSpotAxes * (shortest + kSpotMoment_px2);
  }

  void set_main(const Candidate& main, DropletPicture& p) const {
    p.state = main.droplet.joined ? PictureState::kNotBrokenOff : PictureState::kDrop;
    p.main = main.droplet;
    p.main.axis_ratio = axis_ratio(main.outline, flight(p));
    p.blur_px = main.outline.blur_px;
    if (main.droplet.joined && p.nozzle.found)
      p.main.tail_px = std::max(0.0, along_flight({p.main.x, p.main.y}, p.nozzle) - 0.5 * p.main.diameter_px);
  }

  void set_others(const Candidate& main, DropletPicture& p) const {
    for (const std::vector<Candidate>* list : {&heads_, &small_})
      for (const Candidate& c : *list) {
        if (&c == &main || c.hangs || (list == &heads_ && c.outline.opacity < kMinDarkness * p.main.opacity))
          continue;
        const bool satellite = c.outline.diameter_px < kSatelliteShare * p.main.diameter_px;
        // Beads of the ligament that still joins the main droplet are no satellites yet.
        if (c.droplet.joined && satellite) continue;
        Droplet d = c.droplet;
        d.axis_ratio = axis_ratio(c.outline, flight(p));
        (satellite ? p.satellites : p.drops).push_back(d);
      }
    const auto larger = [](const Droplet& a, const Droplet& b) { return a.diameter_px > b.diameter_px; };
    std::stable_sort(p.drops.begin(), p.drops.end(), larger);
    std::stable_sort(p.satellites.begin(), p.satellites.end(), larger);
  }

  static Point flight(const DropletPicture& p) { return p.nozzle.found ? p.nozzle.flight : Point{0.0, 1.0}; }

  const Scene& scene_;
  const Objects& objects_;
  const DropletOptions& options_;
  std::vector<Candidate> heads_, small_;
  std::vector<const Component*> spots_;
};

// A fifth of the picture has less than a third of the light that another fifth has.
bool has_one_sided_light(const Frame& f) {
  std::vector<std::uint16_t> levels;
  const int step = std::max(1, std::min(f.width, f.height) / kSidedLattice);
  for (int y = step / 2; y < f.height; y += step)
    for (int x = step / 2; x < f.width; x += step) levels.push_back(f.at(x, y));
  std::ranges::sort(levels);
  const std::size_t fifth = levels.size() / 5;
  return levels[levels.size() - 1 - fifth] > kSidedRatio * levels[fifth];
}

// Content of a picture whose objects are taken to be of one polarity.
struct Detection {
  DropletPicture picture;
  double contrast = 0.0;  // squared, of all objects [grey levels^2 px]
  double opposite = 0.0;  // contrast of the ground's other side over this one's
};

Detection detect(const Frame& picture, const Background* background, Polarity polarity,
                 const DropletOptions& options) {
  Detection detection;
  DropletPicture& p = detection.picture;
  Frame inverted;
  const Illumination illumination = measure_illumination(picture, polarity, inverted);
  const Frame& frame = illumination.inverted ? inverted : picture;
  p.bright = illumination.inverted;
  detection.opposite = illumination.opposite;
  if (illumination.empty) return detection;
  p.used_background = background != nullptr;
  const Scene scene(frame, illumination, background);
  p.noise = scene.noise();
  const Objects objects = find_objects(scene);
  for (const std::size_t i : objects.by_area)
    detection.contrast += double(objects.components[i].area) * illumination.depth * illumination.depth;
  DropletFinder(scene, objects, options).find(p);
  return detection;
}

}  // namespace

DropletPicture find_droplets(const Frame& picture, const Background* background,
                             const DropletOptions& options) {
  if (!is_valid(picture)) return {};
  const Polarity polarity = !background            ? options.polarity
                            : background->inverted ? Polarity::kBright
                                                   : Polarity::kDark;
  const Detection first = detect(picture, background, polarity, options);
  if (polarity != Polarity::kAuto) return first.picture;
  const bool bright = first.picture.bright;
  // Glare or shadow on the other side of the ground may have outweighed the objects.
  if (first.opposite > kMinOpposite) {
    const Detection other =
        detect(picture, background, bright ? Polarity::kDark : Polarity::kBright, options);
    if (other.contrast > first.contrast) return other.picture;
  }
  // Before the smooth ground, light from one side may look like a bright object.
  if (bright && first.picture.state == PictureState::kNoDrop && has_one_sided_light(picture)) {
    const Detection dark = detect(picture, background, Polarity::kDark, options);
    if (dark.picture.state != PictureState::kNoDrop) return dark.picture;
  }
  return first.picture;
}

}  // namespace firn::vision
