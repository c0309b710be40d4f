// Writes rendered strobe pictures of one jet, a droplet that hangs at its nozzle and one that flies with two
// satellites, for docs/images (scripts/pictures.sh).
//   strobe_pictures FOLDER     joined.png, free.png of 1 um a pixel
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/grid/png.h"
#include "files/text_file.h"
#include "plant/inkjet/strobe_picture.h"
#include "tests/bench/bench.h"

using namespace firn;
using namespace firn::plant;

FIRN_BENCH(strobe_pictures) {
  if (argc != 2) {
    std::fputs("usage: strobe_pictures FOLDER\n", stderr);
    return 2;
  }
  StrobeCamera camera;
  camera.width = 400;
  camera.height = 480;
  camera.um_per_px = 1.0;
  camera.light = 0.72;
  camera.vignette = 0.15;
  camera.nozzle_x_px = 200.0;
  camera.dirt = {{330.0, 160.0, 4.0, 0.25}, {90.0, 420.0, 6.0, 0.4}};
  StrobeJet jet;
  jet.speed_m_s = 2.5;
  jet.diameter_um = 64.0;
  jet.break_off_us = 85.0;
  jet.satellites = {{22.0, 0.92, 0.55}, {14.0, 0.9, 0.4}};
  for (const auto& [name, delay_us] : {std::pair{"joined.png", 80.0}, std::pair{"free.png", 130.0}}) {
    const StrobePicture p = render_strobe(camera, &jet, delay_us, 1, 0);
    const std::vector<std::byte> png = write_grey_png(p.width, p.height, p.white, p.pixels);
    write_file_atomically(std::filesystem::path(argv[1]) / name,
                          {reinterpret_cast<const char*>(png.data()), png.size()});
  }
  return 0;
}
