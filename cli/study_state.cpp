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

struct ClassState {
  std::size_t prints = 0, on_record = 0, failed = 0, stopped = 0;  ///< failed: the stopped ones too
  double cpu_s = 0.0;                                              ///< of those on record
  std::optional<double> left_s = {};  ///< of those to do; none: the time of one is not known
  std::size_t to_do() const { return prints - on_record; }
};

struct State {
  std::vector<ClassState> arms;
  ClassState all;
};

State state_of(const StudyWork& work, const StudyJournal& journal, const StudyShard& shard) {
  State s{std::vector<ClassState>(work.kinds.size()), {}};
  for (const StudyCell* c : cells_of(work, shard)) {
    const StudyPrint* print = journal.find(c->digest);
    for (ClassState* of : {&s.arms[c->arm], &s.all}) {
      ++of->prints;
      of->on_record += print != nullptr;
      of->failed += print && !print->within.value_or(print->finished);
      of->stopped += print && !print->finished;
      of->cpu_s += print ? print->cpu_s : 0.0;
    }
  }
  s.all.left_s = 0.0;
  for (std::size_t a = 0; a < s.arms.size(); ++a) {
    ClassState& arm = s.arms[a];
    if (arm.to_do() == 0)
      arm.left_s = 0.0;
    else if (arm.on_record > 0)
      arm.left_s = double(arm.to_do()) * arm.cpu_s / double(arm.on_record);
    else if (!work.seconds.empty())
      arm.left_s = double(arm.to_do()) * work.seconds[a];
    if (s.all.left_s && arm.left_s)
      *s.all.left_s += *arm.left_s;
    else
      s.all.left_s.reset();
  }
  return s;
}

int shards_of(double left_s) { return int(std::ceil(left_s / kShard_s)); }

}  // namespace

std::string damage_text(const StudyJournal::Damage& d) {
  return fmt::format("{}: {} torn or damaged, the first is line {}; what {} held is made anew",
                     d.file.string(), d.lines == 1 ? "1 line is" : std::to_string(d.lines) + " lines are",
                     d.first, d.lines == 1 ? "it" : "they");
}

std::optional<double> seconds_left(const StudyWork& work, const StudyJournal& journal,
                                   const StudyShard& shard) {
  return state_of(work, journal, shard).all.left_s;
}

std::string study_state_text(const StudyWork& work, const StudyJournal& journal, const StudyShard& shard) {
  const State s = state_of(work, journal, shard);
  std::string text = fmt::format("{}: {} of {} on record, {} failed, {} of these stopped before the end\n",
                                 work.name, grouped(s.all.on_record), counted(s.all.prints, work.noun),
                                 grouped(s.all.failed), grouped(s.all.stopped));
  for (std::size_t a = 0; a < s.arms.size(); ++a) {
    const ClassState& arm = s.arms[a];
    text +=
        fmt::format("  {:<24} {:>9} of {:<9} {:>7} failed {:>7} stopped", work.kinds[a],
                    grouped(arm.on_record), grouped(arm.prints), grouped(arm.failed), grouped(arm.stopped));
    if (arm.on_record > 0)
      text += fmt::format("  {:>8} s of processor time each", for_people(arm.cpu_s / double(arm.on_record)));
    if (arm.to_do() > 0 && arm.left_s)
      text += fmt::format("  {:>8} hours to do", for_people(*arm.left_s / kSecondsAnHour));
    text += "\n";
  }
  for (const StudyJournal::Damage& d : journal.damage()) text += damage_text(d) + "\n";
  if (s.all.to_do() == 0) return text;
  text += fmt::format("to do: {}, {} kB of journal", counted(s.all.to_do(), work.noun),
                      for_people(std::ceil(double(s.all.to_do()) * journal.line_bytes() / 1e3)));
  if (s.all.left_s)
    text += fmt::format(", {} hours of processor time, {} of a minute",
                        for_people(*s.all.left_s / kSecondsAnHour),
                        counted(std::uint64_t(shards_of(*s.all.left_s)), "shard"));
  else
    text += "; hours are not known before one of each is on record (--max)";
  return text + "\n";
}

std::string study_state_json(const StudyWork& work, const StudyJournal& journal, const StudyShard& shard) {
  using Json = nlohmann::ordered_json;
  const State s = state_of(work, journal, shard);
  Json schemes = Json::array();
  for (std::size_t a = 0; a < s.arms.size(); ++a) {
    const ClassState& arm = s.arms[a];
    schemes.push_back(
        {{"name", work.kinds[a]},
         {"prints", arm.prints},
         {"on_record", arm.on_record},
         {"failed", arm.failed},
         {"stopped", arm.stopped},
         {"hours", arm.left_s ? Json(*arm.left_s / kSecondsAnHour) : Json(nullptr)},
         {"cpu_s_each", arm.on_record > 0 ? Json(arm.cpu_s / double(arm.on_record)) : Json(nullptr)}});
  }
  Json damage = Json::array();
  for (const StudyJournal::Damage& d : journal.damage())
    damage.push_back({{"file", d.file.string()}, {"lines", d.lines}, {"first", d.first}});
  const Json state{{"study", work.name},
                   {"prints", s.all.prints},
                   {"on_record", s.all.on_record},
                   {"failed", s.all.failed},
                   {"stopped", s.all.stopped},
                   {"to_do", s.all.to_do()},
                   {"damaged_lines", journal.damaged()},
                   {"damage", damage},
                   {"of_other_builds", journal.of_other_builds()},
                   {"of_other_platforms", journal.of_other_platforms()},
                   {"hours", s.all.left_s ? Json(*s.all.left_s / kSecondsAnHour) : Json(nullptr)},
                   {"bytes", double(s.all.to_do()) * journal.line_bytes()},
                   {"shards_of_60_s", s.all.left_s ? Json(shards_of(*s.all.left_s)) : Json(nullptr)},
                   {"schemes", schemes}};
  return state.dump(2) + "\n";
}

}  // namespace firn
