// The time of a droplet's fall, against the plant's own integration of its flight.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/vision/flight.h"
#include "plant/inkjet/strobe_picture.h"

using namespace firn;
using namespace firn::vision;

TEST_CASE("A droplet falls through its gap in the time of the plant's flight, whenever its speed was seen") {
  const double speed_m_s = GENERATE(1.0, 2.0, 4.0), diameter_um = GENERATE(30.0, 60.0, 100.0),
               seen_us = GENERATE(0.0, 150.0), gap_um = 1000.0;
  double low = 0.0, high = 1e5;
  for (int n = 0; n < 60; ++n) {
    const double middle = 0.5 * (low + high);
    (plant::fly(speed_m_s, diameter_um, middle).um < gap_um ? low : high) = middle;
  }
  const double seen_m_s = plant::fly(speed_m_s, diameter_um, seen_us).speed_m_s;
  const double s = flight_time_s({1e3 * seen_m_s, 1e-6 * seen_us, 1e-3 * diameter_um}, 1.0);
  CHECK(s == Approx(1e-6 * high).epsilon(0.002));
}

TEST_CASE("Without a diameter the time is that of a straight line, and without a velocity or a gap it is 0") {
  CHECK(flight_time_s({2000.0, 1e-4, 0.0}, 1.0) == Approx(0.0005));
  for (const double v : {0.0, -1.0, std::nan("")}) CHECK(flight_time_s({v, 0.0, 0.05}, 1.0) == 0.0);
  CHECK(flight_time_s({1000.0, 0.0, 0.05}, 0.0) == 0.0);
}

TEST_CASE("A mist droplet that the air stops never arrives") {
  CHECK(std::isinf(flight_time_s({1000.0, 0.0, 0.003}, 1.0)));
}
