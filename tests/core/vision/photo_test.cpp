// Pictures as people's cameras leave them, drawn by OpenCV: other light, blur and compression than those of
// the plant's renderer.
#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/vision/droplets.h"

using namespace firn::vision;

namespace {

constexpr double kX = 322.3, kY = 251.7, kRadius = 31.4;  // of the main droplet in a picture 640 px wide

// Places and lengths are those of a picture 640 px wide.
struct Photo {
  cv::Mat grey;  // 0 to 1
  double unit;
  double light_x = 250, light_y = 200;  // where it is brightest
  int quality = 60;                     // of the JPEG file

  Photo(int width, double ground)
      : grey(3 * width / 4, width, CV_32F, cv::Scalar(ground)), unit(width / 640.0) {}

  cv::Point fine(double x, double y) const {
    const auto f = [&](double v) {
      return int(std::lround(((v * unit + 0.5) * kFine - 0.5) * (1 << kShift)));
    };
    return {f(x), f(y)};
  }
  void paint(double level, const cv::Mat& fine_mask) {
    cv::Mat share;
    cv::resize(fine_mask, share, grey.size(), 0, 0, cv::INTER_AREA);
    share.convertTo(share, CV_32F, 1.0 / 255);
    grey = grey.mul(cv::Scalar(1.0) - share) + level * share;
  }
  cv::Mat nothing() const { return cv::Mat(grey.rows * kFine, grey.cols * kFine, CV_8U, cv::Scalar(0)); }
  void disc(double level, double x, double y, double radius) {
    cv::Mat m = nothing();
    cv::circle(m, fine(x, y), int(radius * unit * kFine * (1 << kShift)), 255, cv::FILLED, cv::LINE_8,
               kShift);
    paint(level, m);
  }
  void stem(double level, double x, double from, double to, double half_top, double half_bottom) {
    cv::Mat m = nothing();
    const std::vector<cv::Point> p{fine(x - half_top, from), fine(x + half_top, from),
                                   fine(x + half_bottom, to), fine(x - half_bottom, to)};
    cv::fillPoly(m, std::vector{p}, 255, cv::LINE_8, kShift);
    paint(level, m);
  }
  void nozzle(double level = 0.08) { stem(level, 318, -20, 60, 58, 45); }
  void droplet(double spot) {
    disc(0.1, kX, kY, kRadius);
    if (spot > 0) disc(0.7, kX, kY, spot * kRadius);
  }
  // Lens, light that falls off, sensor.
  void take(double blur, double fall = 0.35, double noise = 0.012) {
    cv::GaussianBlur(grey, grey, {}, blur * unit);
    for (int y = 0; y < grey.rows; ++y)
      for (int x = 0; x < grey.cols; ++x) {
        const double u = (x / unit - light_x) / 640, v = (y / unit - light_y) / 640;
        grey.at<float>(y, x) *= float(1 - fall * std::min(1.0, (u * u + v * v) / 0.4));
      }
    cv::RNG random(1);
    cv::Mat n(grey.size(), CV_32F);
    random.fill(n, cv::RNG::NORMAL, 0.0, noise);
    grey += n;
  }
  DropletPicture seen() const {
    cv::Mat bytes;
    grey.convertTo(bytes, CV_8U, 255.0);
    std::vector<unsigned char> file;
    REQUIRE(cv::imencode(".jpg", bytes, file, {cv::IMWRITE_JPEG_QUALITY, quality}));
    const cv::Mat m = cv::imdecode(file, cv::IMREAD_GRAYSCALE);
    Frame f{m.cols, m.rows, 255, {}};
    f.pixels.assign(m.begin<unsigned char>(), m.end<unsigned char>());
    return find_droplets(f, nullptr);
  }

 private:
  static constexpr int kFine = 4, kShift = 4;
};

void check_main(const Photo& photo, PictureState state = PictureState::kDrop, double y = kY) {
  const DropletPicture p = photo.seen();
  CHECK(p.state == state);
  CHECK(std::hypot(p.main.x - kX * photo.unit, p.main.y - y * photo.unit) < 3.0);
  CHECK(p.main.diameter_px == Approx(2 * kRadius * photo.unit).epsilon(0.03));
}

}  // namespace

TEST_CASE("A photo's droplet is found with any bright spot, from 320 px on, in JPEG of quality 60") {
  for (const int width : {320, 720})
    for (const double spot : {0.0, 0.3, 0.6, 0.85}) {
      CAPTURE(width, spot);
      Photo photo(width, 0.75);
      photo.nozzle();
      photo.droplet(spot);
      photo.take(1.2);
      check_main(photo);
    }
}

TEST_CASE("A photo's droplet may shine before a dark ground, with a dark middle") {
  for (const double spot : {0.0, 0.5, 0.8}) {
    CAPTURE(spot);
    Photo photo(480, 0.06);
    photo.nozzle(0.7);
    photo.disc(0.75, kX, kY, kRadius);
    if (spot > 0) photo.disc(0.1, kX, kY, spot * kRadius);
    photo.take(1.2, 0.0);
    const DropletPicture p = photo.seen();
    CHECK(p.bright);
    check_main(photo);
  }
}

TEST_CASE(
    "A highlight at the side, a fringe, and light that falls off to a tenth leave the droplet in place") {
  Photo side(480, 0.6);
  side.nozzle();
  side.droplet(0.0);
  side.disc(1.3, kX - 19, kY - 15, 6);
  side.take(1.2, 0.0);
  check_main(side);
  Photo fringe(480, 0.65);
  fringe.nozzle();
  fringe.disc(0.8, kX, kY, kRadius + 5);
  fringe.droplet(0.4);
  fringe.take(1.0, 0.7);
  check_main(fringe);
  Photo corner(480, 0.8);
  corner.light_x = corner.light_y = 0;
  corner.nozzle();
  corner.droplet(0.4);
  corner.take(1.2, 0.9);
  check_main(corner);
}

TEST_CASE("A droplet out of focus has the diameter of its edge's middle") {
  for (const int width : {480, 1100}) {
    CAPTURE(width);
    Photo photo(width, 0.75);
    photo.nozzle();
    photo.droplet(0.4);
    photo.take(4.0);
    check_main(photo);
  }
}

TEST_CASE("A ligament to the nozzle, or out of the picture, is said, and one that is torn off is a tail") {
  for (const double half : {1.5, 4.0, 9.0}) {
    CAPTURE(half);
    Photo joined(480, 0.75);
    joined.nozzle();
    joined.stem(0.1, kX, 50, kY - 10, half + 2, half);
    joined.droplet(0.4);
    joined.take(1.2);
    check_main(joined, PictureState::kNotBrokenOff);
  }
  Photo leaves(480, 0.75);
  leaves.stem(0.1, kX, -10, kY - 10, 6, 4);
  leaves.droplet(0.4);
  leaves.take(1.2);
  check_main(leaves, PictureState::kNotBrokenOff);
  Photo torn(480, 0.75);
  torn.nozzle();
  torn.stem(0.1, kX, 130, kY - 10, 2.5, 5);
  torn.droplet(0.4);
  torn.take(1.2);
  check_main(torn);
  CHECK(torn.seen().main.tail_px == Approx((kY - 130 - kRadius) * torn.unit).epsilon(0.1));
}

TEST_CASE("The largest of several droplets is the main one, small ones are satellites") {
  Photo photo(480, 0.75);
  photo.nozzle();
  photo.disc(0.1, 323, 110, 28);
  photo.disc(0.1, 321, 385, 29);
  photo.disc(0.1, 322, 165, 8);
  photo.disc(0.15, 322.5, 190, 5);
  photo.droplet(0.4);
  photo.take(1.2);
  check_main(photo);
  const DropletPicture p = photo.seen();
  CHECK(p.drops.size() == 2);
  CHECK(p.satellites.size() == 2);
}

TEST_CASE("Droplets of several nozzles, side by side with tails or without, are all found") {
  for (const double tail : {0.0, 80.0})
    for (const double width : {1.0, 4.0}) {
      CAPTURE(tail, width);
      Photo photo(640, 0.75);
      photo.stem(0.08, 320, -20, 40, 300, 300);
      for (const double x : {kX - 150, kX - 75, kX, kX + 75}) {
        if (tail > 0) photo.stem(0.1, x, kY - 20 - tail, kY, width, width);
        photo.disc(0.1, x, kY, x < kX || x > kX ? 27 : kRadius);
      }
      photo.take(1.0);
      check_main(photo);
      CHECK(photo.seen().drops.size() == 3);
    }
}
