// Measures core/vision on drawn photographs that nothing was set on: several droplets, ligaments, satellites,
// light from one side, dark or bright field, defocus, JPEG; then on as many of dispensers
// (tests/bench/dispenser_photo.h).
//   droplet_photos [PHOTOS=300 [SEED=610000 [FOLDER]]]; FOLDER: the photos that are misread are written there
// VERBOSE=1 names each of them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "core/vision/droplets.h"
#include "tests/bench/dispenser_photo.h"

using namespace firn;
using namespace firn::vision;

namespace {

struct DrawnPhoto {
  int width = 640, height = 480, quality = 75;
  double unit = 1.0;                      // px of a length in a photo 640 px wide
  double x = 0.0, y = 0.0, radius = 0.0;  // of the main droplet [px]
  bool dark_field = false, joined = false, side_light = false, soft = false, small = false;
  cv::Mat grey;
};

/// Paints where `inside` [px, > 0 inside] says; the edge takes one pixel.
void paint_shape(cv::Mat& grey, double level, const std::function<double(double, double)>& inside) {
  for (int y = 0; y < grey.rows; ++y)
    for (int x = 0; x < grey.cols; ++x) {
      const double share = std::clamp(0.5 + inside(x, y), 0.0, 1.0);
      float& v = grey.at<float>(y, x);
      v = float(v * (1.0 - share) + level * share);
    }
}

void paint_disc(cv::Mat& grey, double level, double cx, double cy, double radius) {
  paint_shape(grey, level, [=](double x, double y) { return radius - std::hypot(x - cx, y - cy); });
}

/// From y = from down to y = to, its half width from half_top to half_bottom.
void paint_stem(cv::Mat& grey, double level, double cx, double from, double to, double half_top,
                double half_bottom) {
  paint_shape(grey, level, [=](double x, double y) {
    const double share = std::clamp((y - from) / (to - from), 0.0, 1.0);
    return std::min({half_top + share * (half_bottom - half_top) - std::abs(x - cx), y - from, to - y});
  });
}

void light_and_noise(RandomStream& r, DrawnPhoto& p) {
  cv::GaussianBlur(p.grey, p.grey, {},
                   std::max(0.6, (p.soft ? r.uniform(2.0, 4.0) : r.uniform(0.6, 1.8)) * p.unit));
  p.side_light = r.uniform() < 0.5;
  const double slope = p.side_light ? r.uniform(0.3, 0.8) * (r.uniform() < 0.5 ? -1 : 1) : 0.0,
               fall = r.uniform(0.0, 0.4), noise = r.uniform(0.003, 0.02);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      const double u = 2.0 * x / p.width - 1, v = 2.0 * y / p.height - 1;
      float& at = p.grey.at<float>(y, x);
      at = float(at * (1 + 0.5 * slope * u) * (1 - 0.5 * fall * (u * u + v * v)) + noise * r.normal());
    }
}

DrawnPhoto draw_photo(std::uint64_t seed) {
  RandomStream r(seed, Purpose::kTest);
  DrawnPhoto p;
  p.width = int(200 * std::pow(2048.0 / 200, r.uniform()));
  p.height = int(p.width * r.uniform(0.7, 1.1));
  p.unit = p.width / 640.0;
  p.quality = 40 + int(r.below(51));
  p.dark_field = r.uniform() < 0.3;
  const double ground = p.dark_field ? r.uniform(0.04, 0.12) : r.uniform(0.5, 0.75),
               liquid = p.dark_field ? r.uniform(0.5, 0.8) : r.uniform(0.06, 0.2);
  p.grey = cv::Mat(p.height, p.width, CV_32F, cv::Scalar(ground));
  p.radius = std::max(8.0, r.uniform(14, 40) * p.unit);
  p.small = p.radius < 12.0;
  p.x = p.width * r.uniform(0.4, 0.6);
  p.y = p.height * r.uniform(0.5, 0.62);
  const double nozzle_end = p.height * r.uniform(0.06, 0.12);
  paint_stem(p.grey, liquid, p.x + r.uniform(-3, 3) * p.unit, -9, nozzle_end, p.radius * 1.9, p.radius * 1.5);
  p.joined = r.uniform() < 0.35;
  if (p.joined) {
    const double half = std::max(1.5, r.uniform(0.06, 0.25) * p.radius);
    paint_stem(p.grey, liquid, p.x, nozzle_end - 3, p.y, half * 1.5, half);
  } else if (r.uniform() < 0.3) {  // a tail
    paint_stem(p.grey, liquid, p.x, p.y - p.radius * r.uniform(1.5, 2.2), p.y, 0.04 * p.radius + 0.7,
               0.15 * p.radius);
  }
  const double below = p.height * 0.9 - p.y - p.radius;
  if (!p.joined && r.uniform() < 0.5 && below > 2.6 * p.radius)  // a free one would be the main one
    paint_disc(p.grey, liquid, p.x + r.uniform(-4, 4) * p.unit, p.y + p.radius + 0.6 * below,
               p.radius * r.uniform(0.78, 0.9));
  for (std::uint32_t k = p.joined ? 0 : r.below(3); k > 0; --k)
    paint_disc(p.grey, liquid, p.x + r.uniform(-6, 6) * p.unit,
               nozzle_end + (0.2 + 0.15 * k) * (p.y - nozzle_end), p.radius * r.uniform(0.12, 0.25));
  paint_disc(p.grey, liquid, p.x, p.y, p.radius);
  if (r.uniform() < 0.6)
    paint_disc(p.grey, p.dark_field ? ground : 0.9 * ground, p.x, p.y, p.radius * r.uniform(0.15, 0.6));
  p.soft = r.uniform() < 0.25;
  light_and_noise(r, p);
  return p;
}

Frame frame_of_file(const std::vector<unsigned char>& file) {
  const cv::Mat m = cv::imdecode(file, cv::IMREAD_GRAYSCALE);
  Frame f{m.cols, m.rows, 255, {}};
  f.pixels.assign(m.begin<unsigned char>(), m.end<unsigned char>());
  return f;
}

std::vector<unsigned char> jpeg_of(const DrawnPhoto& p) {
  cv::Mat bytes;
  p.grey.convertTo(bytes, CV_8U, 255.0);
  std::vector<unsigned char> file;
  cv::imencode(".jpg", bytes, file, {cv::IMWRITE_JPEG_QUALITY, p.quality});
  return file;
}

void write_photo(const char* folder, const std::string& name, const std::vector<unsigned char>& bytes) {
  const bool png = bytes.front() == 0x89;
  std::ofstream file(std::string(folder) + "/" + name + (png ? ".png" : ".jpg"), std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

struct Share {
  const char* name;
  int n = 0, good = 0;
  void add(bool counts, bool is_good) {
    n += counts;
    good += counts && is_good;
  }
  void print() const {
    std::printf("%-28s %d of %d, %.1f %%\n", name, good, n, 100.0 * good / std::max(1, n));
  }
};

void measure_plain(int photos, std::uint64_t seed, const char* folder) {
  Share all{"within 3 px and 3 %"}, ligament{"ligaments said"}, free{"free droplets said free"};
  Share by[] = {{"dark field"},       {"bright field"}, {"light from one side"}, {"out of focus"},
                {"quality below 60"}, {"below 24 px"},  {"above 1000 px wide"},  {"joined"}};
  for (int k = 0; k < photos; ++k) {
    const DrawnPhoto p = draw_photo(seed + std::uint64_t(k));
    const std::vector<unsigned char> file = jpeg_of(p);
    const DropletPicture found = find_droplets(frame_of_file(file), nullptr);
    const double off = std::hypot(found.main.x - p.x, found.main.y - p.y),
                 ratio = 0.5 * found.main.diameter_px / p.radius;
    const bool good = found.state != PictureState::kNoDrop && off <= 3.0 && std::abs(ratio - 1.0) <= 0.03;
    all.add(true, good);
    ligament.add(p.joined, found.state == PictureState::kNotBrokenOff);
    free.add(!p.joined, found.state == PictureState::kDrop);
    const bool kinds[] = {
        p.dark_field, !p.dark_field, p.side_light, p.soft, p.quality<60, p.small, p.width> 1000, p.joined};
    for (std::size_t n = 0; n < std::size(by); ++n) by[n].add(kinds[n], good);
    if (folder && !good) write_photo(folder, "photo_" + std::to_string(k), file);
    if (!good && std::getenv("VERBOSE"))
      std::printf(
          "  photo %d: state %d, off %.1f px, diameter %.3f of %.1f px, width %d, quality %d%s%s%s%s\n", k,
          int(found.state), off, ratio, 2 * p.radius, p.width, p.quality, p.dark_field ? ", dark field" : "",
          p.joined ? ", joined" : "", p.side_light ? ", side light" : "", p.soft ? ", soft" : "");
  }
  for (const Share& s : {all, ligament, free}) s.print();
  std::printf("within 3 px and 3 %%, by kind:\n");
  for (const Share& s : by) std::printf("  %-22s %d of %d\n", s.name, s.good, s.n);
}

void measure_dispensers(int photos, std::uint64_t seed, const char* folder) {
  Share all{"as drawn"}, droplets{"droplets within 3 px and 3 %"}, ligament{"ligaments said"},
      free{"free droplets said free"}, empty{"no drop said"};
  std::vector<Share> by;
  for (const char* trait : kPhotoTraits) by.push_back({trait});
  for (int k = 0; k < photos; ++k) {
    const DispenserPhoto p = draw_dispenser(seed + std::uint64_t(k));
    const DropletPicture found = find_droplets(frame_of_file(p.file), nullptr);
    double off = 1e9, ratio = 0.0;
    for (const PhotoDisc& d : p.main)
      if (const double o = std::hypot(found.main.x - d.x, found.main.y - d.y); o < off) {
        off = o;
        ratio = 0.5 * found.main.diameter_px / d.radius;
      }
    const bool drawn = p.state != PictureState::kNoDrop;
    const bool placed = found.state != PictureState::kNoDrop && off <= 3.0 && std::abs(ratio - 1.0) <= 0.03;
    const bool good = found.state == p.state && (placed || !drawn);
    all.add(true, good);
    droplets.add(drawn, placed);
    ligament.add(p.state == PictureState::kNotBrokenOff, found.state == p.state);
    free.add(p.state == PictureState::kDrop, found.state == p.state);
    empty.add(!drawn, found.state == p.state);
    std::string traits;
    for (std::size_t n = 0; n < by.size(); ++n) {
      by[n].add(p.traits[n], good);
      if (p.traits[n]) traits += std::string(", ") + kPhotoTraits[n];
    }
    if (folder && !good) write_photo(folder, "dispenser_" + std::to_string(k), p.file);
    if (!good && std::getenv("VERBOSE"))
      std::printf("  dispenser %d: state %d of %d, off %.1f px, diameter %.3f of %.1f px at %.0f %.0f%s\n", k,
                  int(found.state), int(p.state), off, ratio, drawn ? 2 * p.main.front().radius : 0.0,
                  found.main.x, found.main.y, traits.c_str());
  }
  for (const Share& s : {all, droplets, ligament, free, empty}) s.print();
  std::printf("dispensers as drawn, by trait:\n");
  for (const Share& s : by) std::printf("  %-22s %d of %d\n", s.name, s.good, s.n);
}

}  // namespace

int main(int argc, char** argv) {
  const int photos = argc > 1 ? std::atoi(argv[1]) : 300;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 610000;
  if (argc > 4 || photos < 1) {
    std::fprintf(stderr, "usage: droplet_photos [PHOTOS [SEED [FOLDER]]]\n");
    return 2;
  }
  const char* const folder = argc > 3 ? argv[3] : nullptr;
  measure_plain(photos, seed, folder);
  measure_dispensers(photos, seed, folder);
}
