#include "estimators/droplet/symmetric3.h"

#include <cmath>

namespace firn::droplet {

std::array<double, 3> Symmetric3::times(const std::array<double, 3>& v) const {
  std::array<double, 3> out{};
  for (int r = 0; r < 3; ++r) out[std::size_t(r)] = at(r, 0) * v[0] + at(r, 1) * v[1] + at(r, 2) * v[2];
  return out;
}

double Symmetric3::form(const std::array<double, 3>& v) const {
  const auto t = times(v);
  return t[0] * v[0] + t[1] * v[1] + t[2] * v[2];
}

double determinant(const Symmetric3& a) {
  return a.at(0, 0) * (a.at(1, 1) * a.at(2, 2) - a.at(1, 2) * a.at(2, 1)) -
         a.at(0, 1) * (a.at(1, 0) * a.at(2, 2) - a.at(1, 2) * a.at(2, 0)) +
         a.at(0, 2) * (a.at(1, 0) * a.at(2, 1) - a.at(1, 1) * a.at(2, 0));
}

Symmetric3 inverse(const Symmetric3& a) {
  const double d = determinant(a);
  Symmetric3 out;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      const int r1 = (c + 1) % 3, r2 = (c + 2) % 3, c1 = (r + 1) % 3, c2 = (r + 2) % 3;
      out.at(r, c) = (a.at(r1, c1) * a.at(r2, c2) - a.at(r1, c2) * a.at(r2, c1)) / d;
    }
  return out;
}

Symmetric3 sandwich(const Symmetric3& a, const Symmetric3& b) {
  Symmetric3 ab, out;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k) ab.at(r, c) += a.at(r, k) * b.at(k, c);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k) out.at(r, c) += ab.at(r, k) * a.at(k, c);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < r; ++c) out.at(r, c) = out.at(c, r);
  return out;
}

bool positive_definite(const Symmetric3& a) {
  return a.at(0, 0) > 0.0 && a.at(0, 0) * a.at(1, 1) - a.at(0, 1) * a.at(1, 0) > 0.0 && determinant(a) > 0.0;
}

double separation(const Symmetric3& a) {
  Symmetric3 r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      if (!(a.at(i, i) > 0.0)) return 0.0;
      r.at(i, j) = i == j ? 1.0 : a.at(i, j) / std::sqrt(a.at(i, i) * a.at(j, j));
    }
  // Jacobi rotations of a 3 x 3 matrix converge in a few sweeps.
  for (int sweep = 0; sweep < 12; ++sweep)
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        const double off = r.at(p, q);
        if (off == 0.0) continue;
        const double tau = (r.at(q, q) - r.at(p, p)) / (2.0 * off);
        const double t = (tau >= 0.0 ? 1.0 : -1.0) / (std::abs(tau) + std::sqrt(1.0 + tau * tau));
        const double c = 1.0 / std::sqrt(1.0 + t * t), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double kp = r.at(k, p), kq = r.at(k, q);
          r.at(k, p) = c * kp - s * kq;
          r.at(k, q) = s * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = r.at(p, k), qk = r.at(q, k);
          r.at(p, k) = c * pk - s * qk;
          r.at(q, k) = s * pk + c * qk;
        }
      }
  double least = r.at(0, 0);
  for (int n = 1; n < 3; ++n) least = r.at(n, n) < least ? r.at(n, n) : least;
  return least > 0.0 ? (least < 1.0 ? least : 1.0) : 0.0;
}

}  // namespace firn::droplet
