#include "core/grid/solids.h"

#include <cmath>
#include <utility>

#include "core/options/require.h"

namespace firn {
namespace {

[[noreturn]] void refuse_solid(const std::string& what) { firn::refuse("geometry", what); }

void positive(double value, const char* field) {
  if (!(std::isfinite(value) && value > 0.0))
    refuse_solid(std::string(field) + " = " + std::to_string(value) + " must be above 0");
}

void smaller(double bore, double outside, const char* field, const char* than) {
  positive(bore, field);
  if (!(bore < outside))
    refuse_solid(std::string(field) + " = " + std::to_string(bore) + " must be below " + than);
}

struct Middle {
  explicit Middle(const GridSpec& g)
      : x(0.5 * (g.x_mm(0) + g.x_mm(g.nx - 1))), y(0.5 * (g.y_mm(0) + g.y_mm(g.ny - 1))) {}
  double x, y;
};

double square(double v) { return v * v; }

class Pipe final : public Solid {
 public:
  Pipe(const SolidSpec& s, const GridSpec& g)
      : c_(g), outer_(square(0.5 * s.outer_diameter_mm)), inner_(square(0.5 * s.inner_diameter_mm)) {
    positive(s.outer_diameter_mm, "outer_diameter_mm");
    smaller(s.inner_diameter_mm, s.outer_diameter_mm, "inner_diameter_mm", "outer_diameter_mm");
  }
  bool contains(double x, double y, double) const override {
    const double r2 = radius2(x, y);
    return inner_ <= r2 && r2 <= outer_;
  }
  bool in_bore(double x, double y) const { return radius2(x, y) < inner_; }
  bool ahead(double x) const { return x >= c_.x; }
  double off_axis_y(double y) const { return y - c_.y; }

 private:
  double radius2(double x, double y) const { return square(x - c_.x) + square(y - c_.y); }
  Middle c_;
  double outer_, inner_;
};

class PipeJunction final : public Solid {
 public:
  PipeJunction(const SolidSpec& s, const GridSpec& g) : pipe_(s, g), s_(s) {
    positive(s.branch_width_mm, "branch_width_mm");
    positive(s.branch_height_mm, "branch_height_mm");
    positive(s.centre_z_mm, "centre_z_mm");
    smaller(s.branch_bore_width_mm, s.branch_width_mm, "branch_bore_width_mm", "branch_width_mm");
    smaller(s.branch_bore_height_mm, s.branch_height_mm, "branch_bore_height_mm", "branch_height_mm");
  }
  bool contains(double x, double y, double z) const override {
    const bool ahead = pipe_.ahead(x);
    if (pipe_.in_bore(x, y) ||
        (ahead && section(y, z, s_.branch_bore_width_mm, s_.branch_bore_height_mm) < 1.0))
      return false;
    return pipe_.contains(x, y, z) ||
           (ahead && section(y, z, s_.branch_width_mm, s_.branch_height_mm) <= 1.0);
  }

 private:
  double section(double y, double z, double width, double height) const {
    return square(pipe_.off_axis_y(y) / (0.5 * width)) + square((z - s_.centre_z_mm) / (0.5 * height));
  }
  Pipe pipe_;
  SolidSpec s_;
};

class Ellipsoid final : public Solid {
 public:
  Ellipsoid(const SolidSpec& s, const GridSpec& g) : c_(g), s_(s) {
    positive(s.outer_diameter_mm, "outer_diameter_mm");
    positive(s.height_mm, "height_mm");
    positive(s.centre_z_mm, "centre_z_mm");
  }
  bool contains(double x, double y, double z) const override {
    return (square(x - c_.x) + square(y - c_.y)) / square(0.5 * s_.outer_diameter_mm) +
               square((z - s_.centre_z_mm) / (0.5 * s_.height_mm)) <=
           1.0;
  }

 private:
  Middle c_;
  SolidSpec s_;
};

}  // namespace

const std::vector<std::string>& solid_kinds() {
  static const std::vector<std::string> kinds = {"none",      "pipe",   "pipe_junction",
                                                 "ellipsoid", "images", "mesh"};
  return kinds;
}

void check(const SolidSpec& spec) { check_options("geometry", kSolidSpec, spec); }

std::unique_ptr<Solid> make_solid(const SolidSpec& spec, const GridSpec& grid) {
  check(grid);
  check(spec);
  if (spec.kind == "pipe") return std::make_unique<Pipe>(spec, grid);
  if (spec.kind == "pipe_junction") return std::make_unique<PipeJunction>(spec, grid);
  if (spec.kind == "ellipsoid") return std::make_unique<Ellipsoid>(spec, grid);
  refuse_solid("shape '" + spec.kind + "' is no analytic solid (pipe, pipe_junction, ellipsoid)");
}

ImageStack::ImageStack(const GridSpec& grid, double pitch_z_mm, std::vector<Mask> layers)
    : grid_(grid), pitch_z_mm_(pitch_z_mm), layers_(std::move(layers)) {
  check(grid);
  if (!kImagePitch_mm.holds(pitch_z_mm))
    refuse_solid("image_pitch_z_mm = " + shortest_text(pitch_z_mm) + " is outside " + text(kImagePitch_mm));
  if (layers_.empty()) refuse_solid("a stack of images needs one at least");
  for (std::size_t n = 0; n < layers_.size(); ++n)
    if (layers_[n].size() != grid.size())
      refuse_solid("image " + std::to_string(n) + " has " + std::to_string(layers_[n].size()) +
                   " cells, the grid " + std::to_string(grid.size()));
}

bool ImageStack::contains(double x_mm, double y_mm, double z_mm) const {
  const double u = std::floor((x_mm - grid_.origin_x_mm) / grid_.pitch_x_mm + 0.5),
               v = std::floor((y_mm - grid_.origin_y_mm) / grid_.pitch_y_mm + 0.5),
               w = std::floor(z_mm / pitch_z_mm_);
  if (!(u >= 0.0 && v >= 0.0 && w >= 0.0 && u < grid_.nx && v < grid_.ny && w < double(layers_.size())))
    return false;
  return layers_[std::size_t(w)].at(int(u), int(v)) != 0;
}

}  // namespace firn
