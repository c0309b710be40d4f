#include "files/picture/read_picture.h"

#include <dlfcn.h>

#include <cstdlib>
#include <system_error>

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

}  // namespace

DecodedPicture read_picture(const fs::path& file) {
  std::error_code error;
  if (const auto size = fs::file_size(file, error); !error && size > kMaxPictureFile)
    throw UsageError(file.string() + ": " + std::to_string(size) + " bytes; a picture has at most " +
                     std::to_string(kMaxPictureFile));
  const std::string bytes = read_file(file);
  if (bytes.empty()) throw UsageError(file.string() + ": is empty; a picture is needed");
  static const PictureCodec codec = load();
  DecodedPicture picture;
  codec({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}, picture);
  if (!picture.error.empty()) throw UsageError(file.string() + ": " + picture.error);
  return picture;
}

}  // namespace firn
