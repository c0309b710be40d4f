// DropletAnalysis holds the droplets that firn droplets measures in files of strobe pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/vision/sweep.h"
#include "files/picture/read_picture.h"

namespace firn::report {

struct DropletRequest {
  std::vector<std::filesystem::path> images;
  std::vector<double> delays_us;                    ///< one each, or none
  double um_per_px = 0.0;                           ///< 0: not given
  double nozzle_um = 0.0;                           ///< 0: not given
  std::optional<std::filesystem::path> target;      ///< picture of a calibration target of dots
  double pitch_um = 0.0;                            ///< of the target's dots
  std::optional<std::filesystem::path> background;  ///< picture without a droplet
  vision::Polarity objects = vision::Polarity::kAuto;
  std::optional<PictureCrop> crop;  ///< the part of every picture that is measured; else all of it
};

struct AnalysedPicture {
  std::filesystem::path file;
  int width = 0, height = 0;  ///< of the whole picture
  std::optional<double> delay_us;
  vision::DropletPicture result;  ///< places in the whole picture
  double saturated = 0.0;  ///< share of the measured pixels at the white level, from which light was cut off
  std::vector<std::string> remarks;  ///< of the file's reader
};

struct DropletAnalysis {
  std::vector<AnalysedPicture> pictures;
  vision::Scale scale;  ///< 0: unknown
  std::optional<vision::SweepResult>
      sweep;  ///< pictures at two delays at least; in px where the scale is unknown
};

/// The static background is taken from `background`, or from at least five pictures of different delays whose
/// droplet moves on; otherwise each picture stands alone.
/// @throws UsageError naming the file, or the option, and the limit
DropletAnalysis analyse_droplets(const DropletRequest& request);

/// Warnings by picture, a line each: pixels that are saturated.
std::string droplets_warnings(const DropletAnalysis& analysis);
std::string droplets_json(const DropletAnalysis& analysis);
std::string droplets_text(const DropletAnalysis& analysis);

/// The picture with its findings drawn in: main droplet green, others blue, satellites orange, nozzle cyan;
/// PNG.
std::vector<std::byte> droplet_overlay(const AnalysedPicture& picture);

}  // namespace firn::report
