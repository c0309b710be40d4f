// Computes the sections of a path over which one joint turns in one direction. ACON and JCON treat each
// apart, since a joint's rate, unlike the path speed, changes sign [Barnett 2012, 4.1.3].
#pragma once

#include <cstddef>
#include <vector>

namespace firn::motion::thesis {

struct Section {
  std::size_t first = 0;  ///< points first..last
  std::size_t last = 0;
  int sign = 1;  ///< of the rate; a joint at rest belongs to the section before it
};

inline std::vector<Section> sections(const std::vector<double>& q) {
  std::vector<Section> out;
  for (std::size_t i = 0; i + 1 < q.size(); ++i) {
    const double step = q[i + 1] - q[i];
    const int sign = step > 0.0 ? 1 : step < 0.0 ? -1 : 0;
    if (out.empty() || (sign != 0 && sign != out.back().sign))
      out.push_back({i, i + 1, sign == 0 ? 1 : sign});
    out.back().last = i + 1;
  }
  return out;
}

}  // namespace firn::motion::thesis
