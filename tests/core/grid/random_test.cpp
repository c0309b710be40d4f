#include "core/grid/random.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "core/grid/random_normals.h"

using namespace firn;

TEST_CASE("Philox4x32-10 gives the known answers of Random123's kat_vectors") {
  CHECK(philox4x32({0, 0, 0, 0}, {0, 0}) == PhiloxBlock{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  const std::uint32_t f = 0xffffffff;
  CHECK(philox4x32({f, f, f, f}, {f, f}) == PhiloxBlock{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  CHECK(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
        PhiloxBlock{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("Every part of a key changes the number, and a key always gives the same one") {
  const DrawKey base{7, Purpose::kTest, 3, 1, 9};
  std::vector<DrawKey> keys(7, base);
  keys[1].seed = 8;
  keys[2].seed = 7 + (1ull << 32);
  keys[3].purpose = Purpose::kInstance;
  keys[4].layer = 4;
  keys[5].attempt = 2;
  keys[6].cell = 10;
  std::set<std::uint64_t> seen;
  for (const DrawKey& k : keys) seen.insert(random_bits(k));
  CHECK(seen.size() == keys.size());
  CHECK(random_bits(base) == random_bits(base));
}

TEST_CASE("A stream is its key with cells 0, 1, 2, ...") {
  RandomStream stream(5, Purpose::kSurface, 2, 3);
  for (std::uint32_t n = 0; n < 20; ++n) CHECK(stream.bits() == random_bits({5, Purpose::kSurface, 2, 3, n}));
}

TEST_CASE("Uniform numbers lie in 0 to below 1, with the mean and variance of a uniform distribution") {
  RandomStream random(1, Purpose::kTest);
  double sum = 0.0, square = 0.0;
  constexpr int kN = 200000;
  for (int n = 0; n < kN; ++n) {
    const double u = random.uniform();
    REQUIRE(u >= 0.0);
    REQUIRE(u < 1.0);
    sum += u;
    square += u * u;
  }
  CHECK(sum / kN == Approx(0.5).margin(0.003));
  CHECK(square / kN - 0.25 == Approx(1.0 / 12.0).margin(0.003));
  for (int n = 0; n < 1000; ++n) {
    const double v = random.uniform(-3.0, 5.0);
    CHECK((v >= -3.0 && v < 5.0));
  }
}

TEST_CASE("Integers below n cover 0..n-1 evenly") {
  RandomStream random(2, Purpose::kTest);
  std::vector<int> count(7);
  for (int n = 0; n < 70000; ++n) ++count.at(random.below(7));
  for (int c : count) CHECK(std::abs(c - 10000) < 400);
  for (int n = 0; n < 100; ++n) CHECK(random.below(1) == 0);
}

TEST_CASE("Normal numbers have the quantiles of the normal distribution, tails included, and are finite") {
  RandomStream random(3, Purpose::kTest);
  constexpr int kN = 400000;
  int below[] = {0, 0, 0, 0, 0};
  const double at[] = {-3.0, -1.0, 0.0, 1.0, 3.0},
               share[] = {0.00134990, 0.15865525, 0.5, 0.84134475, 0.99865010};
  double sum = 0.0, square = 0.0;
  for (int n = 0; n < kN; ++n) {
    const double z = random.normal();
    REQUIRE(std::isfinite(z));
    sum += z;
    square += z * z;
    for (int q = 0; q < 5; ++q) below[q] += z < at[q];
  }
  for (int q = 0; q < 5; ++q)
    CHECK(below[q] / double(kN) == Approx(share[q]).margin(4.0 * std::sqrt(share[q] * (1 - share[q]) / kN)));
  CHECK(sum / kN == Approx(0.0).margin(0.007));
  CHECK(square / kN == Approx(1.0).margin(0.01));
}

TEST_CASE("Many normal numbers at once are those drawn one by one, to the last bit") {
  for (const std::size_t count : {0, 1, 15, 16, 17, 5003}) {
    const DrawKey first{0xfedcba9876543210u, Purpose::kTest, 5, 0xffffffffu, 0xfffffff0u};
    std::vector<double> many(count);
    random_normals(first, many);
    bool same = true;
    for (std::size_t n = 0; n < count; ++n) {
      DrawKey key = first;
      key.cell += std::uint32_t(n);
      same = same && many[n] == random_normal(key);
    }
    INFO(count << " numbers");
    CHECK(same);
  }
}

TEST_CASE("Many Philox blocks at once are those computed one by one") {
  for (const std::size_t count : {0, 1, 15, 16, 17, 203}) {
    const PhiloxBlock first{0xfffffff9u, 3, 0xffffffffu, 7};
    const std::array<std::uint32_t, 2> key{0x12345678u, 0xfedcba98u};
    std::vector<PhiloxBlock> many(count);
    philox_blocks(first, key, many);
    bool same = true;
    for (std::size_t n = 0; n < count; ++n)
      same = same && many[n] == philox4x32({first[0] + std::uint32_t(n), first[1], first[2], first[3]}, key);
    INFO(count << " blocks");
    CHECK(same);
  }
}
