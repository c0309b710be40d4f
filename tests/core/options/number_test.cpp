#include "core/options/number.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/grid/random.h"

using namespace firn;

namespace {

std::uint64_t drawn(std::uint32_t n, std::uint32_t layer) {
  return random_bits({47, Purpose::kTest, layer, 0, n});
}

}  // namespace

TEST_CASE("A number is read with sign, point and exponent as other programs write them") {
  CHECK(whole_number<double>("2.5") == 2.5);
  CHECK(whole_number<double>("+2.5") == 2.5);
  CHECK(whole_number<double>("-.5") == -0.5);
  CHECK(whole_number<double>("5.") == 5.0);
  CHECK(whole_number<double>("1e-05") == 1e-5);
  CHECK(whole_number<double>("1.2E+03") == 1200.0);
  CHECK(whole_number<double>("1.000000000000000021e-02") == 0.01);
  CHECK(whole_number<std::int32_t>("+007") == 7);
  CHECK(whole_hex_number<std::uint8_t>("fF") == 255);
}

TEST_CASE("A text that goes on behind its number is none") {
  for (const char* text : {"2,5", "2.5mm", "1e", "1e+", "1.5.", "1 ", " 1", "1-2", "0x10", "1d3", "5e3e"})
    CHECK_FALSE(whole_number<double>(text));
  for (const char* text : {"1.0", "1e3", "12x", " 1"}) CHECK_FALSE(whole_number<std::int64_t>(text));
  CHECK_FALSE(whole_hex_number<std::uint32_t>("0x1"));
}

TEST_CASE("A text without a number is none") {
  for (const char* text :
       {"", "+", "-", ".", "+-5", "-+5", "--5", "++5", "e5", "nan", "-inf", "+infinity", "x"}) {
    CHECK_FALSE(whole_number<double>(text));
    CHECK_FALSE(whole_number<std::int32_t>(text));
  }
}

TEST_CASE("A number that the type does not hold is none, and one too near to 0 is 0") {
  CHECK_FALSE(whole_number<double>("1e309"));
  CHECK_FALSE(whole_number<float>("1e39"));
  CHECK_FALSE(whole_number<std::uint8_t>("256"));
  CHECK_FALSE(whole_number<std::uint32_t>("-1"));
  CHECK(whole_number<double>("-1e-400") == 0.0);
  CHECK(whole_number<float>("1e-60") == 0.0f);
}

TEST_CASE("A taken number leaves the text behind it") {
  std::string_view text = "10-5.5.25e1mm";
  CHECK(take_number<double>(text) == 10.0);
  CHECK(take_number<double>(text) == -5.5);
  CHECK(take_number<double>(text) == 2.5);
  CHECK(text == "mm");
  CHECK_FALSE(take_number<double>(text));
  CHECK(text == "mm");
}

TEST_CASE("An exponent can be left as a word of its own") {
  std::string_view text = "1E2";
  CHECK(take_number<double>(text, Exponent::kLeft) == 1.0);
  CHECK(text == "E2");
}

TEST_CASE("10000 drawn numbers in four notations read as strtod reads them") {
  constexpr const char* kNotations[] = {"%.17g", "%.3f", "%+.6e", "%.9f"};
  for (std::uint32_t n = 0; n < 10000; ++n) {
    const double size = std::ldexp(double(drawn(n, 0) >> 11), int(drawn(n, 1) % 80) - 90);
    char text[400];
    std::snprintf(text, sizeof text, kNotations[n % 4], drawn(n, 2) % 2 ? size : -size);
    CAPTURE(text);
    REQUIRE(whole_number<double>(text) == std::strtod(text, nullptr));
  }
}

TEST_CASE(
    "A drawn number followed by any character that is no part of one is refused whole and taken in part") {
  constexpr std::string_view kBehind = ",; xXmM%/\t:'\"";
  for (std::uint32_t n = 0; n < 1000; ++n) {
    const std::string number = std::to_string(std::int32_t(drawn(n, 3)) / 1000.0);
    const std::string text = number + kBehind[n % kBehind.size()] + "5";
    CHECK_FALSE(whole_number<double>(text));
    std::string_view rest = text;
    CHECK(take_number<double>(rest) == whole_number<double>(number));
    CHECK(rest == std::string_view(text).substr(number.size()));
  }
}
