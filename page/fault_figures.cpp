#include "page/fault_figures.h"

#include <charconv>
#include <cmath>

namespace firn::page {
namespace {

enum class Kind {
  kValue,       ///< the first number
  kRatio,       ///< the first over the second
  kDifference,  ///< between both
  kVector,      ///< length of "(x, y)"; the limit follows
  kBoth,        ///< value, then limit
};

struct Row {
  int code;
  std::string_view has;            ///< words that tell this fault from others of the interlock
  std::string_view first, second;  ///< words before the numbers
  std::string_view unit;
  Kind kind;
  std::string_view limit = {};  ///< key of the setting
};

// The words are those of procs/scheduler and drivers.
constexpr Row kWords[] = {
    {6, "the nozzle is at", "reaches ", "the nozzle is at ", "mm", Kind::kDifference,
     "process.nozzle_clearance_mm"},
    {6, "into the clearance", "reaches ", "clearance of ", "mm", Kind::kDifference, "ice.clearance_mm"},
    {7, "instead of", "took ", "instead of ", "s", Kind::kDifference, "ice.max_time_slip_s"},
    {7, "planned", "took ", "planned ", "ms", Kind::kDifference},
    {10, "tip is at", "tip is at ", "heater.low_degC = ", "degC", Kind::kBoth},
    {11, "velocity is", "velocity is ", " = ", "m/s", Kind::kBoth},
    {11, "angle is", "angle is ", " = ", "deg", Kind::kBoth},
    {11, "satellites is", "satellites is ", " = ", "", Kind::kBoth},
    {11, "voltage", "voltage ", "beyond +-", "V", Kind::kBoth},
    {11, "time", "time ", "outside [0, ", "us", Kind::kBoth},
    {12, "drops without rise", "rose by ", "on average, ", "", Kind::kRatio, "process.least_rise_share"},
    {12, "rise without drops", "rose by ", "on average, ", "", Kind::kRatio, "process.most_rise_share"},
    {12, "a nozzle leaks", "rose by ", "", "um", Kind::kValue},
    {12, "rise without command", "rose by ", "", "mm", Kind::kValue},
    {12, "stays closed", " hold ", "", "", Kind::kValue, "process.least_rise_share"},
    {12, "the flow is wrong", " hold ", "", "", Kind::kValue, "process.most_rise_share"},
    {12, "lies away from them", "was planned, ", "", "", Kind::kValue},
    {13, "is needed", "measures ", "of the grid; ", "", Kind::kBoth},
    {13, "is needed", "measures ", "of the grid, ", "", Kind::kBoth},
    {13, "is needed", "has measured ", "of it; ", "", Kind::kBoth},
    {13, "lacks", " lacks ", " of ", "", Kind::kRatio, "process.max_lost_rows_share"},
    {16, "it clogs", "sheath: ", " = ", "kPa", Kind::kBoth, "gas.most_pressure_kpa"},
    {16, "sccm flow", "sheath: ", " of ", "", Kind::kRatio, "gas.lost_share"},
    {16, "sccm flow", "atomizer: ", " of ", "", Kind::kRatio, "gas.lost_share"},
    {15, "on average", "measures ", "0 within ", "mm", Kind::kBoth},
    {15, "aside of its outline, at most", " lies (", "at most ", "mm", Kind::kVector},
    {15, "its edges differ", "differ by (", "at most ", "mm", Kind::kVector},
};

/// Returns the number behind `before`; `words` goes on behind it.
std::optional<double> number_after(std::string_view before, std::string_view& words) {
  const std::size_t at = words.find(before);
  if (at == words.npos) return std::nullopt;
  const char* from = words.data() + at + before.size();
  const char* until = words.data() + words.size();
  double value = 0.0;
  const auto [end, error] = std::from_chars(from, until, value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  words = {end, std::size_t(until - end)};
  return value;
}

std::optional<FaultFigures> read(const Row& row, std::string_view words) {
  if (words.find(row.has) == words.npos) return std::nullopt;
  FaultFigures f;
  f.unit = row.unit;
  const auto first = number_after(row.first, words);
  if (!first) return std::nullopt;
  f.value = *first;
  if (row.kind == Kind::kValue) return f;
  if (row.kind == Kind::kVector) {
    const auto y = number_after(", ", words);
    if (!y) return std::nullopt;
    f.value = std::hypot(*first, *y);
  }
  const auto second = number_after(row.second, words);
  if (!second) return std::nullopt;
  if (row.kind == Kind::kDifference) {
    f.value = std::abs(*second - *first);
  } else if (row.kind == Kind::kRatio) {
    if (*second == 0.0) return std::nullopt;
    f.value = *first / *second;
  } else {
    f.limit = second;
  }
  return f;
}

}  // namespace

std::optional<FaultFigures> fault_figures(int code, std::string_view words,
                                          const std::map<std::string, double>& settings) {
  for (const Row& row : kWords) {
    if (row.code != code) continue;
    std::optional<FaultFigures> f = read(row, words);
    if (!f) continue;
    if (const auto limit = settings.find(std::string(row.limit)); limit != settings.end())
      f->limit = limit->second;
    return f;
  }
  return std::nullopt;
}

}  // namespace firn::page
