// Pictures of the camera as files.
#include <catch2/catch.hpp>

#include "core/grid/png.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/device/profile_files.h"
#include "tests/support/temp_folder.h"

namespace firn {

TEST_CASE("Pictures are written as numbered PNG files, a single one under its own name") {
  const test::TempFolder folder;
  std::vector<camera_frame_t> frames(2);
  for (std::size_t n = 0; n < 2; ++n) {
    const std::vector<std::uint16_t> grey(16 * 16, std::uint16_t(10 * (n + 1)));
    const auto png = write_grey_png(16, 16, 255, grey);
    const auto* first = reinterpret_cast<const std::uint8_t*>(png.data());
    frames[n].png.assign(first, first + png.size());
  }
  const std::string out = (folder.path() / "jet.png").string();
  write_frames(out, frames);
  write_frames(out, std::span(frames).first(1));
  const auto grey_of = [&](const char* name) {
    const std::string bytes = read_file(folder.path() / name);
    return read_grey_png(std::as_bytes(std::span(bytes))).pixels.at(0);
  };
  CHECK(grey_of("jet-1.png") == 10.0);
  CHECK(grey_of("jet-2.png") == 20.0);
  CHECK(grey_of("jet.png") == 10.0);
  CHECK_THROWS_AS(write_frames("jet.csv", frames), UsageError);
}

}  // namespace firn
