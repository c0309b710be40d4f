#include "tests/bench/promise_rows.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "files/json.h"

namespace firn::tune {
namespace {

struct Sums {
  int labs = 0, unfinished = 0, refused = 0, kept = 0, advised = 0, covered = 0, harmed = 0;
  double gained = 0.0, possible = 0.0, cpu_s = 0.0;
  double gained_um = 0.0, possible_um = 0.0;

  void add(const PromiseRow& r) {
    ++labs;
    if (r.answer == "unfinished") {
      ++unfinished;
      return;
    }
    cpu_s += r.cpu_s;
    if (r.answer == "refused") {
      ++refused;
      return;
    }
    covered += r.covered();
    const bool gainful = r.kind != "optimal";
    if (gainful) {
      possible += std::max(0.0, r.oracle) / r.before;
      possible_um += std::max(0.0, r.oracle);
    }
    if (r.answer == "kept") {
      ++kept;
      return;
    }
    ++advised;
    if (gainful) {
      gained += r.printed / r.before;
      gained_um += r.printed;
    }
    harmed += r.printed < -kHarm * r.before || r.stopped_more > 0;
  }
};

std::string share(int part, int all) {
  return all ? fmt::format("{}/{} {:.0f} %", part, all, 100.0 * part / all) : "-";
}

std::string percent_of(double part, double all) {
  return all > 0.0 ? fmt::format("{:.0f} %", 100.0 * part / all) : "-";
}

std::string line(const std::string& name, const Sums& s) {
  const int printed = s.labs - s.unfinished, answered = s.kept + s.advised;
  return fmt::format("{:<15} {:>5} {:>14} {:>14} {:>14} {:>15} {:>13} {:>7} {:>7} {:>8.1f}\n", name, printed,
                     share(s.refused, printed), share(s.kept, answered), share(s.advised, answered),
                     share(s.covered, answered), share(s.harmed, s.advised), percent_of(s.gained, s.possible),
                     percent_of(s.gained_um, s.possible_um), s.cpu_s / std::max(1, printed));
}

}  // namespace

bool known_class(const std::string& kind) {
  return kind != "thin-film" && kind != "dead-row" && kind != "tilted";
}

std::string row_text(const PromiseRow& r) {
  return nlohmann::json{{"kind", r.kind},
                        {"lab", r.lab},
                        {"keys", r.keys},
                        {"answer", r.answer},
                        {"feature", r.feature},
                        {"before_um", r.before},
                        {"promised_um", r.promised},
                        {"low_um", r.low},
                        {"high_um", r.high},
                        {"printed_um", r.printed},
                        {"oracle_um", r.oracle},
                        {"stopped_more", r.stopped_more},
                        {"cpu_s", r.cpu_s}}
      .dump();
}

PromiseRow row_of(const std::string& text) {
  const auto j = nlohmann::json::parse(text);
  const auto number = [&](const char* key) {
    return j.at(key).is_null() ? std::nan("") : j.at(key).get<double>();  // JSON has no word for no number
  };
  return {j.at("kind").get<std::string>(),
          j.at("lab").get<int>(),
          j.at("keys").get<std::string>(),
          j.at("answer").get<std::string>(),
          j.at("feature").get<std::string>(),
          number("before_um"),
          number("promised_um"),
          number("low_um"),
          number("high_um"),
          number("printed_um"),
          number("oracle_um"),
          j.at("stopped_more").get<int>(),
          number("cpu_s")};
}

std::string promise_table(std::span<const PromiseRow> rows) {
  std::string s = fmt::format("{:<15} {:>5} {:>14} {:>14} {:>14} {:>15} {:>13} {:>7} {:>7} {:>8}\n",
                              "laboratories", "logs", "refused", "nothing to gain", "advised",
                              "promise covers", "worse by 2 %", "gain", "in um", "CPU-s");
  std::vector<std::string> kinds;
  Sums known, foreign, all;
  for (const PromiseRow& r : rows) {
    if (std::ranges::find(kinds, r.kind) == kinds.end()) kinds.push_back(r.kind);
    (known_class(r.kind) ? known : foreign).add(r);
    all.add(r);
  }
  for (const std::string& k : kinds) {
    Sums of_kind;
    for (const PromiseRow& r : rows)
      if (r.kind == k) of_kind.add(r);
    s += line(k, of_kind);
  }
  s += line("known classes", known) + line("other classes", foreign) + line("all", all);
  return s +
         "gain: mean of the printed gains in shares of the recorded setting's goal, 0 where it is kept,\n"
         "over the mean of the oracle's; in um: the same of the gains themselves, most of which are the\n"
         "roughest laboratories'\n";
}

}  // namespace firn::tune
