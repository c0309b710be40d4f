#include "tests/bench/promise_rows.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace firn::tune {
namespace {

constexpr std::size_t kColumns = 13;

// Named so that no comma is in it.
std::string plain(std::string text) {
  for (char& c : text)
    if (c == ',' || c == '\n') c = ';';
  return text;
}

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

std::vector<PromiseRow> read_rows(const std::filesystem::path& file) {
  std::vector<PromiseRow> rows;
  std::ifstream in(file);
  for (std::string text; std::getline(in, text);) {
    std::vector<std::string> part;
    std::istringstream words(text);
    for (std::string word; std::getline(words, word, ',');) part.push_back(word);
    if (part.size() != kColumns || part[0] == "kind") continue;
    const auto number = [&](std::size_t n) { return std::strtod(part[n].c_str(), nullptr); };
    rows.push_back({part[0], int(number(1)), part[2], part[3], part[4], number(5), number(6), number(7),
                    number(8), number(9), number(10), int(number(11)), number(12)});
  }
  return rows;
}

void append_row(const std::filesystem::path& file, const PromiseRow& r) {
  const bool fresh = !std::filesystem::exists(file);
  std::ofstream out(file, std::ios::app);
  if (fresh)
    out << "kind,lab,keys,answer,feature,before_um,promised_um,low_um,high_um,printed_um,oracle_um,stopped,"
           "cpu_"
           "s\n";
  // An empty last word would be lost in reading.
  out << fmt::format("{},{},{},{},{},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{},{:.2f}\n", r.kind, r.lab,
                     plain(r.keys), r.answer, plain(r.feature), r.before, r.promised, r.low, r.high,
                     r.printed, r.oracle, r.stopped_more, r.cpu_s);
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
