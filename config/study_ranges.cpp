#include "config/study_ranges.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/grid/random.h"
#include "core/statistics/space_filling.h"

namespace firn {
namespace {

constexpr double kFarthest = 3.0;  // of a normal draw, in standard deviations

std::string assigned(const KeyRange& r, double value) {
  if (r.whole) return fmt::format("{}={}", r.key, std::int64_t(value));
  std::string text = fmt::format("{:.6g}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return r.key + "=" + text;
}

// A key's draws are its own, whatever other keys the study draws.
std::uint32_t stream_of(const std::string& key) {
  std::uint32_t hash = 2166136261u;  // FNV-1a
  for (const unsigned char c : key) hash = (hash ^ c) * 16777619u;
  return hash;
}

}  // namespace

std::string KeyRange::at(double u) const {
  if (whole) return assigned(*this, low + std::floor(u * (high - low + 1.0)));
  if (law == Law::kLogUniform) return assigned(*this, low * std::exp(u * std::log(high / low)));
  return assigned(*this, low + u * (high - low));
}

std::string KeyRange::drawn(std::uint64_t seed) const {
  const DrawKey key{seed, Purpose::kInstance, stream_of(this->key), 2, 0};
  if (law != Law::kNormal) return at(random_uniform(key));
  return assigned(*this, low + high * std::clamp(random_normal(key), -kFarthest, kFarthest));
}

std::string KeyRange::lowest() const {
  return assigned(*this, law == Law::kNormal ? low - kFarthest * high : low);
}

std::string KeyRange::highest() const {
  return assigned(*this, law == Law::kNormal ? low + kFarthest * high : high);
}

std::string KeyRange::words() const {
  switch (law) {
    case Law::kUniform:
      return fmt::format("{:g} to {:g}{}", low, high, whole ? ", integers" : "");
    case Law::kLogUniform:
      return fmt::format("{:g} to {:g}, even in the logarithm", low, high);
    case Law::kNormal:
      break;
  }
  return fmt::format("normal, {:g} +- {:g}", low, high);
}

std::vector<std::vector<std::string>> SampleDesign::settings() const {
  const int axes = int(ranges.size());
  const statistics::Design design = kind == Kind::kLatin ? statistics::latin_hypercube(points, axes, seed)
                                                         : statistics::sobol(points, axes, seed);
  std::vector<std::vector<std::string>> all(static_cast<std::size_t>(points));
  for (int n = 0; n < points; ++n)
    for (int axis = 0; axis < axes; ++axis)
      all[std::size_t(n)].push_back(ranges[std::size_t(axis)].at(design.at(n, axis)));
  return all;
}

}  // namespace firn
