#include "core/control/lines/focus_control.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <vector>

using namespace firn;
using namespace firn::control;

namespace {

constexpr SmfGains kFocusGains{0.8, 0.1, 0.0, 2.0};

/// Squared width of a laminar beam, relative to that at a ratio of 2: 1 - sqrt(R / (1 + R)).
double beam(double ratio) { return (1.0 - std::sqrt(ratio / (1.0 + ratio))) / (1.0 - std::sqrt(2.0 / 3.0)); }

/// The squared width of all layers after each of them.
std::vector<double> focused(FocusControl c, int layers, const std::function<double(int, double)>& nature) {
  std::vector<double> after;
  double share = c.next_share(0, 0.0), sum = 0.0;
  for (int layer = 1; layer <= layers; ++layer) {
    sum += nature(layer, share);
    after.push_back(sum / layer);
    share = c.next_share(layer, after.back());
  }
  return after;
}

FocusControl focus_control(double sheath_range = 0.8) {
  LineOptions options;
  options.sheath_range = sheath_range;
  return {options, kFocusGains, 0.4};
}

}  // namespace

TEST_CASE(
    "A beam that is wider or narrower than nominal is focused until all layers have the nominal width") {
  for (const double wide : {0.8, 1.15, 1.3}) {
    CAPTURE(wide);
    const std::vector<double> q =
        focused(focus_control(), 6, [&](int, double share) { return wide * beam(2.0 * share); });
    CHECK(q[0] == Approx(wide));
    CHECK(std::abs(q[2] - 1.0) < 0.25 * std::abs(wide - 1.0));
    CHECK(std::abs(q[5] - 1.0) < 0.02);
  }
}

TEST_CASE("A nozzle whose width answers the sheath half or twice as much as believed is held all the same") {
  for (const double power : {0.35, 1.5}) {
    CAPTURE(power);
    const std::vector<double> q =
        focused(focus_control(), 8, [&](int, double share) { return 1.2 * std::pow(share, -power); });
    CHECK(std::abs(q.back() - 1.0) < 0.04);
  }
}

TEST_CASE("The sheath's gas stays within its range") {
  FocusControl c = focus_control(0.1);
  CHECK(c.next_share(0, 0.0) == 1.0);
  CHECK(c.next_share(1, 1.6) == 1.1);
  CHECK(c.next_share(2, 0.5) == 0.9);
}

TEST_CASE("A width that is not known leaves the sheath's gas, and a layer measured twice counts once") {
  FocusControl once = focus_control(), twice = focus_control();
  for (FocusControl* c : {&once, &twice}) c->next_share(0, 0.0);
  const double first = once.next_share(1, 1.1);
  twice.next_share(1, 1.4);
  CHECK(twice.next_share(1, 1.1) == first);
  CHECK(once.next_share(2, std::nan("")) == first);
  CHECK(twice.next_share(2, 1.05) != first);
}
