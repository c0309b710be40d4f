// Droplets of picture files: discs drawn by the test, found, printed as JSON and text, and drawn in.
#include <png.h>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "files/json.h"
#include "files/usage_error.h"
#include "report/droplets/droplet_files.h"
#include "tests/report/markup.h"
#include "tests/support/temp_folder.h"

namespace firn::test {
namespace {

using Catch::Contains;
using DropletJson = nlohmann::json;

struct Disc {
  double x, y, radius;
};

// Dark discs and a dark nozzle before a bright ground as binary PNM, each pixel the mean of 8 x 8 samples.
struct StrobeSketch {
  int width = 200, height = 160;
  std::vector<Disc> discs = {};
  bool nozzle = false;    // from the top edge to y = 20.5, 60 px wide about x = 100
  double ligament = 0.0;  // half its width, from the nozzle down to the first disc
  int deep_level = 0;     // of the ground, in 16 bits; 0: 8 bits

  bool dark(double x, double y) const {
    if (nozzle && std::abs(x - 100.0) < 30.0 && y < 20.5) return true;
    if (ligament > 0.0 && std::abs(x - 100.0) < ligament && y < discs.at(0).y) return true;
    for (const Disc& d : discs)
      if (std::hypot(x - d.x, y - d.y) < d.radius) return true;
    return false;
  }
  std::string pnm() const {
    std::string out = "P5\n" + std::to_string(width) + " " + std::to_string(height) +
                      (deep_level ? "\n65535\n" : "\n255\n");
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        int inside = 0;
        for (int n = 0; n < 64; ++n) inside += dark(x + (n % 8 - 3.5) / 8.0, y + (double(n / 8) - 3.5) / 8.0);
        const int ground = deep_level ? deep_level : 180, level = ground - ground * 5 / 6 * inside / 64;
        if (deep_level) out.push_back(char(level / 256));
        out.push_back(char(level % 256));
      }
    return out;
  }
};

report::DropletAnalysis analysed(const std::filesystem::path& file, double um_per_px = 0.0) {
  report::DropletRequest r;
  r.images = {file};
  r.um_per_px = um_per_px;
  return report::analyse_droplets(r);
}

std::string refusal(const report::DropletRequest& request) {
  try {
    report::analyse_droplets(request);
  } catch (const UsageError& e) {
    return e.what();
  }
  return "accepted";
}

TEST_CASE("A disc's place, diameter and volume are printed in pixels, micrometres and picolitres") {
  const TempFolder folder;
  for (const auto& [x, y, radius] : {Disc{100, 80, 12}, {60.25, 90.5, 9.5}, {140.5, 70.75, 20}}) {
    CAPTURE(x, y, radius);
    const auto file = folder.file("disc.pgm", StrobeSketch{.discs = {{x, y, radius}}}.pnm());
    const DropletJson j = DropletJson::parse(report::droplets_json(analysed(file, 2.5)));
    CHECK(j["scale_um_per_px"] == 2.5);
    CHECK(j["scale_std_um_per_px"] == 0.0);
    const DropletJson& p = j["pictures"].at(0);
    CHECK(p["file"] == file.string());
    CHECK(p["width_px"] == 200);
    CHECK(p["height_px"] == 160);
    CHECK(p["state"] == "drop");
    CHECK(p["broken_off"] == true);
    CHECK(p["nozzle"].is_null());
    const DropletJson& d = p["main"];
    CHECK(d["x_px"].get<double>() == Approx(x).margin(0.1));
    CHECK(d["y_px"].get<double>() == Approx(y).margin(0.1));
    CHECK(d["diameter_px"].get<double>() == Approx(2 * radius).epsilon(0.015));
    CHECK(d["diameter_um"].get<double>() == Approx(5 * radius).epsilon(0.015));
    CHECK(d["diameter_std_um"].get<double>() == Approx(2.5 * d["diameter_std_px"].get<double>()));
    const double radius_um = 2.5 * radius;
    CHECK(d["volume_pl"].get<double>() ==
          Approx(4e-3 / 3.0 * std::numbers::pi * radius_um * radius_um * radius_um).epsilon(0.05));
    CHECK(d["volume_std_pl"].get<double>() / d["volume_pl"].get<double>() ==
          Approx(3 * d["diameter_std_um"].get<double>() / d["diameter_um"].get<double>()));
  }
}

TEST_CASE("Without a scale nothing is said in micrometres, without a delay nothing of a sweep") {
  const TempFolder folder;
  const auto a = analysed(folder.file("disc.pgm", StrobeSketch{.discs = {{100, 80, 12}}}.pnm()));
  const DropletJson j = DropletJson::parse(report::droplets_json(a));
  CHECK(j["scale_um_per_px"].is_null());
  CHECK(j["sweep"].is_null());
  CHECK_FALSE(j["pictures"][0].contains("delay_us"));
  CHECK_FALSE(j["pictures"][0]["main"].contains("diameter_um"));
  CHECK_FALSE(j["pictures"][0]["main"].contains("volume_pl"));
  CHECK_THAT(report::droplets_text(a), !Contains(" um") && !Contains(" pl") && Contains("diameter"));
}

TEST_CASE("An empty picture, a hanging droplet and satellites are said in words") {
  const TempFolder folder;
  const auto none = analysed(folder.file("none.pgm", StrobeSketch{}.pnm()));
  CHECK(report::droplets_text(none) == (folder.path() / "none.pgm").string() + ": no drop\n");
  const DropletJson j = DropletJson::parse(report::droplets_json(none))["pictures"][0];
  CHECK(j["broken_off"].is_null());
  CHECK(j["main"].is_null());
  CHECK(j["satellites"].empty());

  const StrobeSketch hanging{.discs = {{100, 80, 14}}, .nozzle = true, .ligament = 3.0};
  const auto joined = analysed(folder.file("hanging.pgm", hanging.pnm()));
  CHECK_THAT(report::droplets_text(joined),
             Contains("hanging.pgm: not broken off at 1") && Contains("ligament"));
  const DropletJson k = DropletJson::parse(report::droplets_json(joined))["pictures"][0];
  CHECK(k["broken_off"] == false);
  CHECK(k["main"]["joined"] == true);
  CHECK(k["main"]["y_px"].get<double>() == Approx(80).margin(1.0));
  CHECK(k["nozzle"]["y_px"].get<double>() == Approx(20).margin(1.0));

  const StrobeSketch several{.discs = {{100, 120, 14}, {100, 85, 4}, {103, 60, 5}}, .nozzle = true};
  const auto free = analysed(folder.file("free.pgm", several.pnm()));
  CHECK_THAT(report::droplets_text(free), Contains("free.pgm: drop at 1") && Contains(", 2 satellites\n"));
  const DropletJson f = DropletJson::parse(report::droplets_json(free))["pictures"][0];
  REQUIRE(f["satellites"].size() == 2);
  CHECK(f["satellites"][0]["y_px"].get<double>() == Approx(60).margin(0.3));  // the larger one first
  CHECK(f["satellites"][1]["y_px"].get<double>() == Approx(85).margin(0.3));
  CHECK(f["satellites"][1]["diameter_px"].get<double>() == Approx(8).epsilon(0.1));
}

TEST_CASE("A nozzle of known width and a target of known pitch give the scale") {
  const TempFolder folder;
  report::DropletRequest r;
  r.images = {folder.file("free.pgm", StrobeSketch{.discs = {{100, 100, 14}}, .nozzle = true}.pnm())};
  r.nozzle_um = 180.0;
  CHECK(report::analyse_droplets(r).scale.um_per_px == Approx(3.0).epsilon(0.02));
  r.nozzle_um = 0.0;
  StrobeSketch target;
  for (int n = 0; n < 20; ++n) target.discs.push_back({40.0 + 30.0 * (n % 5), 35.0 + 30.0 * (n / 5), 7.0});
  r.target = folder.file("target.pgm", target.pnm());
  r.pitch_um = 75.0;
  const report::DropletAnalysis a = report::analyse_droplets(r);
  CHECK(a.scale.um_per_px == Approx(2.5).epsilon(0.01));
  CHECK_THAT(report::droplets_text(a), Contains("um/px") && Contains(" pl"));
}

TEST_CASE("A droplet's velocity is its way over the delays, in m/s with a scale and in px/us without") {
  const TempFolder folder;
  report::DropletRequest r;
  for (int n = 0; n < 6; ++n) {  // 1.5 px per us, of 2 um each
    const StrobeSketch sketch{.discs = {{100, 50 + 15.0 * n, 10}}, .nozzle = true};
    r.images.push_back(folder.file(std::to_string(n) + ".pgm", sketch.pnm()));
    r.delays_us.push_back(40.0 + 10.0 * n);
  }
  const DropletJson px = DropletJson::parse(report::droplets_json(report::analyse_droplets(r)));
  CHECK(px["sweep"]["velocity_px_us"].get<double>() == Approx(1.5).epsilon(0.01));
  CHECK_FALSE(px["sweep"].contains("volume_pl"));
  r.um_per_px = 2.0;
  const report::DropletAnalysis scaled = report::analyse_droplets(r);
  const DropletJson um = DropletJson::parse(report::droplets_json(scaled));
  CHECK(um["sweep"]["velocity_m_s"].get<double>() == Approx(3.0).epsilon(0.01));
  CHECK(um["sweep"]["angle_deg"].get<double>() == Approx(0.0).margin(0.5));
  CHECK(um["pictures"][5]["delay_us"] == 90.0);
  CHECK_THAT(report::droplets_text(scaled), Contains("0.pgm (40 us): drop") && Contains(" m/s\n"));
}

TEST_CASE(
    "Pictures of one 12-bit camera share a scene, whether or not their levels exceed those of 10 bits") {
  const TempFolder folder;
  report::DropletRequest r;
  const auto draw = [&](int n, double y, int level) {
    const StrobeSketch sketch{.discs = {{100, y, 14}, {40, 100, 12}}, .nozzle = true, .deep_level = level};
    return folder.file(std::to_string(n) + ".pgm", sketch.pnm());
  };
  for (int n = 0; n < 8; ++n) {
    r.images.push_back(draw(n, 45 + 12.0 * n, n % 2 ? 1040 : 1000));
    r.delays_us.push_back(10.0 * n);
  }
  for (const report::AnalysedPicture& p : report::analyse_droplets(r).pictures) {
    CAPTURE(p.file);
    CHECK(p.result.used_background);
    CHECK(p.result.drops.empty());  // the disc that does not move belongs to the scene
  }
  r.delays_us.clear();
  r.images = {draw(8, 80, 1000)};
  r.background = folder.file("bare.pgm", StrobeSketch{.nozzle = true, .deep_level = 1040}.pnm());
  CHECK(refusal(r) == "accepted");
  r.images = {folder.file("eight.pgm", StrobeSketch{.discs = {{100, 80, 12}}}.pnm())};
  CHECK_THAT(refusal(r), Contains("differs in size or depth"));
}

TEST_CASE("The overlay circles the droplet in green where it is and leaves the rest of the picture grey") {
  const TempFolder folder;
  const StrobeSketch sketch{.discs = {{120, 100, 16}, {70, 60, 5}}};
  const report::DropletAnalysis a = analysed(folder.file("two.pgm", sketch.pnm()));
  const std::vector<std::byte> png = report::droplet_overlay(a.pictures.at(0));
  const ReadPicture seen =
      picture_of(std::string_view(reinterpret_cast<const char*>(png.data()), png.size()));
  REQUIRE(seen.width == sketch.width);
  REQUIRE(seen.height == sketch.height);
  int green = 0, orange = 0;
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x) {
      const auto c = seen.at(x, y);
      const double of_main = std::hypot(x - 120.0, y - 100.0), of_satellite = std::hypot(x - 70.0, y - 60.0);
      const bool grey = c[0] == c[1] && c[1] == c[2];
      if (of_main > 19 && of_satellite > 10) CHECK(grey);
      green += c[1] > 180 && c[0] < 100 && std::abs(of_main - 16.0) < 1.5;
      orange += c[0] > 200 && c[2] < 100 && of_satellite < 9;
    }
  CHECK(green > 80);  // a circle of 16 px has 100 px
  CHECK(orange > 30);
  for (const auto& [x, y] : {std::pair{104, 100}, {136, 100}, {120, 84}, {120, 116}, {120, 100}})
    CHECK(seen.at(x, y)[1] > seen.at(x, y)[0] + 60);
  CHECK(int(seen.at(0, 0)[0]) == 180);
}

TEST_CASE("A picture is known by its bytes, not by its suffix") {
  const TempFolder folder;
  const std::string pnm = StrobeSketch{.discs = {{100, 80, 12}}}.pnm();
  for (const char* name : {"a.png", "a.txt", "a", "Düse <1>.jpg"}) {
    CAPTURE(name);
    const DropletJson j = DropletJson::parse(report::droplets_json(analysed(folder.file(name, pnm))));
    CHECK(j["pictures"][0]["main"]["x_px"].get<double>() == Approx(100).margin(0.1));
    CHECK(j["pictures"][0]["file"].get<std::string>().ends_with(name));
  }
}

TEST_CASE("A picture that is drawn in its opacity alone lies on white, and a warning says so") {
  const TempFolder folder;
  const std::string grey = StrobeSketch{.discs = {{100, 80, 20}}}.pnm();
  const auto* levels = reinterpret_cast<const unsigned char*>(grey.data()) + grey.size() - 200 * 160;
  std::vector<unsigned char> black(std::size_t(4) * 200 * 160, 0);
  for (std::size_t n = 0; n < 200 * 160; ++n) black[4 * n + 3] = static_cast<unsigned char>(255 - levels[n]);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = 200;
  image.height = 160;
  image.format = PNG_FORMAT_RGBA;
  png_alloc_size_t bytes = 0;
  REQUIRE(png_image_write_to_memory(&image, nullptr, &bytes, 0, black.data(), 0, nullptr));
  std::string png(bytes, '\0');
  REQUIRE(png_image_write_to_memory(&image, png.data(), &bytes, 0, black.data(), 0, nullptr));
  const report::DropletAnalysis a = analysed(folder.file("alpha.png", png.substr(0, bytes)));
  CHECK(a.pictures.at(0).result.main.diameter_px == Approx(40.0).margin(0.2));
  CHECK_THAT(report::droplets_warnings(a), Contains("alpha.png: its transparent pixels are taken as white"));
}

TEST_CASE(
    "Of a TIFF with several pages the first one is measured, and a warning says so, in either byte order") {
  const TempFolder folder;
  const std::string pnm = StrobeSketch{.discs = {{100, 80, 20}}}.pnm();
  const std::string pixels = pnm.substr(pnm.size() - 200 * 160);
  for (const bool big : {false, true})
    for (const int pages : {1, 2, 5}) {
      CAPTURE(big, pages);
      std::string tiff;
      const auto put = [&](std::uint32_t value, int size) {
        for (int n = 0; n < size; ++n) tiff.push_back(char(value >> 8 * (big ? size - 1 - n : n) & 0xFF));
      };
      tiff = big ? "MM" : "II";
      put(42, 2);
      put(8 + 200 * 160, 4);
      tiff += pixels;
      for (int page = 0; page < pages; ++page) {
        const std::pair<int, std::uint32_t> entries[] = {{256, 200}, {257, 160}, {258, 8},
                                                         {259, 1},   {262, 1},   {273, 8},
                                                         {277, 1},   {278, 160}, {279, 200 * 160}};
        put(std::uint32_t(std::size(entries)), 2);
        for (const auto& [tag, value] : entries) {
          put(std::uint32_t(tag), 2);
          put(4, 2);  // 32 bits
          put(1, 4);
          put(value, 4);
        }
        put(page + 1 < pages ? std::uint32_t(tiff.size() + 4) : 0, 4);
      }
      const report::DropletAnalysis a = analysed(folder.file("pages.tif", tiff));
      CHECK(a.pictures.at(0).result.main.diameter_px == Approx(40.0).margin(0.2));
      const std::string said = "page 1 of " + std::to_string(pages) + " is read";
      CHECK((report::droplets_warnings(a).find(said) != std::string::npos) == (pages > 1));
    }
}

TEST_CASE("Unreadable, empty, cut and too small pictures are refused by name") {
  const TempFolder folder;
  const std::string whole = StrobeSketch{.discs = {{100, 80, 12}}}.pnm();
  const auto of = [&](const std::string& name, const std::string& bytes) {
    report::DropletRequest r;
    r.images = {folder.file(name, bytes)};
    return refusal(r);
  };
  CHECK_THAT(of("empty.pgm", ""), Contains("empty.pgm: is empty"));
  CHECK_THAT(of("text.pgm", "no picture at all"), Contains("text.pgm: no picture"));
  CHECK_THAT(of("head.pgm", whole.substr(0, 9)), Contains("head.pgm: no"));
  CHECK_THAT(of("small.pgm", StrobeSketch{.width = 15, .height = 90}.pnm()),
             Contains("small.pgm: 15 x 90 pixels; sides must be from 16 to 16384"));
  CHECK(of("least.pgm", StrobeSketch{.width = 16, .height = 16}.pnm()) == "accepted");
  report::DropletRequest missing;
  missing.images = {folder.path() / "missing.pgm"};
  CHECK_THAT(refusal(missing), Contains("missing.pgm"));
}

TEST_CASE("Options that contradict each other or the pictures are refused by name") {
  const TempFolder folder;
  report::DropletRequest ok;
  ok.images = {folder.file("bare.pgm", StrobeSketch{.discs = {{100, 80, 12}}}.pnm())};
  CHECK(refusal(ok) == "accepted");
  const auto with = [&](const auto& change) {
    report::DropletRequest r = ok;
    change(r);
    return refusal(r);
  };
  CHECK_THAT(with([](auto& r) { r.delays_us = {1, 2}; }), Contains("--delay-us: 2 delays for 1 pictures"));
  CHECK_THAT(with([](auto& r) { r.delays_us = {std::nan("")}; }), Contains("--delay-us"));
  CHECK_THAT(with([](auto& r) { r.delays_us = {1.1e9}; }), Contains("outside -1e9 to 1e9 us"));
  CHECK_THAT(with([](auto& r) { r.pitch_um = 5; }), Contains("--target and --pitch-um"));
  CHECK_THAT(with([](auto& r) { r.um_per_px = r.nozzle_um = 5; }), Contains("one of them is needed"));
  CHECK_THAT(with([](auto& r) { r.nozzle_um = 50; }), Contains("--nozzle-um: no picture shows"));
  CHECK_THAT(with([](auto& r) {
               r.target = r.images[0];
               r.pitch_um = 5;
             }),
             Contains("fewer than 9 equal dots"));
  CHECK_THAT(with([&](auto& r) { r.background = folder.file("wide.pgm", StrobeSketch{.width = 201}.pnm()); }),
             Contains("bare.pgm: differs in size or depth from the background") && Contains("wide.pgm"));
}

}  // namespace
}  // namespace firn::test
