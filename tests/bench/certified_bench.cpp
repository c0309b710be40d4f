// Motion planning: points per second, the Lucy-sized job, and the limits on many random paths.
//
// - `certified_bench speed [kind]`: one table: kinds of path, points per second of one core, T / lower bound
// - `certified_bench lucy [threads]`: 48,000 paths, streamed: time, points per second, growth of memory
// - `certified_bench winding N [ramped|optimal|MM]`: one path of N points 0.1 mm apart, as `firn plan` plans
// it: times per point, memory; ramped alone, by the slow tier, within a tolerance
// - `certified_bench random N [seed]`: the nine ratios on N random paths, by samples 32 times finer than the
// tick
// - `certified_bench tiers N [seed]`: duration of the fast tier over that of the slow one, by corner radius
// and by kind
// - `certified_bench job N FILE.csv|FILE.json`: the first N paths of that job in a file, for `firn plan FILE
// --origin 380,0`
// - `certified_bench job PATHS FILE.csv`: the paths of a sliced or drawn job, for drive_times
//
// Times per core are user CPU seconds of this process.
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "core/grid/random.h"
#include "core/motion/planner.h"
#include "core/motion/thesis/test_path.h"
#include "files/path/path_file.h"
#include "tests/bench/bench.h"
#include "tests/core/motion/random_paths.h"
#include "tests/core/motion/winding_path.h"

namespace firn::bench::certified_bench {

namespace {

using namespace firn;
using namespace firn::motion;

double user_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_utime.tv_sec) + 1e-6 * double(usage.ru_utime.tv_usec);
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

constexpr Point2 kPart{380.0, 0.0};

/// Outline of a cross-section of a figure: a closed curve with features down to a few millimetres, points
/// every 0.4 mm.
std::vector<Point2> outline(std::uint64_t seed, double radius, double roughness) {
  RandomStream draw(seed, Purpose::kTest);
  double amplitude[12], phase[12];
  for (int k = 0; k < 12; ++k) {
    amplitude[k] = radius * roughness * draw.uniform(0.2, 1.0) / ((k + 2) * (k + 2));
    phase[k] = draw.uniform(0.0, 6.28318530717958648);
  }
  const auto at = [&](double angle) {
    double r = radius;
    for (int k = 0; k < 12; ++k) r += amplitude[k] * std::cos((k + 2) * angle + phase[k]);
    return Point2{r * std::cos(angle), r * std::sin(angle)};
  };
  std::vector<Point2> points{at(0.0)};
  double angle = 0.0;
  while (angle < 6.28318530717958648) {
    const Point2 here = at(angle), ahead = at(angle + 1e-4);
    const double speed = std::hypot(ahead.x_mm - here.x_mm, ahead.y_mm - here.y_mm) / 1e-4;
    angle += 0.4 / speed;
    points.push_back(at(angle));
  }
  return points;
}

std::vector<Point2> fill_line(std::uint64_t seed) {
  RandomStream draw(seed, Purpose::kTest);
  const double length = draw.uniform(20.0, 200.0), angle = draw.uniform(-1.5, 1.5);
  const int n = int(length / 0.4);
  std::vector<Point2> points;
  for (int i = 0; i <= n; ++i) {
    const double s = length * (double(i) / n - 0.5);
    points.push_back({s * std::cos(angle), s * std::sin(angle)});
  }
  return points;
}

/// Rounded rectangles: lines and arcs. @param spacing_mm at most a sixth of an arc of the least radius
std::vector<Point2> rounded_box(std::uint64_t seed, double min_radius = 1.0, double max_radius = 8.0,
                                double spacing_mm = 0.4) {
  RandomStream draw(seed, Purpose::kTest);
  const double a = draw.uniform(10.0, 40.0), b = draw.uniform(10.0, 40.0);
  std::vector<Point2> points{{0.0, -b}};
  double heading = 0.0;
  const auto go = [&](double length, double radius) {
    const int n = std::max(1, int(std::lround(length / spacing_mm)));
    for (int i = 0; i < n; ++i) {
      const double turn = radius > 0.0 ? length / n / radius : 0.0;
      const double chord = radius > 0.0 ? 2.0 * radius * std::sin(0.5 * turn) : length / n;
      const Point2 p = points.back();
      points.push_back(
          {p.x_mm + chord * std::cos(heading + 0.5 * turn), p.y_mm + chord * std::sin(heading + 0.5 * turn)});
      heading += turn;
    }
  };
  for (int corner = 0; corner < 4; ++corner) {
    const double radius = draw.uniform(min_radius, max_radius);
    go((corner % 2 ? b : a) * 1.5 - radius, 0.0);
    go(radius * 1.5707963267948966, radius);
  }
  return points;
}

/// Path k of a job like the thesis's Lucy (48,000 paths, 14 million points): outlines and fill of many
/// layers.
std::vector<Point2> job_path(std::uint64_t k) {
  const std::uint64_t seed = 1000 + k;
  switch (k % 4) {
    case 0:
      return outline(seed, 8.0 + double(k % 14), 0.5);
    case 1:
      return fill_line(seed);
    case 2:
      return rounded_box(seed);
    default:
      return outline(seed, 13.0 + double(k % 17), 0.15);
  }
}

constexpr std::uint64_t kDifferent = 960;  ///< paths, each used 50 times in a whole job

struct Tally {
  std::size_t paths = 0, points = 0, refused = 0;
  double motion_s = 0.0, bound_s = 0.0, worst = 0.0;
  void add(std::size_t count, const PlanResult& result) {
    ++paths;
    points += count;
    if (!result.ok()) {
      ++refused;
      return;
    }
    motion_s += result.continuous_s;
    bound_s += result.trajectory.certificate.lower_bound_s;
    for (const LimitRatio& limit : result.trajectory.certificate.limits) worst = std::max(worst, limit.ratio);
  }
};

int speed(const std::string& only) {
  const auto arm = make_scara(cobra600());
  // 160 mm further out the arm is nearly stretched: there both joints limit the motion
  constexpr Point2 kFarPart{540.0, 0.0};
  const auto far = [&](std::vector<Point2> points) {
    for (Point2& p : points) p = {p.x_mm + kFarPart.x_mm - kPart.x_mm, p.y_mm};
    return points;
  };
  const std::pair<const char*, std::function<std::vector<Point2>(std::uint64_t)>> kinds[] = {
      {"test path of Fig. 4-2",
       [](std::uint64_t) {
         auto points = thesis::fig_4_2();
         for (Point2& p : points) p = {p.x_mm - 26.0, p.y_mm - 46.0};
         return points;
       }},
      {"straight fill", fill_line},
      {"rounded boxes", [](std::uint64_t k) { return rounded_box(k); }},
      {"smooth outlines", [](std::uint64_t k) { return outline(k, 20.0, 0.15); }},
      {"rough outlines", [](std::uint64_t k) { return outline(k, 20.0, 0.5); }},
      {"the job's mixture", job_path},
      {"rough outlines, far out", [&](std::uint64_t k) { return far(outline(k, 20.0, 0.5)); }}};
  std::printf("%-24s %9s %12s %14s %12s %8s\n", "paths (0.4 mm spacing)", "points", "user s", "points/s",
              "T / bound", "ratio");
  for (const auto& [text, make] : kinds) {
    if (std::string(text).find(only) == std::string::npos) continue;
    PlanWorkspace work;
    Tally tally;
    double spent = 0.0;
    std::vector<std::vector<Point2>> made;  // making them takes longer than planning them
    for (std::uint64_t k = 0; k < 256; ++k) made.push_back(make(k));
    while (spent < 1.0) {
      const double start = user_seconds();
      for (const auto& points : made) {
        PathInput input;
        input.points = points;
        input.origin = kPart;
        tally.add(points.size(), plan(input, *arm, cobra600_limits(), {}, work));
      }
      spent += user_seconds() - start;
    }
    std::printf("%-24s %9zu %12.3f %14.0f %12.4f %8.5f%s\n", text, tally.points, spent,
                double(tally.points) / spent, tally.motion_s / tally.bound_s, tally.worst,
                tally.refused ? "  (some refused)" : "");
  }
  return 0;
}

int lucy(int threads) {
  constexpr std::uint64_t paths = 48000;
  // making the paths is not planning: so many different ones are made first and used 50 times each
  std::vector<std::vector<Point2>> made;
  for (std::uint64_t k = 0; k < kDifferent; ++k) made.push_back(job_path(k));
  const auto arm = make_scara(cobra600());
  std::atomic<std::uint64_t> next{0};
  std::vector<Tally> tallies(static_cast<std::size_t>(threads));
  rusage before{};
  getrusage(RUSAGE_SELF, &before);
  const double user = user_seconds(), wall = wall_seconds();
  std::vector<std::thread> pool;
  for (int t = 0; t < threads; ++t)
    pool.emplace_back([&, t] {
      PlanWorkspace work;
      for (std::uint64_t k; (k = next++) < paths;) {
        PathInput input;
        input.points = made[k % kDifferent];
        input.origin = kPart;
        tallies[std::size_t(t)].add(input.points.size(), plan(input, *arm, cobra600_limits(), {}, work));
      }
    });
  for (std::thread& thread : pool) thread.join();
  const double wall_s = wall_seconds() - wall, user_s = user_seconds() - user;
  rusage after{};
  getrusage(RUSAGE_SELF, &after);
  Tally all;
  for (const Tally& t : tallies) {
    all.paths += t.paths;
    all.points += t.points;
    all.refused += t.refused;
    all.motion_s += t.motion_s;
    all.bound_s += t.bound_s;
    all.worst = std::max(all.worst, t.worst);
  }
  std::printf("paths %zu, points %zu, threads %d\n", all.paths, all.points, threads);
  std::printf("user %.2f s, wall %.2f s, %.0f points per user second\n", user_s, wall_s,
              double(all.points) / user_s);
  std::printf("machine time planned %.1f h, T / lower bound %.4f, largest ratio %.5f, refused %zu\n",
              all.motion_s / 3600.0, all.motion_s / all.bound_s, all.worst, all.refused);
  std::printf("memory grown while planning: %.1f MB\n", double(after.ru_maxrss - before.ru_maxrss) / 1024.0);
  return 0;
}

int write_job(std::uint64_t paths, const std::string& file) {
  std::FILE* out = std::fopen(file.c_str(), "w");
  if (!out) {
    std::perror(file.c_str());
    return 1;
  }
  const bool json = file.ends_with(".json");
  std::fputs(json ? "{\"version\": 1, \"paths\": [" : "x_mm,y_mm\n", out);
  std::size_t points = 0;
  for (std::uint64_t k = 0; k < paths; ++k) {
    const std::vector<Point2> path = job_path(k % kDifferent);
    points += path.size();
    if (json) std::fputs(k == 0 ? "\n{\"points\": [" : ",\n{\"points\": [", out);
    for (std::size_t i = 0; i < path.size(); ++i)
      if (json)
        std::fprintf(out, "%s[%.6f, %.6f]", i ? ", " : "", path[i].x_mm, path[i].y_mm);
      else
        std::fprintf(out, "%.6f,%.6f\n", path[i].x_mm, path[i].y_mm);
    std::fputs(json ? "]}" : "\n", out);
  }
  if (json) std::fputs("\n]}\n", out);
  const bool good = std::fclose(out) == 0;
  std::printf("%llu paths, %zu points\n", static_cast<unsigned long long>(paths), points);
  return good ? 0 : 1;
}

/// The paths of any file that `firn plan` reads, closed ones with their first point again.
int convert_job(const char* from, const char* to) {
  std::FILE* out = std::fopen(to, "w");
  if (!out) {
    std::perror(to);
    return 1;
  }
  std::fputs("x_mm,y_mm\n", out);
  std::size_t paths = 0, points = 0;
  read_paths(from, [&](InputPath&& path) {
    std::vector<Point2>& p = path.path.points;
    if (path.path.closed) p.push_back(p.front());
    for (const Point2& q : p) std::fprintf(out, "%.17g,%.17g\n", q.x_mm, q.y_mm);
    std::fputs("\n", out);
    ++paths;
    points += p.size();
  });
  const bool good = std::fclose(out) == 0;
  std::printf("%zu paths, %zu points\n", paths, points);
  return good ? 0 : 1;
}

int random_paths(int count, std::uint64_t seed) {
  const auto arm = make_scara(cobra600());
  RandomPathMaker maker(seed);
  PlanWorkspace work;
  PlanOptions options;
  options.tick_s = 0.0005;
  struct Kind {
    int paths = 0, refused = 0;
    double worst = 0.0;
  };
  std::map<std::string, Kind> kinds;
  std::map<std::string, int> reasons;
  double worst = 0.0, motion_s = 0.0;
  int worst_path = -1;
  for (int k = 0; k < count; ++k) {
    const RandomPath path = maker.next();
    PathInput input;
    input.points = path.points;
    const PlanResult result = plan(input, *arm, cobra600_limits(), options, work);
    Kind& kind = kinds[path.kind];
    ++kind.paths;
    if (!result.ok()) {
      ++kind.refused;
      ++reasons[name(result.fault->reason)];
      continue;
    }
    motion_s += result.continuous_s;
    for (const LimitRatio& limit : result.trajectory.certificate.limits) {
      kind.worst = std::max(kind.worst, limit.ratio);
      if (limit.ratio > worst) {
        worst = limit.ratio;
        worst_path = k;
      }
    }
  }
  for (const auto& [text, kind] : kinds)
    std::printf("%-22s %7d paths, %6d refused, largest ratio %.6f\n", text.c_str(), kind.paths, kind.refused,
                kind.worst);
  for (const auto& [reason, n] : reasons) std::printf("refused: %s %d\n", reason.c_str(), n);
  std::printf("motion planned: %.3f s\n", motion_s);
  std::printf("largest ratio of all %.6f (path %d): %s\n", worst, worst_path,
              worst <= 1.001 ? "within 1.001" : "ABOVE 1.001");
  return worst <= 1.001 ? 0 : 1;
}

int winding_path(std::size_t count, const std::string& how) {
  const auto arm = make_scara(cobra600());
  PathInput input;
  const std::vector<Point2> points = winding(count);
  input.points = points;
  PlanOptions options;
  options.point_noise_mm = 5e-5;
  options.point_rule = how == "ramped" ? PointRule::kRamped : PointRule::kFaster;
  if (how == "optimal") options.method = Method::kOptimal;
  options.tolerance_mm = std::atof(how.c_str());
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  const double start = user_seconds();
  const PlanResult result = plan(input, *arm, cobra600_limits(), options);
  const double user_s = user_seconds() - start;
  getrusage(RUSAGE_SELF, &after);
  std::printf(
      "%zu points: user %.2f s, %.1f us per point, memory %.2f kB per point, T %.3f s, T / bound %.4f\n",
      count, user_s, 1e6 * user_s / double(count), double(after.ru_maxrss - before.ru_maxrss) / double(count),
      result.continuous_s, result.continuous_s / result.trajectory.certificate.lower_bound_s);
  return result.ok() ? 0 : 1;
}

/// Measures the excess duration of the fast tier's motions over those of the slow tier.
int tiers(int count, std::uint64_t seed) {
  const auto arm = make_scara(cobra600());
  PlanWorkspace work;
  std::map<std::string, std::vector<double>> longer;
  const auto compare = [&](const std::string& kind, const std::vector<Point2>& points, Point2 origin) {
    PathInput input;
    input.points = points;
    input.origin = origin;
    PlanOptions slow;
    slow.method = Method::kOptimal;
    const PlanResult a = plan(input, *arm, cobra600_limits(), {}, work),
                     b = plan(input, *arm, cobra600_limits(), slow, work);
    if (a.ok() && b.ok()) longer[kind].push_back(a.continuous_s / b.continuous_s);
  };
  for (const double radius : {0.25, 0.5, 1.0, 2.0, 4.0, 8.0})
    for (int k = 0; k < count; ++k) {
      char text[64];
      std::snprintf(text, sizeof text, "boxes, radius %4.2f mm", radius);
      compare(text, rounded_box(seed + std::uint64_t(k), radius, radius, std::min(0.4, 0.25 * radius)),
              kPart);
    }
  RandomPathMaker maker(seed);
  for (int k = 0; k < 8 * count; ++k) {
    const RandomPath path = maker.next();
    compare(std::string("random, ") + path.kind, path.points, {});
  }
  std::printf("%-28s %6s %8s %8s %8s\n", "T fast / T slow", "paths", "mean", "95 %", "most");
  for (auto& [kind, ratio] : longer) {
    std::sort(ratio.begin(), ratio.end());
    double sum = 0.0;
    for (const double x : ratio) sum += x;
    std::printf("%-28s %6zu %8.4f %8.4f %8.4f\n", kind.c_str(), ratio.size(), sum / double(ratio.size()),
                ratio[(ratio.size() - 1) * 95 / 100], ratio.back());
  }
  return 0;
}

}  // namespace

FIRN_BENCH(certified_bench) {
  const std::string what = argc > 1 ? argv[1] : "speed";
  if (what == "speed") return speed(argc > 2 ? argv[2] : "");
  if (what == "lucy") return lucy(argc > 2 ? std::atoi(argv[2]) : 1);
  if (what == "tiers")
    return tiers(argc > 2 ? std::max(1, std::atoi(argv[2])) : 100,
                 argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
  if (what == "job" && argc == 4) {
    char* end = nullptr;
    const std::uint64_t paths = std::strtoull(argv[2], &end, 10);
    return *end == '\0' ? write_job(paths, argv[3]) : convert_job(argv[2], argv[3]);
  }
  if (what == "winding" && argc > 2)
    return winding_path(std::strtoull(argv[2], nullptr, 10), argc > 3 ? argv[3] : "");
  if (what == "random")
    return random_paths(argc > 2 ? std::atoi(argv[2]) : 100000,
                        argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
  std::fprintf(
      stderr,
      "usage: certified_bench speed [kind] | lucy [threads] | job N|PATHS FILE | winding N [HOW] | random N "
      "[seed] | tiers N [seed]\n");
  return 2;
}

}  // namespace firn::bench::certified_bench
