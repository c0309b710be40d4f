#include "cli/study_state.h"

#include <fmt/core.h>

#include <cmath>
#include <optional>
#include <vector>

#include "core/options/for_people.h"
#include "files/json.h"
#include "studies/compare/study_shards.h"

namespace firn {
namespace {

constexpr double kShard_s = 60.0;  // of processor time: below, a cluster's own second a task shows
constexpr double kSecondsAnHour = 3600.0;
constexpr double kLineBytes = 1200.0;  // of a journal, with the metrics of one print

struct ClassState {
  std::size_t prints = 0, on_record = 0, failed = 0;
  double cpu_s = 0.0;  // of those on record
  std::size_t to_do() const { return prints - on_record; }
};

struct State {
  std::vector<ClassState> arms;
  ClassState all;
  std::optional<double> left_s;  // none: a scheme that has prints to do has none on record
};

State state_of(const StudyPlan& plan, const StudyJournal& journal, const StudyShard& shard) {
  State s{std::vector<ClassState>(plan.study.arms.size()), {}, 0.0};
  for (const StudyCell* c : cells_of(plan, shard)) {
    const StudyPrint* print = journal.find(c->digest);
    for (ClassState* of : {&s.arms[c->arm], &s.all}) {
      ++of->prints;
      of->on_record += print != nullptr;
      of->failed += print && !print->finished;
      of->cpu_s += print ? print->cpu_s : 0.0;
    }
  }
  for (const ClassState& arm : s.arms) {
    if (arm.to_do() == 0) continue;
    if (arm.on_record == 0) {
      s.left_s.reset();
      return s;
    }
    *s.left_s += double(arm.to_do()) * arm.cpu_s / double(arm.on_record);
  }
  return s;
}

int shards_of(double left_s) { return int(std::ceil(left_s / kShard_s)); }

}  // namespace

std::optional<double> seconds_left(const StudyPlan& plan, const StudyJournal& journal,
                                   const StudyShard& shard) {
  return state_of(plan, journal, shard).left_s;
}

std::string study_state_text(const StudyPlan& plan, const StudyJournal& journal, const StudyShard& shard) {
  const State s = state_of(plan, journal, shard);
  std::string text =
      fmt::format("{}: {} of {} on record, {} stopped before the end\n", plan.study.name,
                  grouped(s.all.on_record), counted(s.all.prints, "print"), grouped(s.all.failed));
  for (std::size_t a = 0; a < s.arms.size(); ++a) {
    const ClassState& arm = s.arms[a];
    text += fmt::format("  {:<24} {:>9} of {:<9} {:>7} stopped", plan.study.arms[a].name,
                        grouped(arm.on_record), grouped(arm.prints), grouped(arm.failed));
    if (arm.on_record > 0)
      text += fmt::format("  {:>8} s of processor time each", for_people(arm.cpu_s / double(arm.on_record)));
    text += "\n";
  }
  if (s.all.to_do() == 0) return text;
  text += fmt::format("to do: {}, {} kB of journal", counted(s.all.to_do(), "print"),
                      for_people(std::ceil(double(s.all.to_do()) * kLineBytes / 1e3)));
  if (s.left_s)
    text +=
        fmt::format(", {} hours of processor time, {} of a minute", for_people(*s.left_s / kSecondsAnHour),
                    counted(std::uint64_t(shards_of(*s.left_s)), "shard"));
  else
    text += "; hours are not known before each scheme has printed once (--max)";
  return text + "\n";
}

std::string study_state_json(const StudyPlan& plan, const StudyJournal& journal, const StudyShard& shard) {
  using Json = nlohmann::ordered_json;
  const State s = state_of(plan, journal, shard);
  Json schemes = Json::array();
  for (std::size_t a = 0; a < s.arms.size(); ++a) {
    const ClassState& arm = s.arms[a];
    schemes.push_back(
        {{"name", plan.study.arms[a].name},
         {"prints", arm.prints},
         {"on_record", arm.on_record},
         {"failed", arm.failed},
         {"cpu_s_each", arm.on_record > 0 ? Json(arm.cpu_s / double(arm.on_record)) : Json(nullptr)}});
  }
  const Json state{{"study", plan.study.name},
                   {"prints", s.all.prints},
                   {"on_record", s.all.on_record},
                   {"failed", s.all.failed},
                   {"to_do", s.all.to_do()},
                   {"damaged_lines", journal.damaged()},
                   {"of_other_builds", journal.of_other_builds()},
                   {"of_other_platforms", journal.of_other_platforms()},
                   {"hours", s.left_s ? Json(*s.left_s / kSecondsAnHour) : Json(nullptr)},
                   {"bytes", double(s.all.to_do()) * kLineBytes},
                   {"shards_of_60_s", s.left_s ? Json(shards_of(*s.left_s)) : Json(nullptr)},
                   {"schemes", schemes}};
  return state.dump(2) + "\n";
}

}  // namespace firn
