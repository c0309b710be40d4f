// VisibleWidth computes how wide a Gauss-shaped line looks in the light that its ink takes, and the section
// of a line that looks so wide.
#pragma once

namespace firn::control {

inline constexpr double kWidthPerSigma = 2.3548;  ///< full width of a Gauss curve at half height

/// The contrast of ink of thickness h is 1 - exp(-h / depth) [Beer and Lambert]. At the middle h / depth = a,
/// so half of the contrast there is at h / depth = b = ln 2 - ln(1 + exp(-a)), and the full width at half
/// contrast is 2 sigma sqrt(2 ln(a / b)): a thicker line looks wider. Of thin ink b = a / 2.
/// Same bytes on every machine: exp and ln by their series.
class VisibleWidth {
 public:
  VisibleWidth(double sigma_mm, double depth_mm) : sigma_mm_(sigma_mm), depth_mm_(depth_mm) {}

  double width_mm(double section_mm2) const;
  /// Contrast of the line's middle to the substrate, 0 to 1.
  double contrast(double section_mm2) const;
  /// By bisection, between 1e-3 and 1e3 optical depths at the middle; the nearer limit beyond.
  double section_mm2(double width_mm) const;

 private:
  double depths(double section_mm2) const;

  double sigma_mm_, depth_mm_;
};

/// Thickness of ink of this contrast, in optical depths: -ln(1 - contrast). @pre contrast in [0, 1)
double ink_depths(double contrast);

}  // namespace firn::control
