#include "core/vision/droplets.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/vision/drawn_lines.h"
#include "core/vision/writing.h"

namespace firn::vision {
namespace {

constexpr double kConnect = 0.28;  // opacity that joins pixels to one object
constexpr int kCells = 60'000;     // lattice of a silhouette
constexpr double kPale = 0.65;     // opacity of a droplet over that of the darkest one, at least
// Opacity of the darkest object below which writing has set the level of opaque.
constexpr double kFaint = 0.85;
// Share of contrast on the ground's other side from which on the objects' side is doubtful.
constexpr double kOpposite = 0.01;
constexpr double kSharp_px = 0.8;  // edge spread below which sharpness says nothing
// A nozzle covers a tenth of the largest object at the edge and 150 pixels: less is dirt.
constexpr double kNozzleShare = 0.1;
constexpr long kLeastNozzle = 150;
constexpr double kStaysDark = 0.75;    // of its own opacity: what all pictures have of dirt
constexpr std::size_t kObjects = 300;  // largest ones that are looked at

struct Candidate {
  Droplet droplet;
  Outline outline;
  std::size_t component = 0;
  bool hangs = false;  // on the nozzle without a ligament: a meniscus
};

// The opacity that a tenth of the component's pixels exceed.
double rim_opacity(const Scene& scene, const Component& c) {
  std::vector<float> v;
  const long step = std::max(1L, c.area / 4000);
  long next = 0;  // pixels to go
  for (const Run& r : c.runs) {
    long x = r.x0 + next;
    for (; x <= r.x1; x += step) v.push_back(float(scene.opacity(int(x), r.y)));
    next = x - r.x1 - 1;
  }
  const auto at = v.begin() + std::ptrdiff_t(v.size() * 9 / 10);
  std::nth_element(v.begin(), at, v.end());
  return double(*at);
}

// 1 - exp(-x) by its series: the peak of a blurred disc over its plateau.
double saturation(double x) { return 1.0 - 1.0 / (1 + x * (1 + x / 2 * (1 + x / 3 * (1 + x / 4)))); }

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

struct Box {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

bool holds(const std::vector<Box>& boxes, const Component& c) {
  return std::ranges::any_of(
      boxes, [&](const Box& b) { return c.x0 >= b.x0 && c.y0 >= b.y0 && c.x1 <= b.x1 && c.y1 <= b.y1; });
}

// The components that may be droplets, ligaments or nozzles: without lines and writing that were drawn in.
struct Objects {
  std::vector<Component> components;
  std::vector<std::size_t> order;  // of them, the largest first
  std::vector<Box> written;
};

// @param also_written boxes that hold writing
Objects find_objects(const Scene& scene, const std::vector<Box>& also_written) {
  Objects found;
  const double level = std::max(kConnect, 5 * scene.noise());
  if (level > 0.6) return found;
  std::vector<Component>& components = found.components;
  components = remove_drawn_lines(find_components(scene, level), scene.frame());
  std::vector<std::size_t>& order = found.order;
  for (std::size_t i = 0; i < components.size(); ++i)
    if (components[i].area >= 3) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return components[a].area > components[b].area; });
  if (order.size() > kObjects) order.resize(kObjects);
  const std::vector<bool> written = find_writing(components, order, scene.frame());
  for (const std::size_t i : order)
    if (const Component& c = components[i]; written[i]) found.written.push_back({c.x0, c.y0, c.x1, c.y1});
  std::erase_if(order, [&](std::size_t i) { return written[i] || holds(also_written, components[i]); });
  return found;
}

// The opacity of the darkest object that is not much smaller than the largest.
double darkest_object(const Scene& scene, const Objects& objects) {
  double darkest = 0.0;
  long largest = 0;
  for (const std::size_t i : objects.order) {
    const Component& c = objects.components[i];
    largest = std::max(largest, c.area);
    if (10 * c.area >= largest) darkest = std::max(darkest, rim_opacity(scene, c));
  }
  return darkest;
}

class Picture {
 public:
  Picture(const Scene& scene, Objects&& objects, const DropletOptions& options)
      : scene_(scene), options_(options), components_(std::move(objects.components)) {}

  void look(const std::vector<std::size_t>& order, DropletPicture& p) {
    find_nozzle(order, p);
    for (const std::size_t i : order) look_at(i, p);
    choose(p);
  }

 private:
  void find_nozzle(const std::vector<std::size_t>& order, DropletPicture& p) {
    for (const std::size_t i : order) {
      if (!components_[i].at_edge || components_[i].area < 64) continue;
      p.nozzle = measure_nozzle(scene_, components_[i]);
      if (p.nozzle.found) break;
    }
  }

  void look_at(std::size_t number, DropletPicture& p) {
    const Component& c = components_[number];
    const double rim = rim_opacity(scene_, c);
    const Silhouette s = make_silhouette(scene_, c, std::min(0.5, 0.5 * std::max(rim, 0.2)), kCells);
    const std::vector<Bulge> bulges = find_bulges(s);
    bool edge = false;
    for (const Bulge& b : bulges) edge |= b.at_edge;
    const bool joined = c.at_edge;
    if (edge && bulges.size() == 1) ++p.cut_off;
    for (const Bulge& b : bulges) {
      if (b.at_edge) continue;
      // A fifth of a spot's pixels reach half of its peak; whatever spreads
      // farther has no edge.
      if (b.radius_px < 3.5 || b.elongation > 3.0) {
        if (!joined && bulges.size() == 1) spots_.push_back(number);
        continue;
      }
      const Outline o = measure_outline(scene_, s, b);
      if (!o.found || o.opacity < options_.least_opacity || o.covered < 0.45) continue;
      if (o.roughness_px > 0.08 * o.diameter_px + 0.3 || o.blur_px > 0.35 * o.diameter_px) continue;
      Candidate found{droplet_of(o, joined), o, number, false};
      const double reach = b.reach_px - 0.5 * o.diameter_px;
      if (reach > 0.35 * o.diameter_px) found.droplet.tail_px = reach;
      found.hangs = joined && bulges.size() <= 2 && p.nozzle.found && close_to_nozzle(o, p.nozzle);
      heads_.push_back(found);
    }
  }

  static bool close_to_nozzle(const Outline& o, const Nozzle& n) {
    const double along = (o.x - n.edge.x) * n.flight.x + (o.y - n.edge.y) * n.flight.y;
    return along < 0.75 * o.diameter_px;
  }

  void choose(DropletPicture& p) {
    double darkest = 0.0, sharpest = 1e9;
    for (const Candidate& c : heads_) {
      darkest = std::max(darkest, std::min(1.0, c.outline.opacity));
      sharpest = std::min(sharpest, std::max(kSharp_px, c.outline.blur_px));
    }
    // Liquid refracts the light away at its rim, so droplets are about as dark
    // as each other; dirt is paler or lies out of focus.
    const auto rank = [&](const Candidate& c) {
      const double dark = std::min(1.0, c.outline.opacity / (kPale * darkest));
      const double sharp = std::min(1.0, 1.8 * sharpest / std::max(kSharp_px, c.outline.blur_px));
      return c.outline.diameter_px *
             (c.hangs            ? 0.5
              : c.droplet.joined ? 0.8
                                 : 1.0) *
             dark * dark * dark * sharp * sharp;
    };
    const Candidate* main = nullptr;
    for (const Candidate& c : heads_)
      if (c.outline.diameter_px >= options_.least_main_px && (!main || rank(c) > rank(*main))) main = &c;
    double blur = 1.2, opaque = 1.0;
    if (main) {
      blur = main->outline.blur_px;
      opaque = main->outline.opacity;
    }
    std::vector<Candidate> spots = measure_spots(opaque, blur);
    const Candidate* largest_spot = nullptr;
    if (!main)
      for (const Candidate& c : spots)
        if (c.outline.diameter_px >= options_.least_main_px &&
            (!largest_spot || rank(c) > rank(*largest_spot)))
          main = largest_spot = &c;
    if (!main) return;
    p.state = main->droplet.joined ? PictureState::kNotBrokenOff : PictureState::kDrop;
    p.main = main->droplet;
    p.main.axis_ratio = axis_ratio(main->outline, flight(p));
    p.blur_px = main->outline.blur_px;
    if (main->droplet.joined && p.nozzle.found) {
      const double along =
          (p.main.x - p.nozzle.edge.x) * p.nozzle.flight.x + (p.main.y - p.nozzle.edge.y) * p.nozzle.flight.y;
      p.main.tail_px = std::max(0.0, along - 0.5 * p.main.diameter_px);
    }
    const std::vector<Candidate>* const lists[] = {&heads_, &spots};
    for (const std::vector<Candidate>* list : lists)
      for (const Candidate& c : *list) {
        if (&c == main || c.hangs || (list == &heads_ && c.outline.opacity < kPale * p.main.opacity))
          continue;
        // Beads of the ligament that still joins the main droplet are no
        // satellites yet.
        if (c.droplet.joined && c.outline.diameter_px < kSatelliteShare * p.main.diameter_px) continue;
        Droplet d = c.droplet;
        d.axis_ratio = axis_ratio(c.outline, flight(p));
        (d.diameter_px < kSatelliteShare * p.main.diameter_px ? p.satellites : p.drops).push_back(d);
      }
    const auto larger = [](const Droplet& a, const Droplet& b) { return a.diameter_px > b.diameter_px; };
    std::stable_sort(p.drops.begin(), p.drops.end(), larger);
    std::stable_sort(p.satellites.begin(), p.satellites.end(), larger);
  }

  std::vector<Candidate> measure_spots(double opaque, double blur) const {
    std::vector<Candidate> spots;
    for (const std::size_t number : spots_) {
      const Outline o = integrate_spot(scene_, components_[number], opaque);
      if (!o.found || o.diameter_px < options_.least_satellite_px) continue;
      // As dark as a sharp disc of this size would be; dirt and what is out of
      // focus is paler.
      const double radius = 0.5 * o.diameter_px,
                   sharp = saturation(radius * radius / (2 * (blur * blur + 0.1)));
      if (o.opacity < std::max(0.6 * opaque * sharp, 5 * scene_.noise())) continue;
      // The principal moments: those along x and y are alike for a fibre that lies aslant.
      const double mean = 0.5 * (o.xx + o.yy), half = 0.5 * (o.xx - o.yy),
                   apart = std::sqrt(half * half + o.xy * o.xy), longest = mean + apart,
                   shortest = std::max(0.0, mean - apart);
      if (longest > 9 * (shortest + 0.3)) continue;  // a fibre
      spots.push_back({droplet_of(o, false), o, number, false});
    }
    return spots;
  }

  static Point flight(const DropletPicture& p) { return p.nozzle.found ? p.nozzle.flight : Point{0.0, 1.0}; }

  const Scene& scene_;
  const DropletOptions& options_;
  std::vector<Component> components_;
  std::vector<Candidate> heads_;
  std::vector<std::size_t> spots_;
};

// Mean opacity of a disc of 0.4 diameters about a place.
double mean_opacity(const Scene& scene, const Droplet& d) {
  const double r = 0.4 * d.diameter_px;
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

// Is each of the pictures nearly as dark at the droplet's place as its own
// picture is? Then it is dirt, which noise makes a droplet in some of them.
// @param own its picture
bool stays_dark(const std::vector<const Frame*>& pictures, std::size_t own, const Droplet& d,
                Polarity polarity) {
  std::vector<double> opacity;
  for (const Frame* f : pictures) {
    Frame inverted;
    const Light light = measure_light(*f, polarity, inverted);
    opacity.push_back(light.empty ? 0.0
                                  : mean_opacity(Scene(light.inverted ? inverted : *f, light, nullptr), d));
  }
  return std::ranges::all_of(opacity, [&](double o) { return o > kStaysDark * opacity[own]; });
}

// Is there a shadow in the background where droplets are that move from picture
// to picture?
bool leaves_shadow(std::span<const Frame* const> frames, const Background& b, const DropletOptions& options) {
  struct Main {
    Droplet droplet;
    std::size_t picture;
  };
  std::vector<const Frame*> pictures;
  std::vector<Main> mains;
  const std::size_t step = (frames.size() + 5) / 6;
  for (std::size_t k = 0; k < frames.size(); k += step) {
    const DropletPicture p = find_droplets(*frames[k], nullptr, options);
    if (p.state == PictureState::kDrop) mains.push_back({p.main, pictures.size()});
    pictures.push_back(frames[k]);
  }
  Frame inverted;
  const Light light = measure_light(b.frame, Polarity::kDark, inverted);
  if (light.empty) return false;
  const Scene scene(b.frame, light, nullptr);
  int shadows = 0;
  for (const auto& [d, picture] : mains) {
    int alike = 0;
    for (const auto& [e, other] : mains) alike += std::abs(d.x - e.x) < 2 && std::abs(d.y - e.y) < 2;
    if (2 * alike > int(mains.size())) continue;  // dirt that stays where it is
    if (mean_opacity(scene, d) > 0.12 &&
        !stays_dark(pictures, picture, d, b.inverted ? Polarity::kBright : Polarity::kDark))
      ++shadows;
  }
  return 4 * shadows > int(mains.size());
}

// A fifth of the picture has less than a third of the light that another fifth has.
bool has_one_sided_light(const Frame& f) {
  std::vector<std::uint16_t> levels;
  const int step = std::max(1, std::min(f.width, f.height) / 64);
  for (int y = step / 2; y < f.height; y += step)
    for (int x = step / 2; x < f.width; x += step) levels.push_back(f.at(x, y));
  std::ranges::sort(levels);
  const std::size_t fifth = levels.size() / 5;
  return levels[levels.size() - 1 - fifth] > 3 * levels[fifth];
}

struct Looked {
  DropletPicture picture;
  double contrast = 0.0;  // squared, of all objects [grey levels^2 px]
  double opposite = 0.0;  ///< contrast of the ground's other side over this one's
  std::vector<Box> written;
};

Looked look_at_picture(const Frame& picture, const Background* background, Polarity polarity,
                       const DropletOptions& options, const std::vector<Box>& written = {}) {
  Looked looked;
  DropletPicture& p = looked.picture;
  Frame inverted;
  Light light = measure_light(picture, polarity, inverted);
  const Frame& frame = light.inverted ? inverted : picture;
  p.bright = light.inverted;
  looked.opposite = light.opposite;
  if (light.empty) return looked;
  p.used_background = background != nullptr;
  Objects objects = find_objects(Scene(frame, light, background), written);
  if (!objects.written.empty()) {
    const double darkest = darkest_object(Scene(frame, light, background), objects);
    if (darkest > 0.0 && darkest < kFaint) {
      light.dark += (1.0 - darkest) * light.depth;
      light.depth *= darkest;
      objects = find_objects(Scene(frame, light, background), written);
    }
  }
  const Scene scene(frame, light, background);
  p.noise = scene.noise();
  for (const std::size_t i : objects.order)
    looked.contrast += double(objects.components[i].area) * light.depth * light.depth;
  looked.written = std::move(objects.written);
  const std::vector<std::size_t> order = objects.order;
  Picture(scene, std::move(objects), options).look(order, p);
  return looked;
}

}  // namespace

DropletPicture find_droplets(const Frame& picture, const Background* background,
                             const DropletOptions& options) {
  if (!is_valid(picture)) return {};
  const Polarity polarity = !background            ? options.polarity
                            : background->inverted ? Polarity::kBright
                                                   : Polarity::kDark;
  Looked looked = look_at_picture(picture, background, polarity, options);
  if (polarity != Polarity::kAuto) return looked.picture;
  const bool bright = looked.picture.bright;
  // Writing on the other side of the ground may have outweighed the objects.
  if (looked.opposite > kOpposite) {
    Looked other = look_at_picture(picture, background, bright ? Polarity::kDark : Polarity::kBright, options,
                                   looked.written);
    if (other.contrast > looked.contrast) return other.picture;
  }
  // Before the smooth ground, light from one side may look like a bright object.
  if (bright && looked.picture.state == PictureState::kNoDrop && has_one_sided_light(picture)) {
    Looked dark = look_at_picture(picture, background, Polarity::kDark, options);
    if (dark.picture.state != PictureState::kNoDrop) return dark.picture;
  }
  return looked.picture;
}

Background known_background(const Frame& frame, Polarity objects) {
  if (!is_valid(frame)) return {};
  Background b{frame, std::vector<std::uint8_t>(frame.pixels.size()), false};
  Frame inverted;
  const Light light = measure_light(frame, objects, inverted);
  b.inverted = light.inverted;
  if (b.inverted) b.frame = std::move(inverted);
  if (light.empty) return b;
  const Scene scene(b.frame, light, nullptr);
  const std::vector<Component> components = find_components(scene, kConnect);
  long largest = 0;
  for (const Component& c : components)
    if (c.at_edge) largest = std::max(largest, c.area);
  for (const Component& c : components) {
    if (!c.at_edge || c.area < kLeastNozzle || double(c.area) < kNozzleShare * double(largest)) continue;
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
  // The side of the ground on which objects lie is decided by a picture with a
  // droplet, not by the background.
  Frame inverted;
  const bool bright = measure_light(*frames.front(), options.polarity, inverted).inverted;
  const Frame still = static_picture(frames, bright);
  if (still.pixels.empty()) return std::nullopt;
  if (!moves && find_droplets(still, nullptr, options).state != PictureState::kNoDrop) return std::nullopt;
  Background b = known_background(still, bright ? Polarity::kBright : Polarity::kDark);
  if (leaves_shadow(frames, b, options)) return std::nullopt;
  return b;
}

}  // namespace firn::vision
