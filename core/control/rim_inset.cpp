#include "core/control/rim_inset.h"

namespace firn::control {

OffsetMap inset_places(const Setup& s, double inset) {
  if (inset == 0.0 || s.offsets.table.size() == 1) return {};
  OffsetMap map(s.grid);
  bool any = false;
  const auto outside = [&s](int i, int j) { return int(!s.grid.contains(i, j) || !s.mask.at(i, j)); };
  for (int j = 0; j < s.grid.ny; ++j)
    for (int i = 0; i < s.grid.nx; ++i) {
      if (!s.mask.at(i, j)) continue;
      const Offset inwards{inset * double(outside(i - 1, j) - outside(i + 1, j)),
                           inset * double(outside(i, j - 1) - outside(i, j + 1))};
      const int place = s.offsets.table.nearest(inwards);
      map.at(i, j) = std::uint8_t(place);
      any = any || place != 0;
    }
  return any ? map : OffsetMap{};
}

}  // namespace firn::control
