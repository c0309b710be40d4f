#include "report/droplets/droplet_files.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "files/picture/read_picture.h"
#include "files/usage_error.h"

namespace firn::report {
namespace {

using vision::Frame;

constexpr std::size_t kBackgroundPictures = 32;  // more make the background no better

struct ReadPicture {
  Frame frame;                // the part that is measured
  int width = 0, height = 0;  // of the whole picture
  std::vector<std::string> remarks;
};

ReadPicture read_cropped(const std::filesystem::path& file, const DropletRequest& r) {
  DecodedPicture p = read_picture(file);
  const int width = p.width, height = p.height;
  if (r.crop) p = cropped(p, *r.crop, file);
  ReadPicture read{{p.width, p.height, p.white, std::move(p.pixels)}, width, height, std::move(p.remarks)};
  if (!is_valid(read.frame))
    throw UsageError(file.string() + ": " + std::to_string(p.width) + " x " + std::to_string(p.height) +
                     " pixels; sides must be from " + std::to_string(vision::kMinSide) + " to " +
                     std::to_string(vision::kMaxSide));
  return read;
}

// From places in the measured part to places in the whole picture.
void move_by(vision::DropletPicture& p, double x, double y) {
  const auto move = [&](vision::Droplet& d) {
    d.x += x;
    d.y += y;
  };
  move(p.main);
  std::ranges::for_each(p.drops, move);
  std::ranges::for_each(p.satellites, move);
  p.nozzle.edge = {p.nozzle.edge.x + x, p.nozzle.edge.y + y};
}

void check(const DropletRequest& r) {
  if (!r.delays_us.empty() && r.delays_us.size() != r.images.size())
    throw UsageError("--delay-us: " + std::to_string(r.delays_us.size()) + " delays for " +
                     std::to_string(r.images.size()) + " pictures; one each is needed");
  for (const double d : r.delays_us)
    if (!std::isfinite(d) || std::abs(d) > 1e9)
      throw UsageError("--delay-us: " + std::to_string(d) + " is outside -1e9 to 1e9 us");
  if (r.crop && (std::min(r.crop->width, r.crop->height) < vision::kMinSide ||
                 std::max(r.crop->width, r.crop->height) > vision::kMaxSide))
    throw UsageError("--crop: " + std::to_string(r.crop->width) + " x " + std::to_string(r.crop->height) +
                     " pixels; sides must be from " + std::to_string(vision::kMinSide) + " to " +
                     std::to_string(vision::kMaxSide));
  if (r.target.has_value() != (r.pitch_um > 0))
    throw UsageError("--target and --pitch-um are given together");
  if ((r.um_per_px > 0) + (r.nozzle_um > 0) + r.target.has_value() > 1)
    throw UsageError("--scale, --nozzle-um and --target each give the scale: one of them is needed");
}

bool moves(const DropletRequest& r) {
  std::vector<double> d(r.delays_us);
  std::sort(d.begin(), d.end());
  return std::unique(d.begin(), d.end()) - d.begin() >= 5;
}

struct Size {
  int width, height, white;
  auto operator<=>(const Size&) const = default;
};
Size size_of(const Frame& f) { return {f.width, f.height, f.white}; }

// The white level of a camera of more than 8 bits is that of its brightest picture: a file does not hold it,
// and one picture may lie below 1023 where the next one does not. 0 where the pictures have 8 bits.
int deepest_white(const DropletRequest& r) {
  int white = 0;
  const auto is_deep = [&](const std::filesystem::path& file) {
    const int of_file = read_cropped(file, r).frame.white;
    if (of_file > kWhiteOf8Bits) white = std::max(white, of_file);
    return of_file > kWhiteOf8Bits;
  };
  if (r.images.size() + std::size_t(r.background.has_value()) < 2) return 0;
  if (r.background && !is_deep(*r.background)) return 0;
  for (const std::filesystem::path& file : r.images)
    if (!is_deep(file)) break;
  return white;
}

ReadPicture read_cropped(const std::filesystem::path& file, const DropletRequest& r, int deepest) {
  ReadPicture p = read_cropped(file, r);
  if (p.frame.white > kWhiteOf8Bits) p.frame.white = std::max(p.frame.white, deepest);
  return p;
}

// The backgrounds of a sweep, by size of picture.
std::map<Size, std::optional<vision::Background>> backgrounds(const DropletRequest& r, int deepest) {
  std::map<Size, std::optional<vision::Background>> result;
  if (r.background) {
    const Frame f = read_cropped(*r.background, r, deepest).frame;
    result[size_of(f)] = vision::known_background(f, r.objects);
    return result;
  }
  if (!moves(r)) return result;
  std::map<Size, std::vector<Frame>> frames;
  const std::size_t step = (r.images.size() + kBackgroundPictures - 1) / kBackgroundPictures;
  for (std::size_t i = 0; i < r.images.size(); i += step) {
    Frame f = read_cropped(r.images[i], r, deepest).frame;
    frames[size_of(f)].push_back(std::move(f));
  }
  for (const auto& [size, list] : frames) {
    std::vector<const Frame*> pointers;
    for (const Frame& f : list) pointers.push_back(&f);
    result[size] = vision::find_background(pointers, true, {r.objects});
  }
  return result;
}

double saturated_share(const Frame& f) {
  const auto white = std::ranges::count_if(f.pixels, [&](int pixel) { return pixel >= f.white; });
  return double(white) / double(f.pixels.size());
}

}  // namespace

DropletAnalysis analyse_droplets(const DropletRequest& r) {
  check(r);
  DropletAnalysis a;
  const int deepest = deepest_white(r);
  const auto of_size = backgrounds(r, deepest);
  std::vector<vision::DropletPicture> results;
  std::vector<vision::TimedPicture> timed;
  for (std::size_t i = 0; i < r.images.size(); ++i) {
    const ReadPicture read = read_cropped(r.images[i], r, deepest);
    const Frame& f = read.frame;
    const auto found = of_size.find(size_of(f));
    if (r.background && found == of_size.end())
      throw UsageError(r.images[i].string() + ": differs in size or depth from the background " +
                       r.background->string());
    const bool known = found != of_size.end() && found->second.has_value();
    AnalysedPicture p{r.images[i],
                      read.width,
                      read.height,
                      std::nullopt,
                      vision::find_droplets(f, known ? &*found->second : nullptr, {r.objects}),
                      saturated_share(f),
                      read.remarks};
    if (r.crop) move_by(p.result, r.crop->x, r.crop->y);
    results.push_back(p.result);
    if (!r.delays_us.empty()) {
      p.delay_us = r.delays_us[i];
      timed.push_back({r.delays_us[i], p.result});
    }
    a.pictures.push_back(std::move(p));
  }
  if (r.um_per_px > 0) a.scale = {r.um_per_px, 0.0};
  if (r.nozzle_um > 0) {
    a.scale = vision::scale_from_nozzle(results, r.nozzle_um);
    if (!(a.scale.um_per_px > 0))
      throw UsageError(
          "--nozzle-um: no picture shows the edge and both sides of a nozzle; --scale is needed");
  }
  if (r.target) {
    a.scale = vision::scale_from_target(
        vision::find_droplets(read_cropped(*r.target, r).frame, nullptr, {r.objects}), r.pitch_um);
    if (!(a.scale.um_per_px > 0))
      throw UsageError(r.target->string() + ": fewer than 9 equal dots; a calibration target has more");
  }
  if (timed.size() >= 2)
    a.sweep = vision::measure_sweep(timed, a.scale.um_per_px > 0 ? a.scale : vision::Scale{1.0, 0.0});
  return a;
}

}  // namespace firn::report
