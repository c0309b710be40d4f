#include "report/draw/raster.h"

#include <cstdio>

#include "core/grid/png.h"
#include "files/base64.h"

namespace firn::report {
std::vector<std::byte> png_of(const Raster& raster) {
  static_assert(sizeof(Rgba) == 4);
  return write_png(raster.width, raster.height, 4, {raster.pixels.data()->data(), 4 * raster.pixels.size()});
}

std::string svg_image(const Raster& raster, double x, double y, double width, double height) {
  char head[200];
  std::snprintf(head, sizeof head,
                "<image x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" preserveAspectRatio=\"none\" "
                "class=\"cells\" href=\"data:image/png;base64,",
                x, y, width, height);
  return head + base64(png_of(raster)) + "\"/>\n";
}

}  // namespace firn::report
