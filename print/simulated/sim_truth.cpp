#include "print/simulated/sim_truth.h"

#include <cmath>
#include <cstdlib>

namespace firn {

std::optional<sim_truth_t> parse_truth_line(const std::string& line) {
  if (!line.starts_with("TRUTH ")) return std::nullopt;
  const char* at = line.c_str() + 6;
  bool sound = true;
  const auto number = [&] {
    char* end = nullptr;
    const double v = std::strtod(at, &end);  // also reads C hexadecimal floats
    sound = sound && end != at && std::isfinite(v);
    at = end;
    return v;
  };
  sim_truth_t t{};
  t.layer = std::int32_t(number());
  t.droplets_fired = std::int64_t(number());
  t.volume_mm3 = number();
  t.grid.nx = std::int32_t(number());
  t.grid.ny = std::int32_t(number());
  t.grid.pitch_x_mm = number();
  t.grid.pitch_y_mm = number();
  t.grid.origin_x_mm = number();
  t.grid.origin_y_mm = number();
  constexpr std::int32_t kMaxCells = 4'000'000;
  if (!sound || t.grid.nx < 1 || t.grid.ny < 1 || t.grid.nx > kMaxCells / t.grid.ny) return std::nullopt;
  t.n = t.grid.nx * t.grid.ny;
  t.height_mm.reserve(std::size_t(t.n));
  for (std::int32_t n = 0; n < t.n && sound; ++n) t.height_mm.push_back(float(number()));
  if (!sound) return std::nullopt;
  return t;
}

}  // namespace firn
