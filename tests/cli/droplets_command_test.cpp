// firn droplets on pictures in files.
#include <algorithm>
#include <catch2/catch.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "files/json.h"
#include "plant/inkjet/strobe_picture.h"
#include "tests/cli/run_firn.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
using Json = nlohmann::json;

namespace {

plant::StrobeCamera photo_camera() {
  plant::StrobeCamera c;
  c.width = 320;
  c.height = 280;
  c.nozzle_x_px = 150;
  c.nozzle_y_px = 40;
  c.spot = 0.8;
  return c;
}

// In colour where the format has 8 bits.
std::string save(const plant::StrobePicture& p, const std::filesystem::path& file) {
  cv::Mat grey(p.height, p.width, p.white > 255 ? CV_16U : CV_8U);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      const std::uint16_t v = p.pixels[std::size_t(y * p.width + x)];
      if (p.white > 255)
        grey.at<std::uint16_t>(y, x) = v;
      else
        grey.at<std::uint8_t>(y, x) = std::uint8_t(v);
    }
  cv::Mat picture = grey;
  if (p.white == 255) cv::merge(std::vector<cv::Mat>{grey, grey, grey}, picture);
  REQUIRE(cv::imwrite(file.string(), picture));
  return file.string();
}

/// Of `firn droplets` with these words.
void check_droplets_refused(std::vector<std::string> words, const std::string& part) {
  words.insert(words.begin(), "droplets");
  const Said said = firn_says(words);
  CAPTURE(words, said.err);
  CHECK(said.code == 2);
  CHECK_THAT(said.err, Contains(part));
}

}  // namespace

TEST_CASE("The droplet of a picture is the same in JPEG, PNG, TIFF and BMP, and said in px and um") {
  const auto folder = fresh_folder("droplet-formats");
  const plant::StrobeJet jet;
  for (const auto& [name, white] : std::vector<std::pair<std::string, int>>{{"a.png", 255},
                                                                            {"a.jpg", 255},
                                                                            {"a.bmp", 255},
                                                                            {"a.tif", 255},
                                                                            {"b.tif", 4095},
                                                                            {"b.png", 65535}}) {
    plant::StrobeCamera c = photo_camera();
    c.white = white;
    const plant::StrobePicture p = plant::render_strobe(c, &jet, 100, 7, 0);
    const Said said = firn_says({"droplets", save(p, folder / name), "--scale", "2", "--json"});
    CAPTURE(name, said.err);
    REQUIRE(said.code == 0);
    const Json j = Json::parse(said.out)["pictures"][0];
    CHECK(j["state"] == "drop");
    CHECK(j["main"]["x_px"].get<double>() == Approx(p.truth.x_px).margin(0.1));
    CHECK(j["main"]["y_px"].get<double>() == Approx(p.truth.y_px).margin(0.1));
    CHECK(j["main"]["diameter_px"].get<double>() == Approx(p.truth.diameter_px).epsilon(0.015));
    CHECK(j["main"]["diameter_um"].get<double>() == Approx(jet.diameter_um).epsilon(0.015));
    CHECK(j["main"]["volume_pl"].get<double>() == Approx(65.45).epsilon(0.05));
  }
}

TEST_CASE("Pictures at several delays give velocity, angle and break-off, the nozzle gives the scale") {
  const auto folder = fresh_folder("droplet-sweep");
  plant::StrobeJet jet;
  jet.angle_deg = 2.0;
  jet.satellites = {{14, 0.95, 0.5}};
  std::vector<std::string> words{"droplets"};
  std::string delays;
  for (int k = 0; k < 10; ++k) {
    const double delay = 30 + 12 * k;
    words.push_back(save(plant::render_strobe(photo_camera(), &jet, delay, 9, std::uint32_t(k)),
                         folder / (std::to_string(k) + ".png")));
    delays += (k ? "," : "") + std::to_string(int(delay));
  }
  words.insert(words.end(), {"--delay-us", delays, "--nozzle-um", "200"});
  const Said text = firn_says(words);
  INFO(text.err);
  REQUIRE(text.code == 0);
  CHECK_THAT(text.out, Contains("0.png (30 us): not broken off") && Contains("velocity") && Contains("m/s"));
  words.insert(words.end(), {"--json", "--picture", (folder / "seen.png").string()});
  const Json j = Json::parse(firn_says(words).out);
  CHECK(j["scale_um_per_px"].get<double>() == Approx(2).epsilon(0.005));
  const Json& s = j["sweep"];
  CHECK(s["velocity_m_s"].get<double>() ==
        Approx(plant::fly(2, 50, s["middle_us"].get<double>()).speed_m_s).epsilon(0.01));
  CHECK(s["angle_deg"].get<double>() == Approx(2.0).margin(0.15));
  CHECK(s["break_off_us"].get<double>() == Approx(60).margin(12));
  CHECK(s["satellites"].get<double>() == 1);
  CHECK(j["pictures"][9]["background"] == "pictures");
  const cv::Mat seen = cv::imread((folder / "seen-10.png").string());
  REQUIRE(seen.cols == 320);
  CHECK(seen.rows == 280);
}

TEST_CASE("Without a scale a sweep is in pixels, and an empty picture is no drop") {
  const auto folder = fresh_folder("droplet-none");
  const plant::StrobeJet jet;
  const std::string none = save(plant::render_strobe(photo_camera(), nullptr, 0, 1, 0), folder / "none.png");
  const std::string a = save(plant::render_strobe(photo_camera(), &jet, 80, 1, 1), folder / "a.png");
  const std::string b = save(plant::render_strobe(photo_camera(), &jet, 120, 1, 2), folder / "b.png");
  const Said said = firn_says({"droplets", none, a, b, "--delay-us", "10,80,120", "--json"});
  INFO(said.err);
  REQUIRE(said.code == 0);
  const Json j = Json::parse(said.out);
  CHECK(j["pictures"][0]["state"] == "no drop");
  CHECK(j["pictures"][0]["main"].is_null());
  CHECK(j["scale_um_per_px"].is_null());
  CHECK(j["sweep"]["velocity_px_us"].get<double>() == Approx(1.0).epsilon(0.03));
  CHECK_FALSE(j["sweep"].contains("volume_pl"));
  const Json with = Json::parse(firn_says({"droplets", a, "--background", none, "--json"}).out);
  CHECK(with["pictures"][0]["background"] == "pictures");
  CHECK(with["pictures"][0]["state"] == "drop");
}

TEST_CASE("A warning names the picture and the share of its pixels that are saturated") {
  const auto folder = fresh_folder("droplet-saturated");
  const plant::StrobeJet jet;
  plant::StrobeCamera bright = photo_camera();
  bright.light = 1.2;
  const std::string dark = save(plant::render_strobe(photo_camera(), &jet, 100, 7, 0), folder / "dark.png"),
                    lit = save(plant::render_strobe(bright, &jet, 100, 7, 1), folder / "lit.png");
  const Said said = firn_says({"droplets", dark, lit, "--json"});
  INFO(said.err);
  REQUIRE(said.code == 0);
  const Json j = Json::parse(said.out)["pictures"];
  CHECK(j[0]["saturated"].get<double>() < 0.001);
  CHECK(j[1]["saturated"].get<double>() > 0.8);
  CHECK_THAT(said.err,
             Contains("lit.png: ") && Contains(" % of the pixels are saturated") && !Contains("dark.png"));
}

TEST_CASE("Wrong pictures and options are refused by file, option and limit") {
  const auto folder = fresh_folder("droplet-errors");
  const std::string none = save(plant::render_strobe(photo_camera(), nullptr, 0, 1, 0), folder / "none.png");
  plant::StrobeCamera bare = photo_camera();
  bare.nozzle_um = 0;
  const std::string empty = save(plant::render_strobe(bare, nullptr, 0, 1, 0), folder / "empty.png");
  write_file_text(folder / "text.jpg", "no picture");
  write_file_text(folder / "zero.png", "");
  write_file_text(folder / "cut.png", file_text(none).substr(0, 40));
  const std::string jpeg = save(plant::render_strobe(photo_camera(), nullptr, 0, 1, 0), folder / "none.jpg");
  write_file_text(folder / "cut.jpg", file_text(jpeg).substr(0, file_text(jpeg).size() / 2));
  std::string holed = file_text(jpeg);
  holed.erase(holed.size() / 2, 200);  // a turned byte need not be seen: JPEG has no checksum
  write_file_text(folder / "holed.jpg", holed);
  cv::imwrite((folder / "small.png").string(), cv::Mat(8, 300, CV_8U, cv::Scalar(9)));
  write_file_text(folder / "dot.pgm", "P5\n1 1\n255\nx");
  write_file_text(folder / "none.pgm", "P5\n0 0\n255\n");
  write_file_text(folder / "huge.pgm", "P5\n20000 20000\n255\nx");
  check_droplets_refused({(folder / "missing.png").string()}, "missing.png");
  check_droplets_refused({folder.string()}, "droplet-errors");
  check_droplets_refused({(folder / "text.jpg").string()}, "text.jpg: no picture in a format that is known");
  check_droplets_refused({(folder / "zero.png").string()}, "zero.png: is empty");
  check_droplets_refused({(folder / "cut.png").string()}, "cut.png: no");
  check_droplets_refused({(folder / "cut.jpg").string()}, "cut.jpg: is cut: byte ");
  check_droplets_refused({(folder / "holed.jpg").string()}, "holed.jpg: damaged: Corrupt JPEG data");
  check_droplets_refused({(folder / "small.png").string()}, "300 x 8 pixels; sides must be from 16 to 16384");
  check_droplets_refused({(folder / "dot.pgm").string()},
                         "dot.pgm: 1 x 1 pixels; sides must be from 16 to 16384");
  check_droplets_refused({(folder / "none.pgm").string()}, "none.pgm: ");
  check_droplets_refused({(folder / "huge.pgm").string()}, "huge.pgm: ");
  check_droplets_refused({none, none, "--delay-us", "3"}, "1 delays for 2 pictures");
  check_droplets_refused({none, "--delay-us", "inf"}, "--delay-us");
  check_droplets_refused({empty, "--nozzle-um", "50"}, "--nozzle-um: no picture shows");
  check_droplets_refused({none, "--nozzle-um", "50", "--scale", "2"}, "one of them");
  check_droplets_refused({none, "--target", none}, "--pitch-um");
  check_droplets_refused({none, "--target", none, "--pitch-um", "50"}, "none.png: fewer than 9 equal dots");
  check_droplets_refused({none, "--scale", "-1"}, "--scale");
  check_droplets_refused({none, "--scale", "1e300"}, "--scale: Value 1e300 not in range 0.001 to 10000");
  check_droplets_refused({none, "--scale", "1e-300"}, "--scale: Value 1e-300 not in range 0.001 to 10000");
  check_droplets_refused({none, "--scale", "nan"}, "--scale: nan");
  check_droplets_refused({none, "--nozzle-um", "1e300"},
                         "--nozzle-um: Value 1e300 not in range 0.1 to 100000");
  check_droplets_refused({none, "--target", none, "--pitch-um", "1e300"},
                         "--pitch-um: Value 1e300 not in range 0.1 to 100000");
  check_droplets_refused({none, none, "--delay-us", "60,,70"}, "--delay-us: \"60,,70\" has an empty item");
  check_droplets_refused({none, none, "--delay-us", "60,1e10"},
                         "--delay-us: Value 1e10 not in range -1e+09 to 1e+09");
  check_droplets_refused({none, "--objects", "pale"}, "--objects");
}

TEST_CASE("The picture of the findings takes the place of no picture that was read") {
  const auto folder = fresh_folder("droplet-outputs");
  const plant::StrobeJet jet;
  const std::string a = save(plant::render_strobe(photo_camera(), &jet, 100, 7, 0), folder / "a.png"),
                    b = save(plant::render_strobe(photo_camera(), &jet, 100, 7, 1), folder / "b-2.png"),
                    before = file_text(a) + file_text(b);
  check_droplets_refused({a, "--picture", a}, a + ": would take the place of " + a);
  check_droplets_refused({a, b, "--picture", (folder / "b.png").string()},
                         b + ": would take the place of " + b);
  check_droplets_refused({a, "--background", b, "--picture", b}, b + ": would take the place of " + b);
  check_droplets_refused({a, "--picture", (folder / "seen.jpg").string()},
                         "seen.jpg: a PNG is written: the name must end in .png");
  check_droplets_refused({a, "--picture", "/nonexistent/seen.png"},
                         "/nonexistent/seen.png: there is no folder /nonexistent");
  CHECK(file_text(a) + file_text(b) == before);
  for (const char* option : {"--picture", "--background", "--target"})
    check_droplets_refused({a, option, "", "--pitch-um", "5"}, std::string(option) + ": the value is empty");
  check_droplets_refused({"/dev/zero"}, "/dev/zero: is no regular file");
}

TEST_CASE("The delays may stand before, between and behind the pictures") {
  const auto folder = fresh_folder("droplet-order");
  const plant::StrobeJet jet;
  const std::string a = save(plant::render_strobe(photo_camera(), &jet, 100, 7, 0), folder / "a.png"),
                    b = save(plant::render_strobe(photo_camera(), &jet, 120, 7, 1), folder / "b.png");
  const std::string said = firn_says({"droplets", a, b, "--delay-us", "100,120"}).out;
  CHECK_THAT(said, Contains("b.png (120 us)"));
  CHECK(firn_says({"droplets", "--delay-us", "100,120", a, b}).out == said);
  CHECK(firn_says({"droplets", a, "--delay-us=100,120", b}).out == said);
  CHECK(firn_says({"droplets", a, "--delay-us", "100", b, "--delay-us", "120"}).out == said);
}

TEST_CASE("An all black and an all white picture are no drop") {
  const auto folder = fresh_folder("droplet-even");
  for (const int level : {0, 255}) {
    const auto file = folder / (std::to_string(level) + ".png");
    REQUIRE(cv::imwrite(file.string(), cv::Mat(120, 160, CV_8U, cv::Scalar(level))));
    const Said said = firn_says({"droplets", file.string(), "--json"});
    CAPTURE(level, said.err);
    REQUIRE(said.code == 0);
    CHECK(Json::parse(said.out)["pictures"][0]["state"] == "no drop");
  }
}

TEST_CASE("A crop measures a picture without its caption, and places stay those of the whole picture") {
  const auto folder = fresh_folder("droplet-crop");
  const plant::StrobeJet jet;
  for (const auto& [name, white] :
       std::vector<std::pair<std::string, int>>{{"a.png", 255}, {"b.png", 4095}}) {
    plant::StrobeCamera c = photo_camera();
    c.white = white;
    plant::StrobePicture p = plant::render_strobe(c, &jet, 100, 7, 0);
    for (int y = 240; y < 270; ++y)  // a caption as programs paint it: darker or brighter than any light
      for (int x = 10; x < 120; ++x)
        if (x % 30 < 20) p.pixels[std::size_t(y * p.width + x)] = std::uint16_t(white > 255 ? 65535 : 0);
    if (white > 255) p.white = 65535;
    const std::string file = save(p, folder / name);
    const std::vector<std::string> words{
        "droplets", file, "--json", "--crop", "20,0,280,230", "--picture", (folder / "seen.png").string()};
    const Said said = firn_says(words);
    CAPTURE(name, said.err);
    REQUIRE(said.code == 0);
    const Json j = Json::parse(said.out)["pictures"][0];
    CHECK(j["state"] == "drop");
    CHECK(j["drops"].empty());
    CHECK(j["main"]["x_px"].get<double>() == Approx(p.truth.x_px).margin(0.1));
    CHECK(j["main"]["y_px"].get<double>() == Approx(p.truth.y_px).margin(0.1));
    CHECK(j["main"]["diameter_px"].get<double>() == Approx(p.truth.diameter_px).epsilon(0.015));
    CHECK(j["nozzle"]["y_px"].get<double>() == Approx(c.nozzle_y_px).margin(0.5));
    CHECK(j["nozzle"]["x_px"].get<double>() == Approx(c.nozzle_x_px).margin(0.5));
    CHECK(j["width_px"] == 320);
    const cv::Mat seen = cv::imread((folder / "seen.png").string());
    CHECK((seen.cols == 320 && seen.rows == 280));
  }
}

TEST_CASE("A crop that leaves a picture, is too small or no rectangle is refused by picture and limit") {
  const auto folder = fresh_folder("droplet-crop-errors");
  const plant::StrobeJet jet;
  const std::string a = save(plant::render_strobe(photo_camera(), &jet, 100, 7, 0), folder / "a.png");
  const std::string leaves =
      " leaves the picture of 320 x 280 pixels: x + width is at most 320, y + height 280";
  check_droplets_refused({a, "--crop", "60,0,261,200"}, a + ": --crop 60,0,261,200" + leaves);
  check_droplets_refused({a, "--crop", "60,81,260,200"}, a + ": --crop 60,81,260,200" + leaves);
  check_droplets_refused({a, "--crop=-1,0,100,200"}, a + ": --crop -1,0,100,200" + leaves);
  check_droplets_refused({a, "--crop", "2147483647,0,100,200"}, leaves);
  check_droplets_refused({a, "--crop", "0,0,15,200"},
                         "--crop: 15 x 200 pixels; sides must be from 16 to 16384");
  check_droplets_refused({a, "--crop", "0,0,100"}, "--crop: 3 numbers; it takes four: x,y,width,height [px]");
  check_droplets_refused({a, "--crop", "0,0,a,9"}, "--crop = 0,0,a,9");
  cv::imwrite((folder / "none.png").string(), cv::Mat(60, 60, CV_8U, cv::Scalar(9)));
  check_droplets_refused(
      {a, "--background", (folder / "none.png").string(), "--crop", "0,0,100,100"},
      (folder / "none.png").string() + ": --crop 0,0,100,100 leaves the picture of 60 x 60");
}
