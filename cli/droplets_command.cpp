// run_droplets measures droplets in a user's own strobe pictures.
#include "cli/commands.h"

#include <cstdio>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "cli/output_files.h"
#include "files/exit_codes.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "report/droplets/droplet_files.h"

namespace firn {
namespace {

struct DropletsOptions {
  std::vector<std::string> images;
  std::vector<double> delays_us;
  double scale_um_per_px = 0.0, nozzle_um = 0.0, pitch_um = 0.0;
  std::string target, background;
  std::string objects = "auto";
  std::vector<int> crop;  ///< x, y, width, height [px]; empty: whole pictures
  std::string picture;    ///< PNG that is written
  bool json = false;
};

// OUT.png for one picture; OUT-1.png, OUT-2.png … for several.
std::filesystem::path numbered(const std::filesystem::path& out, std::size_t n, std::size_t of) {
  if (of == 1) return out;
  return out.parent_path() / (out.stem().string() + "-" + std::to_string(n + 1) + out.extension().string());
}

void check_picture(const DropletsOptions& o) {
  if (o.picture.empty()) return;
  if (std::filesystem::path(o.picture).extension() != ".png")
    throw UsageError("--picture " + o.picture + ": a PNG is written: the name must end in .png");
  std::vector<std::filesystem::path> inputs(o.images.begin(), o.images.end());
  for (const std::string& file : {o.target, o.background})
    if (!file.empty()) inputs.emplace_back(file);
  for (std::size_t i = 0; i < o.images.size(); ++i) {
    const std::string file = numbered(o.picture, i, o.images.size()).string();
    check_output_files(inputs, {file});
    check_writable({file});
  }
}

PictureCrop crop_of(const std::vector<int>& numbers) {
  if (numbers.size() != 4)
    throw UsageError("--crop: " + std::to_string(numbers.size()) +
                     " numbers; it takes four: x,y,width,height [px]");
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

/// @returns 0. @throws UsageError
int run_droplets(const DropletsOptions& o) {
  check_picture(o);
  report::DropletRequest r;
  r.images.assign(o.images.begin(), o.images.end());
  r.delays_us = o.delays_us;
  r.um_per_px = o.scale_um_per_px;
  r.nozzle_um = o.nozzle_um;
  r.pitch_um = o.pitch_um;
  if (!o.target.empty()) r.target = o.target;
  if (!o.background.empty()) r.background = o.background;
  if (o.objects == "dark") r.objects = vision::Polarity::kDark;
  if (o.objects == "bright") r.objects = vision::Polarity::kBright;
  if (!o.crop.empty()) r.crop = crop_of(o.crop);
  const report::DropletAnalysis a = report::analyse_droplets(r);
  if (!o.picture.empty())
    for (std::size_t i = 0; i < a.pictures.size(); ++i) {
      const std::vector<std::byte> png = report::droplet_overlay(a.pictures[i]);
      write_file_atomically(numbered(o.picture, i, a.pictures.size()),
                            {reinterpret_cast<const char*>(png.data()), png.size()});
    }
  std::fputs(report::droplets_warnings(a).c_str(), stderr);
  std::fputs((o.json ? report::droplets_json(a) : report::droplets_text(a)).c_str(), stdout);
  return kOk;
}

}  // namespace

void declare_droplets(OptionSet& options) {
  auto& o = options.calls(run_droplets);
  options.option("IMAGE", o.images, "strobe pictures: JPEG, PNG, TIFF, BMP or PNM, 8 or 16 bits").required();
  options
      .option("--delay-us", o.delays_us,
              "strobe delay of each picture, as 20,40,60: velocity, angle, break-off, jitter")
      .separated_by(',')
      .one_value_each()
      .within(-1e9, 1e9);
  options.option("--scale", o.scale_um_per_px, "um per pixel").within(1e-3, 1e4);
  options.option("--nozzle-um", o.nozzle_um, "width of the nozzle, which gives the scale").within(0.1, 1e5);
  options.option("--target", o.target, "picture of a calibration target: equal dots in a square lattice")
      .not_empty();
  options.option("--pitch-um", o.pitch_um, "distance of the target's dots").within(0.1, 1e5);
  options.option("--background", o.background, "picture of the same scene without a droplet").not_empty();
  options.option("--objects", o.objects, "droplets against their ground")
      .one_of({"auto", "dark", "bright"})
      .show_default();
  options
      .option("--crop", o.crop,
              "x,y,width,height: the part of every picture that is measured, without captions [px]")
      .separated_by(',')
      .one_value_each();
  options.option("--picture", o.picture, "writes the pictures with what was found, PNG; several: OUT-1.png …")
      .not_empty();
  options.json_flag(o.json);
}

}  // namespace firn
