#include "files/picture/read_picture.h"

#include <dlfcn.h>
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "files/picture/tiff_pages.h"
#include "files/text_file.h"
#include "files/usage_error.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "firn_picture_codecs.so";

// The programs of a build lie in build/bin, build/tests and build/bench; installed ones in bin.
PictureCodec load() {
  std::error_code error;
  const fs::path home = fs::read_symlink("/proc/self/exe", error).parent_path().parent_path();
  std::string searched;
  for (const fs::path& place : {home / "pictures" / kFile, home / "lib" / "firn" / kFile}) {
    searched += (searched.empty() ? "" : ", ") + place.string();
    if (!fs::exists(place, error)) continue;
    // OpenCV looks at this when it is loaded: a header that promises more is refused before memory is taken.
    setenv("OPENCV_IO_MAX_IMAGE_PIXELS", "268435456", 0);
    void* library = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library)
      throw UsageError("the plug-in that decodes pictures does not load: " + std::string(dlerror()));
    if (const auto codec = reinterpret_cast<PictureCodec>(dlsym(library, kPictureCodec))) return codec;
    throw UsageError(place.string() + " was built from other sources");
  }
  throw UsageError(
      "the plug-in that decodes pictures is not here: install libopencv-imgcodecs-dev and run ./firn "
      "droplets, "
      "which builds it (searched " +
      searched + ")");
}

// A JPEG file that was cut would decode to a picture whose last rows are grey. Its markers are followed to
// that of the end: a preview in it has one of its own. @pre it begins as a JPEG file
bool ends_as_jpeg(std::string_view bytes) {
  const auto at = [&](std::size_t i) { return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0; };
  for (std::size_t i = 2; i + 1 < bytes.size();) {
    const int marker = at(i + 1);
    const bool inside = at(i) != 0xFF || marker == 0 || marker == 0xFF || (marker >= 0xD0 && marker <= 0xD7);
    if (inside) {
      ++i;
      continue;
    }
    if (marker == 0xD9) return true;
    i += 2 + std::size_t(at(i + 2) * 256 + at(i + 3));
  }
  return false;
}

}  // namespace

DecodedPicture decode_picture(std::span<const unsigned char> bytes) {
  static const PictureCodec codec = load();
  DecodedPicture picture;
  codec(bytes, picture);
  if (const std::size_t pages = tiff_pages(bytes); pages > 1)
    picture.remarks.push_back(fmt::format("page 1 of {} is read, the others are not", pages));
  return picture;
}

DecodedPicture read_picture(const fs::path& file) {
  std::error_code error;
  if (fs::is_character_file(file, error) || fs::is_block_file(file, error))  // /dev/zero has no end
    throw UsageError(file.string() + ": is no regular file; a picture is needed");
  if (const auto size = fs::file_size(file, error); !error && size > kMaxPictureFile)
    throw UsageError(file.string() + ": " + std::to_string(size) + " bytes; a picture has at most " +
                     std::to_string(kMaxPictureFile));
  const std::string bytes = read_file(file);
  if (bytes.empty()) throw UsageError(file.string() + ": is empty; a picture is needed");
  if (bytes.starts_with("\xFF\xD8\xFF") && !ends_as_jpeg(bytes))
    throw UsageError(file.string() + ": is cut: byte " + std::to_string(bytes.size()) +
                     " is the last one, and a JPEG file ends with a marker (FF D9)");
  DecodedPicture picture =
      decode_picture({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
  if (!picture.error.empty()) throw UsageError(file.string() + ": " + picture.error);
  return picture;
}

DecodedPicture cropped(const DecodedPicture& picture, const PictureCrop& crop, const fs::path& file) {
  if (crop.x < 0 || crop.y < 0 || crop.width < 1 || crop.height < 1 || crop.width > picture.width - crop.x ||
      crop.height > picture.height - crop.y)
    throw UsageError(fmt::format(
        "{}: --crop {},{},{},{} leaves the picture of {} x {} pixels: x + width is at most {}, y + height {}",
        file.string(), crop.x, crop.y, crop.width, crop.height, picture.width, picture.height, picture.width,
        picture.height));
  DecodedPicture part{crop.width, crop.height, picture.white, {}, {}, picture.remarks};
  part.pixels.reserve(std::size_t(crop.width) * std::size_t(crop.height));
  for (int y = crop.y; y < crop.y + crop.height; ++y) {
    const auto row = picture.pixels.begin() + std::ptrdiff_t(y) * picture.width + crop.x;
    part.pixels.insert(part.pixels.end(), row, row + crop.width);
  }
  if (part.white > kWhiteOf8Bits) part.white = deep_white_level(*std::ranges::max_element(part.pixels));
  return part;
}

}  // namespace firn
