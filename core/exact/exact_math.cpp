#include "core/exact/exact_math.h"

#include <sleef.h>

namespace firn::exact {

double sin(double x) { return Sleef_cinz_sind1_u10purec(x); }
double cos(double x) { return Sleef_cinz_cosd1_u10purec(x); }
double tan(double x) { return Sleef_cinz_tand1_u10purec(x); }
double atan2(double y, double x) { return Sleef_cinz_atan2d1_u10purec(y, x); }
double cbrt(double x) { return Sleef_cinz_cbrtd1_u10purec(x); }

SinCos sincos(double x) {
  const Sleef_double_2 both = Sleef_cinz_sincosd1_u10purec(x);
  return {both.x, both.y};
}

}  // namespace firn::exact
