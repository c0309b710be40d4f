#include "print/device/profile_files.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/grid/png.h"
#include "files/text_file.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr int kRowsOfOne = 64;
constexpr double kDarkest = 32.0;  // of a valid sample

}  // namespace

std::string profiles_csv(std::span<const height_profile_t> profiles) {
  std::string text = "row,x_mm,y_mm,z_mm\n";
  for (const height_profile_t& p : profiles)
    for (std::size_t n = 0; n < p.z_mm.size(); ++n) {
      text += fmt::format("{},{:.5f},{:.5f},", p.row, p.x0_mm + double(n) * p.dx_mm, p.y_mm);
      if (!std::isnan(p.z_mm[n])) text += fmt::format("{:.5f}", p.z_mm[n]);
      text += '\n';
    }
  return text;
}

std::string profiles_png(std::span<const height_profile_t> profiles) {
  std::size_t width = 1;
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const height_profile_t& p : profiles) {
    width = std::max(width, p.z_mm.size());
    for (const float z : p.z_mm)
      if (!std::isnan(z)) {
        low = std::min(low, z);
        high = std::max(high, z);
      }
  }
  const std::size_t repeats = profiles.size() <= 1 ? kRowsOfOne : 1;
  const std::size_t height = std::max<std::size_t>(1, profiles.size()) * repeats;
  std::vector<std::uint8_t> grey(width * height * 3, 0);
  for (std::size_t row = 0; row < profiles.size() * repeats; ++row) {
    const auto& z = profiles[row / repeats].z_mm;
    for (std::size_t n = 0; n < z.size(); ++n) {
      if (std::isnan(z[n])) continue;
      const double share = high > low ? double(z[n] - low) / double(high - low) : 1.0;
      std::fill_n(grey.begin() + std::ptrdiff_t((row * width + n) * 3), 3,
                  std::uint8_t(std::lround(kDarkest + share * (255.0 - kDarkest))));
    }
  }
  const auto png = write_png(int(width), int(height), 3, grey);
  return {reinterpret_cast<const char*>(png.data()), png.size()};
}

void write_profiles(const std::string& file, std::span<const height_profile_t> profiles) {
  if (file.ends_with(".csv")) return write_file_atomically(file, profiles_csv(profiles));
  if (file.ends_with(".png")) return write_file_atomically(file, profiles_png(profiles));
  throw UsageError("--out " + file + ": must end in .csv or .png");
}

void write_frames(const std::string& file, std::span<const camera_frame_t> frames) {
  constexpr std::string_view kEnding = ".png";
  if (!file.ends_with(kEnding)) throw UsageError("--out " + file + ": must end in .png");
  const std::string stem = file.substr(0, file.size() - kEnding.size());
  for (std::size_t n = 0; n < frames.size(); ++n)
    write_file_atomically(frames.size() == 1 ? file : fmt::format("{}-{}.png", stem, n + 1),
                          {reinterpret_cast<const char*>(frames[n].png.data()), frames[n].png.size()});
}

}  // namespace firn
