// Paths of a batch on the pool's threads: the bytes of one thread, and of one path after another.
#include <catch2/catch.hpp>
#include <cmath>

#include "config/ice_lab.h"
#include "lcmtypes/convert.h"
#include "procs/path_planner/node.h"
#include "runtime/thread_pool.h"
#include "tests/support/ice_print.h"
#include "tests/support/node_bench.h"

using namespace firn;

namespace {

planning::PlanningSetup setup_of(control::SurfaceVersion version, int max_pulses) {
  Experiment e = test::ice_experiment();
  e.control.surface.version = version;
  e.ice.max_pulses = max_pulses;
  return planning_setup(e, test::cobra());
}

bool equal(const planning::PlannedTask& a, const planning::PlannedTask& b) {
  bool same = a.problem == b.problem && a.trajectory.positions == b.trajectory.positions &&
              a.length_mm == b.length_mm && a.volume_mm3 == b.volume_mm3 && a.clipped_mm3 == b.clipped_mm3 &&
              a.lists.size() == b.lists.size() && a.tool.size() == b.tool.size();
  for (std::size_t n = 0; same && n < a.tool.size(); ++n)
    same = a.tool[n].x_mm == b.tool[n].x_mm && a.tool[n].y_mm == b.tool[n].y_mm;
  for (std::size_t n = 0; same && n < a.lists.size(); ++n)
    same = a.lists[n].start_s == b.lists[n].start_s && a.lists[n].volume_mm3 == b.lists[n].volume_mm3 &&
           a.lists[n].ticks == b.lists[n].ticks;
  return same;
}

}  // namespace

TEST_CASE("The paths of a batch are the same bytes on one, two and five threads, and planned one by one") {
  const slice::PrintPaths paths = test::ice_print();
  HeightMap action({40, 40, 1.0, 1.0, -20.0, -20.0});
  for (std::size_t c = 0; c < action.size(); ++c)
    action.cells[c] = 0.2 * std::sin(0.3 * double(c % 40)) * std::cos(0.2 * double(c / 40));
  for (const auto version : {control::SurfaceVersion::kPathSpeed, control::SurfaceVersion::kValveFrequency})
    for (const int max_pulses : {16384, 60}) {  // of 60 many a path is divided
      CAPTURE(word(version), max_pulses);
      const planning::PlanningSetup setup = setup_of(version, max_pulses);
      std::vector<planning::PathTask> tasks;
      for (int n = 1; n <= 5; ++n)  // some come again in other layers
        for (const bool measurement : {false, true})
          for (planning::PathTask& t :
               planning::tasks_of(paths, paths.layers[std::size_t(n - 1)], measurement, setup))
            tasks.push_back(std::move(t));
      planning::TaskPlanner one(setup);
      std::vector<planning::PlannedTask> expected;
      for (const planning::PathTask& t : tasks) expected.push_back(one.plan(t, &action));
      std::size_t divided = 0;
      for (const planning::PlannedTask& p : expected) divided += p.lists.size() > 1;
      CHECK((divided > 0) == (max_pulses == 60));
      for (const int threads : {1, 2, 5}) {
        planning::TaskPlanner batch(setup);
        const std::vector<planning::PlannedTask> got = batch.plan(tasks, &action, parallel_on(threads));
        REQUIRE(got.size() == expected.size());
        CHECK(batch.motions_planned() == one.motions_planned());
        for (std::size_t n = 0; n < got.size(); ++n) REQUIRE(equal(got[n], expected[n]));
        const std::vector<planning::PlannedTask> again =
            batch.plan(tasks, &action, parallel_on(threads));  // all remembered
        CHECK(batch.motions_planned() == one.motions_planned());
        for (std::size_t n = 0; n < again.size(); ++n)
          REQUIRE(again[n].trajectory.samples() == got[n].trajectory.samples());
      }
    }
}

TEST_CASE(
    "The path planner's node sends the same bytes whatever threads it is given, motions planned ahead or "
    "not") {
  for (const auto version : {control::SurfaceVersion::kPathSpeed, control::SurfaceVersion::kValveFrequency}) {
    Experiment e = test::ice_experiment();
    e.control.surface.version = version;
    std::vector<std::vector<std::byte>> sent[2];
    for (const int threads : {1, 3}) {
      auto node = std::make_unique<PathPlannerNode>(e, test::cobra(), test::ice_print());
      node->use_threads(parallel_on(threads));
      test::NodeBench b(NodeId::kPathPlanner, std::move(node));
      b.start();
      for (int n = 0; n < 8 && b.wake(); ++n) {
      }
      control_surface_t s{};
      s.layer = 5;
      s.map_id = 1;
      const GridSpec g{36, 36, 1.0, 1.0, -17.5, -17.5};
      s.grid = to_message(g);
      s.n = std::int32_t(g.size());
      for (std::size_t c = 0; c < g.size(); ++c) s.u.push_back(float(0.1 * std::sin(0.4 * double(c % 36))));
      s.feed_forward[0] = s.feed_forward[1] = 1.0;
      b.give(channels::kControlSurface, s);
      for (const auto& m : b.sent) sent[threads > 1].push_back(m.bytes);
    }
    REQUIRE(sent[0].size() > 200);
    CHECK(sent[0] == sent[1]);
  }
}
