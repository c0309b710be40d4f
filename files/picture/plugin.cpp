#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "files/picture/codecs.h"
#include "files/picture/jpeg_check.h"

using firn::DecodedPicture;

namespace {

/// Lays a picture with transparent pixels on white paper. Without this a picture that is drawn in its opacity
/// alone, as masks are, would be black all over.
void lay_on_white(const cv::Mat& bytes, cv::Mat& grey, DecodedPicture& picture) {
  const cv::Mat all = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  if (all.channels() != 4 || all.size() != grey.size() || all.depth() != grey.depth()) return;
  bool any = false;
  const auto lay = [&]<class Pixel>(Pixel white) {
    for (int y = 0; y < grey.rows; ++y)
      for (int x = 0; x < grey.cols; ++x) {
        const Pixel opacity = all.at<cv::Vec<Pixel, 4>>(y, x)[3];
        if (opacity == white) continue;
        any = true;
        const double share = double(opacity) / white;
        Pixel& p = grey.at<Pixel>(y, x);
        p = Pixel(p * share + white * (1.0 - share) + 0.5);
      }
  };
  if (grey.depth() == CV_8U)
    lay(std::uint8_t(255));
  else
    lay(std::uint16_t(65535));
  if (any) picture.remarks.emplace_back("its transparent pixels are taken as white");
}

bool is_jpeg(std::span<const unsigned char> file) {
  return file.size() > 3 && file[0] == 0xFF && file[1] == 0xD8 && file[2] == 0xFF;
}

}  // namespace

// JPEG, PNG, TIFF, BMP, PNM, WebP and what else OpenCV reads; colours become grey.
extern "C" __attribute__((visibility("default"))) void firn_decode_picture(
    std::span<const unsigned char> file, DecodedPicture& picture) try {
  if (is_jpeg(file))
    if (const std::string damage = firn::damage_of_jpeg(file); !damage.empty()) {
      picture.error = "damaged: " + damage;
      return;
    }
  const cv::Mat bytes(1, int(file.size()), CV_8U, const_cast<unsigned char*>(file.data()));
  cv::Mat image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH);
  if (image.empty()) {
    picture.error = "no picture in a format that is known (JPEG, PNG, TIFF, BMP, PNM), or damaged";
    return;
  }
  if (image.depth() != CV_8U && image.depth() != CV_16U) {
    picture.error = "its pixels have another type than 8 or 16 bits";
    return;
  }
  if (!is_jpeg(file)) lay_on_white(bytes, image, picture);  // JPEG has no transparency
  picture.width = image.cols;
  picture.height = image.rows;
  picture.pixels.resize(std::size_t(image.cols) * std::size_t(image.rows));
  std::uint16_t largest = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const std::uint16_t p =
          image.depth() == CV_8U ? image.at<std::uint8_t>(y, x) : image.at<std::uint16_t>(y, x);
      picture.pixels[std::size_t(y) * std::size_t(image.cols) + std::size_t(x)] = p;
      largest = std::max(largest, p);
    }
  picture.white = image.depth() == CV_8U ? firn::kWhiteOf8Bits : firn::deep_white_level(largest);
} catch (const cv::Exception& e) {
  // A header that promises more than read_picture admits is refused before memory is taken.
  const bool large = e.err.find("CV_IO_MAX_IMAGE") != std::string::npos;
  picture.error = large ? "its header promises more than 268435456 pixels (16384 x 16384)"
                        : std::string("not decoded: ") + e.what();
  std::replace(picture.error.begin(), picture.error.end(), '\n', ' ');
} catch (const std::exception& e) {
  picture.error = std::string("not decoded: ") + e.what();
  std::replace(picture.error.begin(), picture.error.end(), '\n', ' ');
}
