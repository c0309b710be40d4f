// The audit finds each way in which a print can go wrong, planted into a print that went right.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "core/grid/firing_order.h"
#include "core/grid/random.h"
#include "core/grid/sub_patterns.h"
#include "replay/audit.h"

namespace firn::test {
namespace {

using replay::AuditRecord;
using replay::AuditVerdict;
using replay::Shot;
using replay::ViolationKind;
using replay::WorldTruth;

constexpr std::int64_t kSecond = 1'000'000;

// A print of some layers on a small grid: map, plan, passes of at most two droplets a cell, report, cure.
struct Print {
  AuditRecord record;
  WorldTruth world;
  GridSpec grid{5, 4, 0.25, 0.25, 0.0, 0.0};

  explicit Print(int layers = 4) {
    RandomStream random(5, Purpose::kTest);
    std::int64_t t = kSecond;
    record.starts = {0};
    record.finished = true;
    for (int layer = 1; layer <= layers; ++layer) {
      record.maps.push_back({t, layer - 1, 100 + layer, t - 1000});
      DropletPattern drops(grid);
      for (auto& d : drops.cells) d = std::uint8_t(random.below(3));
      drops.cells[7] = 2;
      record.plans.push_back({t + 1000, layer, 2, 100 + layer, drops, {}});
      for (int pass = 0; pass < 2; ++pass) {
        t += kSecond;
        record.leases.push_back({t - 2000, t + kSecond});
        world.jet.push_back({t - 1000, true});
        record.orders.push_back({t, layer, 0, pass, grid, firing_order(drops, pass)});
        for (const std::uint32_t c : record.orders.back().cells) {
          t += 1000;
          world.shots.push_back({t, std::int32_t(c) % grid.nx, std::int32_t(c) / grid.nx,
                                 std::uint32_t(layer - 1),
                                 random.below(50) ? Shot::Outcome::kFired : Shot::Outcome::kMissed});
        }
        world.jet.push_back({t + 500, false});
        const std::int64_t n = std::int64_t(record.orders.back().cells.size());
        record.reports.push_back({t + 1000, layer, 0, pass, 100 + layer, n, n});
      }
      t += kSecond;
    }
    record.maps.push_back({t, layers, 101 + layers, t - 1000});
  }

  AuditVerdict verdict() const { return replay::audit(record, &world, {}); }

  // Index of the first shot of an order.
  std::size_t first_shot(std::size_t order) const {
    std::size_t n = 0;
    for (std::size_t k = 0; k < order; ++k) n += record.orders[k].cells.size();
    return n;
  }
};

bool found(const AuditVerdict& v, ViolationKind kind) {
  INFO(to_text(v));
  CHECK(!v.clean());
  return std::ranges::any_of(v.violations, [&](const auto& x) { return x.kind == kind; });
}

TEST_CASE("a print that went right is clean, with and without the world's record") {
  const Print p;
  const AuditVerdict v = p.verdict();
  INFO(to_text(v));
  CHECK(v.clean());
  CHECK(v.layers == 4);
  CHECK(v.passes == 8);
  CHECK(v.commanded == std::int64_t(p.world.shots.size()));
  CHECK(v.triggered == v.commanded);
  CHECK(v.fired + v.missed == v.triggered);
  CHECK(to_text(v).starts_with("clean: 4 layers, 8 passes, "));
  CHECK(replay::audit(p.record, nullptr, {}).clean());
}

TEST_CASE(
    "an audit looks at a number of entries that grows as the print does, also where droplets are in doubt") {
  std::vector<double> compared;
  for (const int layers : {50, 100, 200, 400}) {
    Print p(layers);
    for (std::size_t n = 3; n < p.record.reports.size(); n += 4) p.record.reports[n].unknown_from = 0;
    for (int incarnation = 1; incarnation < layers; ++incarnation) {  // a stop a layer
      const replay::MeasuredMap& map = p.record.maps[std::size_t(incarnation)];
      p.record.stops.push_back({map.t_us, "planted", incarnation - 1});
      p.record.starts.push_back(map.t_us + 1);
    }
    const AuditVerdict v = p.verdict();
    CHECK(v.unknowns.size() == std::size_t(layers) / 2);
    CHECK(v.stops == layers - 1);
    compared.push_back(double(v.compared));
  }
  for (std::size_t n = 1; n < compared.size(); ++n) CHECK(std::log2(compared[n] / compared[n - 1]) < 1.05);
}

TEST_CASE("a pass that was refused and commanded again is clean, unless droplets fell at the first command") {
  Print p;
  replay::PassOrder refused = p.record.orders[2];
  refused.t_us -= 100'000;
  p.record.orders.insert(p.record.orders.begin() + 2, refused);
  const AuditVerdict v = p.verdict();
  INFO(to_text(v));
  CHECK(v.clean());
  Shot early = p.world.shots[p.first_shot(2)];
  early.t_us = refused.t_us + 1000;
  p.world.shots.insert(p.world.shots.begin() + std::ptrdiff_t(p.first_shot(2)), early);
  CHECK(found(p.verdict(), ViolationKind::kCellNotReported));
}

TEST_CASE("a skipped layer is found") {
  Print p;
  const auto gone = [](const auto& x) { return x.layer == 2; };
  const std::size_t from = p.first_shot(2), to = p.first_shot(4);
  std::erase_if(p.record.orders, gone);
  std::erase_if(p.record.reports, gone);
  p.world.shots.erase(p.world.shots.begin() + std::ptrdiff_t(from),
                      p.world.shots.begin() + std::ptrdiff_t(to));
  CHECK(found(p.verdict(), ViolationKind::kSkippedLayer));
}

TEST_CASE("a layer that is deposited twice is found, in the record and in the world") {
  Print p;
  const auto order = p.record.orders[2];
  const auto report = p.record.reports[2];
  const std::size_t from = p.first_shot(2), to = p.first_shot(3);
  std::vector<Shot> again(p.world.shots.begin() + std::ptrdiff_t(from),
                          p.world.shots.begin() + std::ptrdiff_t(to));
  const std::int64_t later = 60 * kSecond;
  for (Shot& s : again) s.t_us += later;
  p.world.shots.insert(p.world.shots.end(), again.begin(), again.end());
  p.record.orders.push_back(order);
  p.record.orders.back().t_us += later;
  p.record.reports.push_back(report);
  p.record.reports.back().t_us += later;
  const AuditVerdict v = p.verdict();
  CHECK(found(v, ViolationKind::kLayerTwice));
  CHECK(found(v, ViolationKind::kCellTwice));
}

TEST_CASE("a pass that is left out or left incomplete is found") {
  Print p;
  p.record.orders.erase(p.record.orders.begin() + 3);
  p.record.reports.erase(p.record.reports.begin() + 3);
  CHECK(found(replay::audit(p.record, nullptr, {}), ViolationKind::kSkippedPass));

  Print q;
  q.record.reports[2].unknown_from -= 2;
  q.record.reports[2].unknown_to -= 2;
  q.world.shots.erase(q.world.shots.begin() + std::ptrdiff_t(q.first_shot(3)) - 2,
                      q.world.shots.begin() + std::ptrdiff_t(q.first_shot(3)));
  CHECK(found(q.verdict(), ViolationKind::kSkippedPass));
}

TEST_CASE("a droplet beside the plan, twice, too few or unreported is found") {
  Print beside;
  beside.world.shots[beside.first_shot(3) + 1].i = 99;
  CHECK(found(beside.verdict(), ViolationKind::kCellNotCommanded));
  CHECK(found(beside.verdict(), ViolationKind::kCellNotTriggered));

  Print twice;
  const std::size_t n = twice.first_shot(3) + 1;
  twice.world.shots.insert(twice.world.shots.begin() + std::ptrdiff_t(n), twice.world.shots[n]);
  CHECK(found(twice.verdict(), ViolationKind::kCellTwice));
  CHECK(twice.verdict().violations_total == 1);

  Print few;
  few.world.shots[few.first_shot(3) + 1].outcome = Shot::Outcome::kIgnored;
  CHECK(found(few.verdict(), ViolationKind::kCellNotTriggered));
  CHECK(few.verdict().ignored == 1);

  Print unreported;
  unreported.record.reports.back().unknown_from -= 1;
  unreported.record.reports.back().unknown_to -= 1;
  CHECK(found(unreported.verdict(), ViolationKind::kCellNotReported));
}

TEST_CASE("other cells than planned, a missing report and a pass without a plan are found") {
  Print other;
  for (auto& d : other.record.plans[1].drops.cells) d = 1;
  CHECK(found(other.verdict(), ViolationKind::kOtherCells));

  Print silent;
  silent.record.reports.erase(silent.record.reports.begin() + 4);
  CHECK(found(silent.verdict(), ViolationKind::kNoReport));

  Print unplanned;
  unplanned.record.plans.erase(unplanned.record.plans.begin() + 1);
  CHECK(found(unplanned.verdict(), ViolationKind::kOtherCells));
}

TEST_CASE("droplets in doubt are listed with the scan that resolved them") {
  Print p;
  // layer 2: the first pass is in doubt from droplet 3 on, so its second pass is not printed
  const std::int64_t n = std::int64_t(p.record.orders[2].cells.size());
  p.record.reports[2].unknown_from = 3;
  p.record.reports[2].unknown_to = n;
  const std::size_t from = p.first_shot(3), to = p.first_shot(4);
  p.world.shots.erase(p.world.shots.begin() + std::ptrdiff_t(from - 2),
                      p.world.shots.begin() + std::ptrdiff_t(to));
  p.record.orders.erase(p.record.orders.begin() + 3);
  p.record.reports.erase(p.record.reports.begin() + 3);
  AuditVerdict v = p.verdict();
  INFO(to_text(v));
  CHECK(v.clean());
  REQUIRE(v.unknowns.size() == 1);
  CHECK(v.unknowns[0].layer == 2);
  CHECK(v.unknowns[0].from == 3);
  CHECK(v.unknowns[0].resolved_by == 103);
  CHECK(to_text(v).find("resolved by the scan of map 103") != std::string::npos);

  // the same, but the next layer was planned from a map that was measured before
  p.record.maps[2].sample_us = p.record.reports[2].t_us - 1;
  CHECK(found(p.verdict(), ViolationKind::kUnresolved));
  CHECK(!p.verdict().unknowns[0].resolved_by);
}

TEST_CASE("doubt at the end of a finished print must be measured too") {
  Print p;
  p.record.reports.back().unknown_from -= 1;
  CHECK(p.verdict().clean());
  p.record.maps.pop_back();
  CHECK(found(p.verdict(), ViolationKind::kUnresolved));
  p.record.finished = false;
  CHECK(p.verdict().clean());
}

// Two layers whose droplets are at places inside their cells, fired with a lead.
struct Placed : Print {
  Placed() : Print(0) {
    RandomStream random(8, Purpose::kTest);
    record.maps.clear();
    std::int64_t t = kSecond;
    for (int layer = 1; layer <= 2; ++layer) {
      record.maps.push_back({t, layer - 1, 100 + layer, t - 1000});
      Placement placement{OffsetTable({OffsetKind::kGrid, 4, 3}), OffsetMap(grid), layer == 1 ? 0.0 : 0.2};
      for (auto& c : placement.map.cells)
        c = std::uint8_t(random.below(std::uint32_t(placement.table.size())));
      const DropletPattern drops(grid, 1);
      record.plans.push_back({t + 1000, layer, 1, 100 + layer, drops, {}, placement.map});
      t += kSecond;
      record.leases.push_back({t - 2000, t + kSecond});
      world.jet.push_back({t - 1000, true});
      replay::PassOrder o{t, layer, 0, 0, grid, {}, placement, {}};
      for (const FiringRun& run : firing_runs(drops, 0, placement))
        for (const std::uint32_t c : run.cells) {
          const StagePlace at = stage_place(grid, int(c) % grid.nx, run.row, placement.of(c),
                                            {.lead_mm = 0.3}, run.towards_plus_x);
          o.cells.push_back(c);
          o.places.push_back(at);
          t += 1000;
          Shot s{t, int(std::lround(at.x_mm / grid.pitch_x_mm)), int(std::lround(at.y_mm / grid.pitch_y_mm)),
                 std::uint32_t(layer - 1)};
          s.x_mm = at.x_mm + 1e-4 * random.uniform(-1.0, 1.0);
          s.y_mm = at.y_mm + 1e-4 * random.uniform(-1.0, 1.0);
          world.shots.push_back(s);
        }
      record.orders.push_back(o);
      world.jet.push_back({t + 500, false});
      const auto n = std::int64_t(o.cells.size());
      record.reports.push_back({t + 1000, layer, 0, 0, 100 + layer, n, n});
      t += kSecond;
    }
    record.maps.push_back({t, 2, 103, t - 1000});
  }
};

TEST_CASE("A pass of droplets of another size than the jet was armed for is found") {
  Placed p;
  const OffsetTable two({OffsetKind::kGrid, 4, 3, 0.5});
  for (replay::PassOrder& o : p.record.orders) {
    o.placement.table = two;
    p.record.arms.push_back({o.t_us - 1000, o.layer == 2});
    if (o.layer == 1) continue;
    for (auto& place : o.placement.map.cells) place = std::uint8_t(place + two.places());
    p.record.plans[1].offsets = o.placement.map;
    p.record.parts.push_back({2, 0, 0, 1});
  }
  INFO(to_text(p.verdict()));
  CHECK(p.verdict().clean());

  Placed unarmed = p;
  unarmed.record.arms.back().small = false;
  CHECK(found(unarmed.verdict(), ViolationKind::kOtherSize));

  Placed mixed = p;
  mixed.record.orders[1].placement.map.cells[7] -= std::uint8_t(two.places());
  mixed.record.plans[1].offsets = mixed.record.orders[1].placement.map;
  CHECK(found(mixed.verdict(), ViolationKind::kOtherSize));
}

TEST_CASE("Droplets at their places inside cells are clean, and each way beside them is found") {
  const Placed p;
  const AuditVerdict v = p.verdict();
  INFO(to_text(v));
  CHECK(v.clean());
  CHECK(v.commanded == 40);

  Placed beside = p;
  beside.world.shots[25].x_mm += 0.03;  // places are 0.0625 mm apart
  CHECK(beside.verdict().clean());
  beside.world.shots[25].x_mm += 0.01;
  CHECK(found(beside.verdict(), ViolationKind::kBesidePlace));

  Placed twice = p;
  twice.world.shots.insert(twice.world.shots.begin() + 25, twice.world.shots[25]);
  CHECK(found(twice.verdict(), ViolationKind::kCellTwice));
  CHECK(twice.verdict().violations_total == 1);

  Placed few = p;
  few.world.shots.erase(few.world.shots.begin() + 25);
  CHECK(found(few.verdict(), ViolationKind::kCellNotTriggered));

  Placed sent_elsewhere = p;
  sent_elsewhere.record.orders[1].placement.map.cells[3] ^= 1;
  CHECK(found(sent_elsewhere.verdict(), ViolationKind::kOtherCells));

  Placed centres = p;
  centres.record.plans[0].offsets = {};
  CHECK(found(centres.verdict(), ViolationKind::kOtherCells));
}

TEST_CASE("a droplet later than a second after a stop is found, and the latest is told") {
  Print p;
  const std::int64_t last = p.world.shots.back().t_us;
  p.record.stops = {{last - 400'000, "jet: link lost"}, {last - 300'000, "jet: link lost"}};
  AuditVerdict v = p.verdict();
  CHECK(v.clean());
  CHECK(v.longest_stop_s == Approx(0.4));
  CHECK(v.stops == 1);
  p.record.end_us = last - 500'000;
  CHECK(p.verdict().stops == 0);  // the orderly stop at the end
  p.record.stops[0].t_us = last - kSecond - 1;
  CHECK(found(p.verdict(), ViolationKind::kAfterStop));

  replay::AuditOptions fast;
  fast.time_scale = 10;  // 1 s of node time is 0.1 s of wall time
  v = replay::audit(p.record, &p.world, fast);
  CHECK(v.clean());
  CHECK(v.longest_stop_s == Approx(0.1).margin(0.01));

  p.record.starts = {0, last - 500'000};  // a resume after the stop: its droplets are its own
  CHECK(p.verdict().clean());
}

TEST_CASE("a stop counts for the incarnation that sent it, whatever its time") {
  Print p;
  const std::int64_t resumed = p.world.shots[p.first_shot(4)].t_us - 1;
  p.record.starts = {0, resumed};
  p.record.stops = {{resumed - 1, "launcher: interrupted", 0}, {resumed - 2 * kSecond, "old", 1}};
  CHECK(found(p.verdict(), ViolationKind::kAfterStop));
  p.record.stops.pop_back();
  CHECK(p.verdict().clean());
  p.record.stops = {{p.world.shots.back().t_us - 2 * kSecond, "jet: link lost", 1}};
  CHECK(found(p.verdict(), ViolationKind::kAfterStop));
}

TEST_CASE("droplets without a lease, from a disarmed jet, or before any command are found") {
  Print lease;
  for (auto& l : lease.record.leases) l.until_us = l.t_us - 5 * kSecond;
  CHECK(found(lease.verdict(), ViolationKind::kOutsideLease));

  Print disarmed;
  disarmed.world.jet.erase(disarmed.world.jet.begin() + 4);
  CHECK(found(disarmed.verdict(), ViolationKind::kDisarmed));

  Print early;
  early.world.shots.insert(early.world.shots.begin(), Shot{1, 0, 0, 0, Shot::Outcome::kFired});
  CHECK(found(early.verdict(), ViolationKind::kNotCommanded));
}

TEST_CASE("droplets on a layer that was not cured are found") {
  Print p;
  for (Shot& s : p.world.shots) s.exposures = std::min<std::uint32_t>(s.exposures, 2);
  CHECK(found(p.verdict(), ViolationKind::kNotCured));
}

// Two layers of two inks in four sub-patterns: ink A and ink B of a sub-pattern, then a cure.
struct Interlaced : Print {
  Interlaced() : Print(0) {
    RandomStream random(6, Purpose::kTest);
    record.maps.clear();
    std::int64_t t = kSecond;
    std::uint32_t cures = 0;
    for (int layer = 1; layer <= 2; ++layer) {
      record.maps.push_back({t, layer - 1, 100 + layer, t - 1000});
      MaterialMap inks(grid);
      for (std::size_t c = 0; c < inks.size(); ++c)
        inks.set(c, random.below(2) ? Material::kA : Material::kB);
      record.plans.push_back({t + 1000, layer, 1, 100 + layer, DropletPattern(grid, 1), inks});
      std::vector<replay::PassPart> parts;
      std::vector<std::vector<std::uint32_t>> cells;
      for (int s = 0; s < 4; ++s)
        for (const Material ink : {Material::kA, Material::kB}) {
          std::vector<std::uint32_t> mine;
          for (const std::uint32_t c : firing_order(DropletPattern(grid, 1), 0))
            if (sub_pattern_of(int(c) % grid.nx, int(c) / grid.nx, 4) == s && inks.of(c) == ink)
              mine.push_back(c);
          if (mine.empty()) continue;
          parts.push_back({layer, 0, int(parts.size()), 0, 0, s, 4, ink});
          cells.push_back(mine);
        }
      for (std::size_t n = 0; n < parts.size(); ++n) {
        parts[n].passes = int(parts.size());
        const Material ink = parts[n].material;
        if (n > 0 && parts[n].sub_pattern != parts[n - 1].sub_pattern) ++cures;
        t += kSecond;
        record.leases.push_back({t - 2000, t + kSecond});
        world.jet.push_back({t - 1000, true, ink});
        record.orders.push_back({t, layer, 0, int(n), grid, cells[n]});
        for (const std::uint32_t c : cells[n]) {
          t += 1000;
          world.shots.push_back(
              {t, std::int32_t(c) % grid.nx, std::int32_t(c) / grid.nx, cures, Shot::Outcome::kFired, ink});
        }
        world.jet.push_back({t + 500, false, ink});
        const std::int64_t all = std::int64_t(cells[n].size());
        record.reports.push_back({t + 1000, layer, 0, int(n), 100 + layer, all, all});
        record.parts.push_back(parts[n]);
      }
      ++cures;
      t += kSecond;
    }
    record.maps.push_back({t, 2, 103, t - 1000});
  }
};

TEST_CASE(
    "a layer of two inks in four sub-patterns is clean, and each way in which it can go wrong is found") {
  const Interlaced right;
  const AuditVerdict v = right.verdict();
  INFO(to_text(v));
  REQUIRE(v.clean());
  CHECK(v.commanded == 40);

  Interlaced ink;  // the other jet fired
  ink.world.shots[3].ink = ink.world.shots[3].ink == Material::kA ? Material::kB : Material::kA;
  CHECK(found(ink.verdict(), ViolationKind::kWrongInk));

  Interlaced wet;  // the first cure did not come
  for (Shot& s : wet.world.shots) s.exposures -= s.exposures > 0;
  CHECK(found(wet.verdict(), ViolationKind::kWetNeighbour));

  Interlaced both;  // the first jet stayed armed
  std::erase_if(both.world.jet, [&](const auto& s) { return &s == &both.world.jet[1]; });
  CHECK(found(both.verdict(), ViolationKind::kBothArmed));

  Interlaced other;  // a pass of another sub-pattern than it says
  other.record.parts[0].sub_pattern = 1;
  CHECK(found(other.verdict(), ViolationKind::kOtherCells));

  Interlaced gone;  // the last pass of the first layer left out
  const auto last = [&](const auto& x) { return x.layer == 1 && x.pass == gone.record.parts[0].passes - 1; };
  std::size_t from = 0, n = 0;
  for (const auto& o : gone.record.orders) {
    if (last(o)) n = o.cells.size();
    if (n == 0) from += o.cells.size();
  }
  gone.world.shots.erase(gone.world.shots.begin() + std::ptrdiff_t(from),
                         gone.world.shots.begin() + std::ptrdiff_t(from + n));
  std::erase_if(gone.record.orders, last);
  std::erase_if(gone.record.reports, last);
  CHECK(found(gone.verdict(), ViolationKind::kSkippedPass));
}

TEST_CASE("damage of the records is a violation") {
  Print p;
  p.world.damaged = 1;
  CHECK(found(p.verdict(), ViolationKind::kDamaged));
  Print q;
  q.record.damage = {"nodes/jet.wal, byte 12: checksum does not hold"};
  CHECK(found(q.verdict(), ViolationKind::kDamaged));
}

}  // namespace
}  // namespace firn::test
