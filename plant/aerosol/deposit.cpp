#include "plant/aerosol/deposit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace firn::plant {
namespace {

constexpr int kFine = 2;        // fine cells per cell
constexpr double kReach = 4.0;  // sigmas
constexpr double kHaloStep_mm = 0.03;
constexpr double kSlowest_mm_s = 0.1;  // below, the wet section grows no wider

int margin_cells(const GridSpec& g, double reach_mm) {
  return std::clamp(int(std::ceil(reach_mm / std::min(g.pitch_x_mm, g.pitch_y_mm))), 2, 50);
}

// Shares of a Gauss curve in cells from `first`, of sum 1.
std::vector<double> shares(double centre, double sigma, int& first) {
  first = int(std::floor(centre - kReach * sigma));
  const int last = int(std::floor(centre + kReach * sigma));
  std::vector<double> w;
  double before = std::erf((first - centre) / (sigma * std::sqrt(2.0))), sum = 0.0;
  for (int n = first; n <= last; ++n) {
    const double next = std::erf((n + 1 - centre) / (sigma * std::sqrt(2.0)));
    w.push_back(next - before);
    sum += next - before;
    before = next;
  }
  for (double& v : w) v /= sum;
  return w;
}

}  // namespace

Deposit::Deposit(const GridSpec& grid, const AerosolParams& params, std::uint64_t seed)
    : params_(params),
      ratio_(params.focusing_ratio),
      sigma_mm_(beam_sigma_mm(params)),
      source_(params, seed),
      field_(grid, kFine, margin_cells(grid, kReach * params.halo * sigma_mm_)) {}

void Deposit::focus(double ratio) {
  ratio_ = ratio;
  sigma_mm_ = beam_sigma_mm(params_.nozzle_mm, ratio);
}

void Deposit::spot(double dry_mm3, double x_mm, double y_mm, double sigma_mm) {
  const double dx = field_.dx_mm(), dy = field_.dy_mm();
  int a0 = 0, b0 = 0;
  const std::vector<double> wx = shares((x_mm - field_.left_mm()) / dx, sigma_mm / dx, a0),
                            wy = shares((y_mm - field_.bottom_mm()) / dy, sigma_mm / dy, b0);
  const double height = dry_mm3 / (dx * dy);
  double on_field = 0.0;
  for (std::size_t k = 0; k < wy.size(); ++k) {
    const int b = b0 + int(k);
    if (b < 0 || b >= field_.height()) continue;
    for (std::size_t n = 0; n < wx.size(); ++n) {
      const int a = a0 + int(n);
      if (a < 0 || a >= field_.width()) continue;
      const double share = wx[n] * wy[k];
      on_field += share;
      field_.set_solid_mm(
          a, b,
          field_.surface_mm(std::size_t(b) * std::size_t(field_.width()) + std::size_t(a)) + height * share);
    }
  }
  ledger_.landed_mm3 += on_field * dry_mm3;
  ledger_.lost_mm3 += (1.0 - on_field) * dry_mm3;
}

void Deposit::lay(const Given& given, const Nozzle& at, double dt_s) {
  ledger_.passed_mm3 += given.passed_mm3;
  ledger_.kept_mm3 += given.kept_mm3;
  const double dry = given.passed_mm3 * params_.solids;
  if (dry > 0.0) {
    const double wet_mm2 = given.passed_mm3 / dt_s / std::max(kSlowest_mm_s, at.speed_mm_s);
    const double core = dry * (1.0 - params_.overspray), halo = dry - core;
    spot(core, at.x_mm, at.y_mm, std::sqrt(sigma_mm_ * sigma_mm_ + params_.spread * wet_mm2));
    if (halo > 0.0) {
      const double sum = halo_mm3_ + halo;
      halo_x_mm_ += (at.x_mm - halo_x_mm_) * halo / sum;
      halo_y_mm_ += (at.y_mm - halo_y_mm_) * halo / sum;
      halo_mm3_ = sum;
    }
  }
  const double away = std::hypot(at.x_mm - halo_x_mm_, at.y_mm - halo_y_mm_);
  if (halo_mm3_ > 0.0 && (away > 0.5 * kHaloStep_mm || source_.quiet())) {
    spot(halo_mm3_, halo_x_mm_, halo_y_mm_, params_.halo * sigma_mm_);
    halo_mm3_ = 0.0;
  }
}

void Deposit::io(Archive& a) {
  a.all(ratio_, sigma_mm_, source_, field_, ledger_, halo_mm3_, halo_x_mm_, halo_y_mm_);
}

}  // namespace firn::plant
