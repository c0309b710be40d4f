#include "core/options/for_people.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "core/grid/random.h"

using namespace firn;

TEST_CASE("People read a time in the unit that fits it") {
  const struct {
    double s;
    const char* text;
  } cases[] = {{0.0, "0 s"},         {0.3456, "0.346 s"}, {5.004, "5 s"},     {41.4, "41 s"},
               {119.4, "119 s"},     {121.0, "2 min"},    {3601.0, "60 min"}, {25200.0, "7 h"},
               {9100.0, "2.5 h"},    {-30.0, "-30 s"},    {3.6e6, "1,000 h"}, {7199.0, "120 min"},
               {std::nan(""), "- s"}};
  for (const auto& c : cases) CHECK(time_for_people(c.s) == c.text);
}

TEST_CASE("People read numbers in three significant digits, without exponent, and large ones whole") {
  const struct {
    double value;
    const char* text;
  } cases[] = {{0.0, "0"},          {-0.0, "0"},
               {7.5, "7.5"},        {60.000126, "60"},
               {47.28, "47.3"},     {1.1284, "1.13"},
               {9.996, "10"},       {0.005123, "0.00512"},
               {-0.1174, "-0.117"}, {999.4, "999"},
               {999.6, "1,000"},    {1e6, "1,000,000"},
               {12345.6, "12,346"}, {-1234567, "-1,234,567"},
               {-999.9, "-1,000"},  {1e-15, "0"},
               {3e-7, "0.0000003"}};
  for (const auto& c : cases) CHECK(for_people(c.value) == c.text);
  for (const double none : {std::nan(""), std::numeric_limits<double>::infinity()})
    CHECK(for_people(none) == "-");
}

TEST_CASE("A number for people lies within half a unit of its third digit") {
  for (std::uint32_t n = 0; n < 2000; ++n) {
    const std::uint64_t bits = random_bits({48, Purpose::kTest, 0, 0, n});
    const double power = std::pow(10.0, double(bits % 9) - 5.0),
                 value = power * (1.0 + double(bits >> 40) * 5e-7);
    INFO(n << ": " << value);
    std::string text = for_people(value);
    std::erase(text, ',');
    CHECK(std::abs(std::strtod(text.c_str(), nullptr) - value) <= 0.0051 * value);
    CHECK(text.find('e') == text.npos);
  }
}

TEST_CASE("Of a recorded sentence the long decimals are shortened, and nothing else") {
  CHECK(for_people("stage: no answer within 60.000126 s") == "stage: no answer within 60 s");
  CHECK(for_people("measuring again at 7.500000 mm/s") == "measuring again at 7.5 mm/s");
  CHECK(for_people("(-0.123456, 12.000000) mm aside") == "(-0.123, 12) mm aside");
  for (const char* same : {"layer 7, pass 12 of 123456789", "0.25 of 1.5", "tcp:127.0.0.1:19999", "5.",
                           "v1.2.3", "a digest 0.1234567", "\xff\xfe"})
    CHECK(for_people(same) == same);
}

TEST_CASE("A number is grouped by thousands") {
  RandomStream random(66, Purpose::kTest);
  CHECK(grouped(0) == "0");
  CHECK(grouped(999) == "999");
  CHECK(grouped(1000) == "1,000");
  for (int trial = 0; trial < 200; ++trial) {
    const std::uint64_t n = random.bits() >> random.below(64);
    std::string text = grouped(n);
    const std::size_t first = text.find(',');
    if (first != text.npos) CHECK(first <= 3);
    for (std::size_t at = first; at < text.size(); at += 4) REQUIRE(text[at] == ',');
    std::erase(text, ',');
    CHECK(text == std::to_string(n));
  }
}

TEST_CASE("A count of one thing names one, every other count names several") {
  CHECK(counted(0, "layer") == "0 layers");
  CHECK(counted(1, "layer") == "1 layer");
  CHECK(counted(1310, "droplet") == "1,310 droplets");
  CHECK(counted(1, "pass", "passes") == "1 pass");
  CHECK(counted(2, "pass", "passes") == "2 passes");
}
