#include "runtime/result_fingerprint.h"

#include <cvode/cvode.h>
#include <nlopt.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <span>
#include <vector>

#include "files/record/checksum.h"

namespace firn {
namespace {

constexpr int kArguments = 2048;
constexpr int kSide = 32;  // of the pictures

/// Arguments in [0, 1): SplitMix64 [Steele, Lea, Flood 2014], by whole numbers alone.
class Arguments {
 public:
  double next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_ = 1;
};

template <class Values>
std::uint64_t digest(const Values& values) {
  return record::checksum64(std::as_bytes(std::span(values)));
}

struct Unary {
  const char* name;
  double (*f)(double);
  double low, high;  ///< of the arguments
};
constexpr Unary kUnary[] = {
    {"acos", std::acos, -1, 1},     {"asin", std::asin, -1, 1},       {"atan", std::atan, -8, 8},
    {"cbrt", std::cbrt, -100, 100}, {"cos", std::cos, -8, 8},         {"erf", std::erf, -4, 4},
    {"erfc", std::erfc, -4, 8},     {"exp", std::exp, -30, 30},       {"expm1", std::expm1, -2, 2},
    {"log", std::log, 1e-6, 1e3},   {"log10", std::log10, 1e-6, 1e3}, {"log1p", std::log1p, -0.9, 10},
    {"sin", std::sin, -8, 8},       {"tan", std::tan, -1.5, 1.5}};
struct Binary {
  const char* name;
  double (*f)(double, double);
  double low, high;
};
constexpr Binary kBinary[] = {
    {"atan2", std::atan2, -4, 4}, {"hypot", std::hypot, -100, 100}, {"pow", std::pow, 0.01, 8}};

void add_math(Fingerprint& to) {
  std::array<double, kArguments> values;
  for (const Unary& row : kUnary) {
    Arguments x;
    for (double& v : values) v = row.f(row.low + (row.high - row.low) * x.next());
    to[row.name] = digest(values);
  }
  for (const Binary& row : kBinary) {
    Arguments x;
    for (double& v : values) {
      const double a = row.low + (row.high - row.low) * x.next();
      v = row.f(a, row.low + (row.high - row.low) * x.next());
    }
    to[row.name] = digest(values);
  }
}

std::uint64_t digest(const cv::Mat& m) {
  return record::checksum64({reinterpret_cast<const std::byte*>(m.data), m.total() * m.elemSize()});
}

void add_opencv(Fingerprint& to) {
  Arguments x;
  cv::Mat heights(kSide, kSide, CV_64F), marks(kSide, kSide, CV_8U), out;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      heights.at<double>(j, i) = x.next();
      marks.at<unsigned char>(j, i) = x.next() < 0.9;
    }
  cv::dct(heights, out);
  to["cv::dct"] = digest(out);
  cv::boxFilter(heights, out, CV_64F, {5, 5});
  to["cv::boxFilter"] = digest(out);
  cv::distanceTransform(marks, out, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  to["cv::distanceTransform"] = digest(out);
  const cv::Moments m = cv::moments(marks, true);
  to["cv::moments"] = digest(std::array{m.m00, m.m10, m.m01, m.mu20, m.mu11, m.mu02, m.mu30, m.nu21});
  cv::Subdiv2D mesh(cv::Rect(0, 0, kSide, kSide));
  for (int n = 0; n < 100; ++n) mesh.insert(cv::Point2f(float(kSide * x.next()), float(kSide * x.next())));
  std::vector<cv::Vec6f> triangles;
  mesh.getTriangleList(triangles);
  to["cv::Subdiv2D"] = digest(cv::Mat(triangles));
}

double rosenbrock(unsigned, const double* x, double* gradient, void*) {
  const double a = 1.0 - x[0], b = x[1] - x[0] * x[0];
  if (gradient) {
    gradient[0] = -2.0 * a - 400.0 * x[0] * b;
    gradient[1] = 200.0 * b;
  }
  return a * a + 100.0 * b * b;
}

void add_nlopt(Fingerprint& to) {
  constexpr struct {
    const char* name;
    nlopt_algorithm algorithm;
  } kSearches[] = {{"nlopt LD_LBFGS", NLOPT_LD_LBFGS},           {"nlopt LD_SLSQP", NLOPT_LD_SLSQP},
                   {"nlopt LN_BOBYQA", NLOPT_LN_BOBYQA},         {"nlopt LN_COBYLA", NLOPT_LN_COBYLA},
                   {"nlopt LN_NELDERMEAD", NLOPT_LN_NELDERMEAD}, {"nlopt GN_DIRECT_L", NLOPT_GN_DIRECT_L}};
  constexpr int kEvaluations = 60;
  for (const auto& row : kSearches) {
    const nlopt_opt search = nlopt_create(row.algorithm, 2);
    nlopt_set_min_objective(search, rosenbrock, nullptr);
    nlopt_set_lower_bounds1(search, -2.0);
    nlopt_set_upper_bounds1(search, 2.0);
    nlopt_set_maxeval(search, kEvaluations);
    std::array<double, 3> found{-1.2, 1.0, 0.0};
    nlopt_optimize(search, found.data(), &found[2]);
    nlopt_destroy(search);
    to[row.name] = digest(found);
  }
}

int oscillate(sunrealtype t, N_Vector y, N_Vector rate, void*) {
  const double* v = N_VGetArrayPointer(y);
  double* r = N_VGetArrayPointer(rate);
  r[0] = v[1];
  r[1] = 0.1 * t - v[0] - 0.1 * v[1] * v[1] * v[1];
  return 0;
}

#ifdef SUN_COMM_NULL
const auto kAlone = SUN_COMM_NULL;  // SUNDIALS 7
#else
constexpr std::nullptr_t kAlone = nullptr;
#endif

void add_sundials(Fingerprint& to) {
  SUNContext context = nullptr;
  SUNContext_Create(kAlone, &context);
  const N_Vector y = N_VNew_Serial(2, context);
  N_VConst(0.5, y);
  void* memory = CVodeCreate(CV_ADAMS, context);
  CVodeInit(memory, oscillate, 0.0, y);
  CVodeSStolerances(memory, 1e-8, 1e-10);
  const SUNNonlinearSolver solver = SUNNonlinSol_FixedPoint(y, 0, context);
  CVodeSetNonlinearSolver(memory, solver);
  double reached = 0.0;
  CVode(memory, 10.0, y, &reached, CV_NORMAL);
  to["CVode"] = digest(std::array{N_VGetArrayPointer(y)[0], N_VGetArrayPointer(y)[1]});
  CVodeFree(&memory);
  SUNNonlinSolFree(solver);
  N_VDestroy(y);
  SUNContext_Free(&context);
}

}  // namespace

const Fingerprint& result_fingerprint() {
  static const Fingerprint here = [] {
    Fingerprint f;
    add_math(f);
    add_opencv(f);
    add_nlopt(f);
    add_sundials(f);
    return f;
  }();
  return here;
}

}  // namespace firn
