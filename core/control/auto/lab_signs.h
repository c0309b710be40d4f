// LabSigns holds what the printed layers tell of the lab: the noise of a height, and which model predicts
// how unlike the cells of a layer rise.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/control/controller.h"

namespace firn::control {

/// Models that are judged by their predictions of one layer.
enum class JudgedModel : std::uint8_t { kFlow, kGraph };
inline constexpr std::array<std::string_view, 2> kJudgedModelNames{"height-change model", "graph model"};

/// One layer. Squares are means over the part's cells.
struct LayerSign {
  int layer = 0;            ///< 1-based
  double noise_mm = 0.0;    ///< of a measured height
  double unlike_mm2 = 0.0;  ///< of the rise about its mean, less the noise of two maps
  std::array<double, kJudgedModelNames.size()>
      missed_mm2{};  ///< by JudgedModel: of the rise about the predicted one, at the scale that fits best
};

/// @param before, after maps of layer `layer` - 1 and `layer`; finite on the mask
LayerSign sign_of_layer(const Setup& setup, const HeightMap& before, const DropletPattern& drops,
                        const MaterialMap& materials, const HeightMap& after, int layer, double noise_mm);

/// The signs of the newest kWindow layers together.
class LabSigns {
 public:
  static constexpr int kWindow = 6;  ///< layers
  static constexpr int kFewest = 2;  ///< layers without which nothing is told of a model
  /// A layer whose cells rise alike tells nothing of a model: by less than this share of a droplet's height,
  /// or than the noise of two maps.
  static constexpr double kLeastUnlike = 0.1;

  explicit LabSigns(double droplet_mm) : droplet_mm_(droplet_mm) {}
  void add(const LayerSign& sign);
  double noise_mm() const;    ///< mean over the window; 0: nothing is known
  int layers_judged() const;  ///< of the window, those that tell of a model
  bool judged() const { return layers_judged() >= kFewest; }
  /// The share of unlike rises that a model predicts: 1 all, 0 as much as a constant, below 0 less.
  /// @pre judged()
  double explained(JudgedModel model) const;
  JudgedModel better_model() const;  ///< @pre judged()

 private:
  bool tells(const LayerSign& s) const;
  double droplet_mm_;
  std::vector<LayerSign> layers_;
};

}  // namespace firn::control
