#include "core/grid/random_normals.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "core/grid/avx2.h"

namespace firn {
namespace {

#ifdef __x86_64__

constexpr std::size_t kLanes = 4, kBlocks = 4, kAtOnce = kLanes * kBlocks;

/// kAtOnce outputs of philox4x32(), word k of each in the low halves of c[k].
struct Blocks {
  __m256i c[4][kBlocks];
};

__attribute__((target("avx2"))) void draw_blocks(const PhiloxBlock& first, std::uint32_t k0, std::uint32_t k1,
                                                 Blocks& out) {
  const __m256i m0 = _mm256_set1_epi64x(0xD2511F53), m1 = _mm256_set1_epi64x(0xCD9E8D57),
                low = _mm256_set1_epi64x(0xffffffff);
  auto& [c0, c1, c2, c3] = out.c;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    const std::uint32_t n = first[0] + std::uint32_t(kLanes * b);
    c0[b] = _mm256_set_epi64x(n + 3, n + 2, n + 1, n);
    c1[b] = _mm256_set1_epi64x(first[1]);
    c2[b] = _mm256_set1_epi64x(first[2]);
    c3[b] = _mm256_set1_epi64x(first[3]);
  }
  for (int round = 0; round < 10; ++round) {
    const __m256i key0 = _mm256_set1_epi64x(k0), key1 = _mm256_set1_epi64x(k1);
    for (std::size_t b = 0; b < kBlocks; ++b) {
      const __m256i p0 = _mm256_mul_epu32(c0[b], m0), p1 = _mm256_mul_epu32(c2[b], m1);
      c0[b] = _mm256_xor_si256(_mm256_xor_si256(_mm256_srli_epi64(p1, 32), c1[b]), key0);
      c1[b] = _mm256_and_si256(p1, low);
      c2[b] = _mm256_xor_si256(_mm256_xor_si256(_mm256_srli_epi64(p0, 32), c3[b]), key1);
      c3[b] = _mm256_and_si256(p0, low);
    }
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
}

// The middle of random_normal(), on kAtOnce cells; p are the uniform numbers.
__attribute__((target("avx2"))) void draw(const DrawKey& key, double* p, double* normal) {
  Blocks drawn;
  draw_blocks({key.cell, key.attempt, key.layer, std::uint32_t(key.purpose)}, std::uint32_t(key.seed),
              std::uint32_t(key.seed >> 32), drawn);
  const auto& [c0, c1, c2, c3] = drawn.c;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    // 52 bits as the fraction of a number in [2^52, 2^53), from which 2^52 is taken off: exact.
    const __m256i bits =
        _mm256_or_si256(_mm256_srli_epi64(_mm256_or_si256(c0[b], _mm256_slli_epi64(c1[b], 32)), 12),
                        _mm256_set1_epi64x(0x4330000000000000));
    const __m256d u = _mm256_mul_pd(
        _mm256_add_pd(_mm256_sub_pd(_mm256_castsi256_pd(bits), _mm256_set1_pd(0x1p52)), _mm256_set1_pd(0.5)),
        _mm256_set1_pd(0x1p-52));
    _mm256_storeu_pd(p + kLanes * b, u);
  }
  constexpr double a[] = {-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                          1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
  constexpr double d[] = {-5.447609879822406e+01, 1.615858368580409e+02, -1.556989798598866e+02,
                          6.680131188771972e+01, -1.328068155288572e+01};
  for (std::size_t n = 0; n < kAtOnce; n += kLanes) {
    const __m256d q = _mm256_sub_pd(_mm256_loadu_pd(p + n), _mm256_set1_pd(0.5)), r = _mm256_mul_pd(q, q);
    __m256d top = _mm256_set1_pd(a[0]), bottom = _mm256_set1_pd(d[0]);
    for (int k = 1; k < 6; ++k) top = _mm256_add_pd(_mm256_mul_pd(top, r), _mm256_set1_pd(a[k]));
    for (int k = 1; k < 5; ++k) bottom = _mm256_add_pd(_mm256_mul_pd(bottom, r), _mm256_set1_pd(d[k]));
    bottom = _mm256_add_pd(_mm256_mul_pd(bottom, r), _mm256_set1_pd(1.0));
    _mm256_storeu_pd(normal + n, _mm256_div_pd(_mm256_mul_pd(top, q), bottom));
  }
}

#endif

}  // namespace

void random_normals(const DrawKey& first, std::span<double> out) {
  std::size_t done = 0;
#ifdef __x86_64__
  constexpr double kTail = 0.02425;  // beyond it random_normal() takes a logarithm
  double p[kAtOnce];
  for (; has_avx2() && done + kAtOnce <= out.size(); done += kAtOnce) {
    DrawKey key = first;
    key.cell += std::uint32_t(done);
    draw(key, p, out.data() + done);
    for (std::size_t n = 0; n < kAtOnce; ++n)
      if (p[n] < kTail || p[n] > 1.0 - kTail) {
        DrawKey tail = key;
        tail.cell += std::uint32_t(n);
        out[done + n] = random_normal(tail);
      }
  }
#endif
  for (DrawKey key = first; done < out.size(); ++done) {
    key.cell = first.cell + std::uint32_t(done);
    out[done] = random_normal(key);
  }
}

void philox_blocks(const PhiloxBlock& first, const std::array<std::uint32_t, 2>& key,
                   std::span<PhiloxBlock> out) {
  PhiloxBlock counter = first;
  std::size_t done = 0;
#ifdef __x86_64__
  for (; has_avx2() && done + kAtOnce <= out.size(); done += kAtOnce) {
    counter[0] = first[0] + std::uint32_t(done);
    Blocks drawn;
    draw_blocks(counter, key[0], key[1], drawn);
    std::uint64_t words[4][kAtOnce];
    std::memcpy(words, drawn.c, sizeof words);
    for (std::size_t n = 0; n < kAtOnce; ++n)
      for (std::size_t k = 0; k < 4; ++k) out[done + n][k] = std::uint32_t(words[k][n]);
  }
#endif
  for (; done < out.size(); ++done) {
    counter[0] = first[0] + std::uint32_t(done);
    out[done] = philox4x32(counter, key);
  }
}

}  // namespace firn
