#include "studies/identify/identify_runs.h"

#include <stdexcept>

#include "core/statistics/leave_one_out.h"
#include "files/usage_error.h"
#include "studies/identify/identify_beads.h"

namespace firn {
namespace {

constexpr const char* kTwo = "leaving one run out needs two runs at least";

void leave_out(PooledConstant& c) { c.half_width = statistics::leave_one_out(c.without).half_width; }

}  // namespace

PooledIdentification pool(const std::vector<std::vector<bead::Bead>>& runs,
                          const std::vector<std::string>& names) {
  if (runs.size() < 2) throw UsageError(kTwo);
  const auto all_but = [&](std::size_t left_out) {
    std::vector<bead::Bead> beads;
    for (std::size_t n = 0; n < runs.size(); ++n) {
      if (n == left_out) continue;
      const int below = beads.empty() ? 0 : beads.back().layer + 1;  // a layer of another run is no neighbour
      for (bead::Bead b : runs[n]) {
        b.layer += below;
        beads.push_back(b);
      }
    }
    return beads;
  };
  PooledIdentification p;
  p.constants = {{"a"}, {"b"}};
  for (std::size_t n = 0; n < runs.size(); ++n) try {
      if (const std::string why = identify_beads(runs[n]).uninformative; !why.empty()) {
        p.uninformative = names[n] + ": " + why;
        return p;
      }
    } catch (const std::invalid_argument& error) {
      throw UsageError(names[n] + ": " + error.what());
    }
  const bead::BeadLaw law = bead::fit_bead_law(all_but(runs.size())).law;
  p.constants[0].value = law.a;
  p.constants[1].value = law.b;
  for (std::size_t n = 0; n < runs.size(); ++n) {
    const bead::BeadLaw others = bead::fit_bead_law(all_but(n)).law;
    p.constants[0].without.push_back(others.a);
    p.constants[1].without.push_back(others.b);
  }
  for (PooledConstant& c : p.constants) leave_out(c);
  return p;
}

PooledIdentification pool(const std::vector<Identification>& runs, const std::vector<std::string>& names) {
  if (runs.size() < 2) throw UsageError(kTwo);
  PooledIdentification p;
  for (std::size_t n = 0; n < runs.size(); ++n)
    if (!runs[n].uninformative.empty()) {
      p.uninformative = names[n] + ": " + runs[n].uninformative;
      return p;
    }
  const auto add = [&](const char* name, const Known Identification::*value, int constant) {
    PooledConstant c{name, true};
    for (const Identification& id : runs) c.value += (id.*value).mean_mm / double(runs.size());
    for (std::size_t n = 0; n < runs.size(); ++n) {
      const double own = (runs[n].*value).mean_mm, all = double(runs.size());
      c.without.push_back((all * c.value - own) / (all - 1.0));
      if (constant >= 0 && !runs[n].not_found[std::size_t(constant)].empty())
        c.runs_without_it.push_back(names[n]);
    }
    leave_out(c);
    p.constants.push_back(c);
  };
  add("h1", &Identification::h1, 0);
  add("h2", &Identification::h2, 1);
  add("h3", &Identification::h3, 2);
  add("h1 + 4 h2 + 4 h3", &Identification::layer_height, -1);
  return p;
}

}  // namespace firn
