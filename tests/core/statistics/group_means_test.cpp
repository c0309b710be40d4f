#include "core/statistics/group_means.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::statistics;

namespace {

std::vector<double> normals(std::uint64_t key, std::size_t n, double mean, double sd) {
  RandomStream random(key, Purpose::kTest);
  std::vector<double> x(n);
  for (double& v : x) v = mean + sd * random.normal();
  return x;
}

}  // namespace

TEST_CASE("Groups count alike, however many values they have") {
  const std::vector<std::vector<double>> groups{std::vector<double>(90, 1.0), {3.0}, {}};
  CHECK(mean_of_groups(groups) == Approx(2.0));
}

TEST_CASE("A hierarchical interval of one group is not known") {
  const std::vector<std::vector<double>> groups{{1.0, 2.0, 3.0}, {}};
  CHECK(std::isnan(hierarchical_interval(groups).low));
}

TEST_CASE("A hierarchical interval is as wide as groups differ, not as narrow as their values are many") {
  std::vector<std::vector<double>> alike, unlike;
  for (std::uint64_t g = 0; g < 10; ++g) {
    alike.push_back(normals(g + 1, 80, 0.0, 0.2));
    unlike.push_back(normals(g + 1, 80, g % 2 == 0 ? 0.5 : -0.5, 0.2));
  }
  const Interval a = hierarchical_interval(alike), u = hierarchical_interval(unlike);
  CHECK(u.high - u.low > 5.0 * (a.high - a.low));
}

TEST_CASE("A hierarchical 95 % interval of ten groups covers the mean of all groups in 88 to 99 %") {
  int covered = 0;
  for (std::uint64_t key = 1; key <= 200; ++key) {
    const std::vector<double> centres = normals(1000 + key, 10, 0.0, 0.3);
    std::vector<std::vector<double>> groups;
    for (std::size_t g = 0; g < centres.size(); ++g)
      groups.push_back(normals(5000 + 10 * key + g, 12, centres[g], 0.2));
    const Interval i = hierarchical_interval(groups, {0.95, 1000});
    covered += i.low <= 0.0 && 0.0 <= i.high;
  }
  CHECK(covered >= 176);
  CHECK(covered <= 198);
}

TEST_CASE("The same groups give the same interval") {
  const std::vector<std::vector<double>> groups{normals(1, 9, 0.0, 1.0), normals(2, 9, 0.0, 1.0)};
  CHECK(hierarchical_interval(groups).low == hierarchical_interval(groups).low);
}
