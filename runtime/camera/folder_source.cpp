#include "runtime/camera/folder_source.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <system_error>
#include <thread>

#include "core/grid/png.h"

namespace firn::camera {
namespace {

using namespace std::chrono_literals;

constexpr int kLooks = 50;
constexpr auto kPause = 20ms;
constexpr int kMin_px = 16, kMax_px = 16384;

}  // namespace

FolderSource::FolderSource(std::filesystem::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder_, error)) throw std::runtime_error("is no folder");
}

std::string FolderSource::next() const {
  std::string first;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder_, error), end; !error && at != end;
       at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (at->path().extension() == ".png" && name > last_ && (first.empty() || name < first)) first = name;
  }
  if (error) throw SourceGone(error.message());
  return first;
}

GreyShot FolderSource::take(const std::function<bool()>& ended) {
  std::string name = next();
  for (int n = 0; name.empty() && n < kLooks && !(ended && ended()); ++n) {
    std::this_thread::sleep_for(kPause);
    name = next();
  }
  if (name.empty())
    throw std::runtime_error(last_.empty() ? "there is no picture *.png in the folder"
                                           : "there is no picture behind " + last_);
  last_ = name;
  std::ifstream file(folder_ / name, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  try {
    const GreyPicture grey = read_grey_png(std::as_bytes(std::span(bytes)));
    if (std::min(grey.width, grey.height) < kMin_px || std::max(grey.width, grey.height) > kMax_px)
      throw std::runtime_error("has a side outside [16, 16384] px");
    GreyShot shot{grey.width, grey.height, int(grey.white), 0,
                  std::vector<std::uint16_t>(grey.pixels.size())};
    std::ranges::transform(grey.pixels, shot.pixels.begin(), [](double v) { return std::uint16_t(v); });
    return shot;
  } catch (const std::exception& problem) {
    throw std::runtime_error(name + ": " + problem.what());
  }
}

}  // namespace firn::camera
