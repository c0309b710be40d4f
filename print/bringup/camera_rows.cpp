// Rows of the camera: its pictures, and the light in them.
#include <algorithm>

#include "drivers/camera/picture_line.h"
#include "print/bringup/bringup.h"

namespace firn {
namespace {

struct TakenPicture {
  drivers::Picture picture;
  double took_s = 0.0;
};

// Names the mistake in a reply to SNAP.
std::string no_picture(std::string_view reply) {
  using namespace drivers::picture_line;
  const std::size_t end = reply.find('\n');
  const std::string line(reply.substr(0, std::min<std::size_t>(end, 80)));
  const auto told = parse(line, "SNAP");
  const auto head = told && told->accepted ? parse_head(told->text) : std::nullopt;
  if (!head || end == reply.npos)
    return "SNAP is answered '" + line + "', which is no head of a picture (docs/devices/camera.md)";
  const std::string_view pixels = reply.substr(end + 1);
  if (pixels.size() < head->bytes)
    return std::to_string(pixels.size()) + " of " + std::to_string(head->bytes) +
           " bytes of a picture have come: camera.picture_s, the line, the bridge";
  return "a picture's checksum is told as " + std::to_string(head->checksum) + ", that of its bytes is " +
         std::to_string(checksum(bytes_of(pixels.substr(0, head->bytes)))) + " (docs/devices/camera.md)";
}

TakenPicture take_picture(BringupLab& lab, const std::string& node) {
  using namespace drivers;
  const auto line = lab.line(node);
  const auto ask = [&](const Request& asked, double within_s) {
    const picture_line::PictureLineDialect dialect;
    return line->ask(
        asked.text(), [&](std::string_view s) { return is_whole_reply(dialect, asked, s); }, within_s);
  };
  const CameraConfig& c = lab.e.camera;
  const double exposure_s = c.exposure_us * 1e-6;
  if (const std::string set = ask(picture_line::set(c.exposure_us, c.gain_db, 0.0), 2.0);
      !set.starts_with("OK SET"))
    throw BringupStop("SET is answered '" + set.substr(0, set.find('\n')) +
                      "': camera.exposure_us, camera.gain_db");
  const std::string reply =
      ask(picture_line::snap(1, std::int64_t((exposure_s + c.picture_s) * 1e6)), exposure_s + c.picture_s);
  if (reply.starts_with("NO"))
    throw BringupStop("no picture: '" + reply.substr(0, reply.find('\n')) +
                      "': sensor, its cable, its bridge");
  const auto picture = picture_line::parse_picture(bytes_of(reply));
  if (!picture) throw BringupStop(no_picture(reply));
  return {*picture, line->last_answer_s()};
}

BringupFinding whole_picture(BringupLab& lab, const std::string& node) {
  const TakenPicture taken = take_picture(lab, node);
  const drivers::Picture& p = taken.picture;
  const double age_s = double(p.age_us) * 1e-6;
  return {age_s <= taken.took_s + 0.05,
          std::to_string(p.width) + " x " + std::to_string(p.height) + " of " + std::to_string(p.white) +
              " in " + number_text(taken.took_s) + " s, exposed " + number_text(age_s) +
              " s before its reply",
          "an exposure after the request", "the bridge gives an older picture: its buffer"};
}

BringupFinding picture_light(BringupLab& lab, const std::string& node) {
  constexpr double kDark = 0.1, kBright = 0.9, kMaxWhite = 0.02;
  const drivers::Picture p = take_picture(lab, node).picture;
  double sum = 0.0;
  for (const std::uint16_t v : p.pixels) sum += v;
  const double pixels = double(p.pixels.size()), mean = sum / pixels / p.white,
               white = double(std::ranges::count(p.pixels, std::uint16_t(p.white))) / pixels;
  return {mean >= kDark && mean <= kBright && white <= kMaxWhite,
          "mean " + number_text(100.0 * mean) + " % of white, " + number_text(100.0 * white) +
              " % of its pixels white",
          "mean of 10 to 90 %, at most 2 % white",
          mean < kDark ? "too dark: the strobe does not flash or is not in the exposure; lens cap, "
                         "camera.exposure_us, camera.gain_db"
                       : "too bright: aperture, camera.exposure_us, camera.gain_db"};
}

constexpr BringupRow kCameraRows[] = {
    {48, "camera", "a picture comes whole and new", "the bridge, camera.picture_s", &whole_picture},
    {49, "camera", "light: neither dark nor white", "camera.exposure_us, gain_db", &picture_light},
    {50, "camera", "droplets stand still in a sweep, further down with a longer delay",
     "docs/droplet-camera.md"},
};

}  // namespace

std::span<const BringupRow> camera_rows() { return kCameraRows; }

}  // namespace firn
