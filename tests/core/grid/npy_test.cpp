#include "core/grid/npy.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/grid/random.h"

using namespace firn;

namespace {

const GridSpec kNpyGrid{3, 2};

std::vector<std::byte> npy(const std::string& dict, const std::string& data, char major = 1) {
  std::string s = "\x93NUMPY";
  s += major;
  s += '\0';
  s += char(dict.size() & 0xff);
  s += char(dict.size() >> 8);
  if (major == 2) s += std::string(2, '\0');
  s += dict + data;
  std::vector<std::byte> out(s.size());
  std::memcpy(out.data(), s.data(), s.size());
  return out;
}

std::string dict(const std::string& dtype, const std::string& shape = "(2, 3)",
                 const std::string& order = "False") {
  return "{'descr': '" + dtype + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }\n";
}

void refused(const std::vector<std::byte>& bytes, const std::string& why) {
  CHECK_THROWS_WITH(height_map_from_npy(bytes, kNpyGrid, "target.npy"),
                    Catch::Contains("target.npy: byte ") && Catch::Contains(why));
}

}  // namespace

TEST_CASE("Maps and masks survive the way to NPY and back, NaN included, to the bit") {
  RandomStream random(1, Purpose::kTest);
  for (const GridSpec g : {GridSpec{1, 1}, GridSpec{3, 2}, GridSpec{40, 40}, GridSpec{7, 130}}) {
    HeightMap h(g);
    Mask m(g);
    for (std::size_t c = 0; c < h.size(); ++c) {
      h.cells[c] = random.below(5) ? random.uniform(-1.0, 1.0) : kNotMeasured;
      m.cells[c] = random.below(2);
    }
    const auto bytes = to_npy(h);
    const HeightMap back = height_map_from_npy(bytes, g, "h");
    CHECK(std::memcmp(back.data(), h.data(), h.size() * 8) == 0);
    CHECK(mask_from_npy(to_npy(m), g, "m") == m);
    CHECK(npy_shape(bytes, "h").nx == g.nx);
    CHECK(npy_shape(bytes, "h").ny == g.ny);
    CHECK((bytes.size() - h.size() * 8) % 64 == 0);  // data aligned as NumPy asks
  }
}

TEST_CASE(
    "Bytes as NumPy 1.24 writes np.save(np.array([[0, .5, 1], [2, 3, 4]], 'f4')) are read, versions 1 and "
    "2") {
  const float values[] = {0.0f, 0.5f, 1.0f, 2.0f, 3.0f, 4.0f};
  const std::string data(reinterpret_cast<const char*>(values), sizeof values);
  for (char version : {1, 2}) {
    const HeightMap h = height_map_from_npy(npy(dict("<f4"), data, version), kNpyGrid, "h");
    CHECK(h.at(1, 0) == 0.5);
    CHECK(h.at(2, 1) == 4.0);
  }
  CHECK(mask_from_npy(npy(dict("|b1"), std::string("\1\0\1\0\1\0", 6)), kNpyGrid, "m").count() == 3);
}

TEST_CASE("What is not such a file is refused with name, byte and reason") {
  const std::string six(48, '\0');
  refused({}, "magic");
  refused({std::byte{0x93}}, "magic");
  refused(npy("", "", 1), "cut");
  refused(npy(dict("<f8"), six, 3), "version 3");
  refused(npy(dict("<f8").substr(0, 20), ""), "lacks");
  refused(npy(dict(">f8"), six), "dtype '>f8'");
  refused(npy(dict("<i4"), six.substr(0, 24)), "dtype");
  refused(npy(dict("<f8", "(2, 3)", "True"), six), "Fortran");
  refused(npy(dict("<f8", "(6,)"), six), "shape");
  refused(npy(dict("<f8", "(2, 3, 1)"), six), "two-dimensional");
  refused(npy(dict("<f8", "(3, 2)"), six), "not the grid's (2, 3)");
  refused(npy(dict("<f8", "(99999, 2)"), six), "shape");
  refused(npy(dict("<f8", "(-2, 3)"), six), "shape");
  refused(npy(dict("<f8"), six.substr(1)), "47 bytes");
  refused(npy(dict("<f8"), six + "x"), "49 bytes");
  auto cut = npy(dict("<f8"), six);
  cut.resize(30);
  refused(cut, "byte 8: NPY header length 60 runs past the end");
  CHECK_THROWS_WITH(mask_from_npy(npy(dict("|u1"), std::string("\0\0\2\0\0\0", 6)), kNpyGrid, "m"),
                    Catch::Contains("mask value 2"));
}

TEST_CASE("No cut and no flipped bit of a file crashes the reader") {
  HeightMap h(kNpyGrid, 0.25);
  const auto good = to_npy(h);
  int refusals = 0;
  for (std::size_t n = 0; n < good.size(); ++n) {
    CHECK_THROWS_AS(height_map_from_npy(std::span(good).first(n), kNpyGrid, "h"), std::invalid_argument);
    for (int bit = 0; bit < 8; ++bit) {
      auto bad = good;
      bad[n] ^= std::byte(1 << bit);
      std::size_t cells = 6;  // read as another map of the same size, or refused
      try {
        cells = height_map_from_npy(bad, kNpyGrid, "h").size();
      } catch (const std::invalid_argument&) {
        ++refusals;
      }
      CHECK(cells == 6);
    }
  }
  CHECK(refusals > 100);
}
