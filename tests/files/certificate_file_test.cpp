#include "files/certificate_file.h"

#include <catch2/catch.hpp>
#include <limits>

using namespace firn;

TEST_CASE(
    "A certificate comes back from its file with every bit, and a cut or foreign file is refused by name and "
    "byte") {
  std::vector<float> m(3 * 5 * 64);
  for (std::size_t i = 0; i < m.size(); ++i) m[i] = float(i) * 1e-7f;
  const auto bytes = certificate_bytes(m, 5);
  CHECK(bytes.size() == 128 + 4 * m.size());
  CHECK(certificate_from(bytes, 5, "c.npy") == m);
  CHECK(certificate_from(certificate_bytes({}, 5), 5, "c.npy").empty());
  CHECK_THROWS_WITH(certificate_from(bytes, 6, "c.npy"),
                    Catch::Contains("c.npy: byte 10: not an array of float32 (cuts, 6, 64)"));
  CHECK_THROWS_AS(certificate_from(std::span(bytes).first(bytes.size() - 4), 5, "c.npy"),
                  std::invalid_argument);
  CHECK_THROWS_WITH(certificate_from(std::span(bytes).first(3), 5, "c.npy"),
                    Catch::Contains("byte 0: not an NPY file"));
  for (const float wrong :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    m[7] = wrong;
    CHECK_THROWS_WITH(certificate_from(certificate_bytes(m, 5), 5, "c.npy"),
                      Catch::Contains("byte 156: a multiplier is not a finite number"));
  }
}
