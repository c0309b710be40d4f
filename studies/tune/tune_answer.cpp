#include "studies/tune/tune_answer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "files/json.h"

namespace firn::tune {
namespace {

using nlohmann::ordered_json;

std::string name_of_goal(const std::string& goal) {
  const std::string base = goal.ends_with("_um") ? goal.substr(0, goal.size() - 3) : goal;
  return base == "rms" ? "RMS" : base;
}

std::string unit_of_goal(const std::string& goal) { return goal.ends_with("_um") ? " um" : ""; }

// "ki_star 0.25 -> 0.02, kp stays 1"
std::string change_of(const TuneAnswer& a) {
  std::string s;
  for (std::size_t k = 0; k < a.keys.size(); ++k) {
    const std::string& key = a.keys[k].key();
    const std::string before = a.keys[k].text(a.advice->old_setting[k]),
                      after = a.keys[k].text(a.advice->new_setting[k]);
    s += fmt::format("{}{} {} {}", k ? ", " : "", key.substr(key.rfind('.') + 1),
                     before == after ? "stays" : before + " ->", after);
  }
  return s;
}

std::string source_of(const Promise& p) {
  if (p.mean_error_share > 0.6) return "mostly from a smaller mean error";
  if (p.mean_error_share < 0.4) return "mostly from less roughness";
  return "from mean error and roughness alike";
}

std::string missed_of(const FitCheck& c) {
  std::string s;
  for (std::size_t n = 0; n < std::min<std::size_t>(c.missed.size(), 3); ++n)
    s +=
        fmt::format("{}{} ({})", n ? "; " : "", c.missed[n].feature,
                    c.missed[n].constant ? "the same in every simulated print, another in the run"
                                         : fmt::format("{:+.1f} standard deviations", c.missed[n].deviation));
  return s;
}

ordered_json json_of(const statistics::Interval& i) { return {i.low, i.high}; }

ordered_json settings_json(const TuneAnswer& a) {
  ordered_json rows = ordered_json::array();
  for (std::size_t k = 0; k < a.keys.size(); ++k)
    rows.push_back({{"key", a.keys[k].key()},
                    {"recorded", a.keys[k].text(a.advice->old_setting[k])},
                    {"tuned", a.keys[k].text(a.advice->new_setting[k])}});
  return rows;
}

ordered_json advice_json(const TuneAnswer& a) {
  const Advice& d = *a.advice;
  const Promise& p = d.promise;
  ordered_json j{{"gain_shown", d.gain_shown},
                 {"keys", settings_json(a)},
                 {"goal", a.goal},
                 {"prints_promised", a.promised_prints},
                 {"old", p.old_mean},
                 {"new", p.new_mean},
                 {"new_interval", json_of(p.new_interval)},
                 {"gain", p.gain},
                 {"gain_interval", json_of(p.gain_interval)},
                 {"sure", p.sure},
                 {"prints", p.prints},
                 {"sure_of_prints", p.sure_of_prints},
                 {"mean_error_share", p.mean_error_share},
                 {"evaluations", d.evaluations},
                 {"prints", d.prints}};
  j["left_out"] = ordered_json::array();
  for (const Rejected& r : d.rejected)
    j["left_out"].push_back({{"setting", r.setting}, {"reason", r.reason}});
  j["sensitivity"] = ordered_json::array();
  for (const Profile& f : d.profiles)
    j["sensitivity"].push_back({{"key", a.keys[f.key].key()},
                                {"within_2_percent", {f.flat_low, f.flat_high}},
                                {"value", f.value},
                                {"mean", f.mean}});
  return j;
}

ordered_json verification_json(const Verification& v) {
  return {
      {"held", v.held},        {"pairs", v.pairs.pairs},       {"old", v.pairs.mean_a},
      {"new", v.pairs.mean_b}, {"gain", v.pairs.difference},   {"gain_interval", json_of(v.pairs.interval)},
      {"p", v.pairs.p},        {"stopped_old", v.stopped_old}, {"stopped_new", v.stopped_new}};
}

std::string verification_text(const TuneAnswer& a) {
  const Verification& v = *a.verification;
  if (v.stopped_old + v.stopped_new > 0 && v.pairs.pairs == 0)
    return fmt::format(
        "verified: {} prints with the old and {} with the new setting stopped: nothing to compare\n",
        v.stopped_old, v.stopped_new);
  const auto& promised = a.advice->promise.gain_interval;
  const bool more = v.stopped_new <= v.stopped_old && v.pairs.difference > promised.high;
  return fmt::format(
      "verified by {} pairs: {:.3f} -> {:.3f}, gain {:.3f} [{:.3f}, {:.3f}], p = {:.3f}; promised [{:.3f}, "
      "{:.3f}]: the promise {}\n",
      v.pairs.pairs, v.pairs.mean_a, v.pairs.mean_b, v.pairs.difference, v.pairs.interval.low,
      v.pairs.interval.high, v.pairs.p, promised.low, promised.high,
      v.held ? "held"
      : more ? "did not hold: more was gained"
             : "DID NOT HOLD");
}

}  // namespace

std::string tune_line(const TuneAnswer& a) {
  if (!a.advice)
    return "no advice: no known class of laboratory reproduces these logs; missed: " + missed_of(a.lab.check);
  const Promise& p = a.advice->promise;
  const std::string name = name_of_goal(a.goal), unit = unit_of_goal(a.goal);
  if (!a.advice->gain_shown)
    return fmt::format(
        "nothing to gain that these logs could show ({} {:.2f}{}; best found {}: gain {:.2f}{} [{:.2f}, "
        "{:.2f}])",
        name, p.old_mean, unit, change_of(a), p.gain, unit, p.gain_interval.low, p.gain_interval.high);
  return fmt::format(
      "{}: {} {:.2f} -> {:.2f}{} [{:.2f}, {:.2f}], gain {:.2f} [{:.2f}, {:.2f}]; {:.0f} % sure that it is "
      "better "
      "in the long run, {:.0f} % that the mean of {} prints is; {}",
      change_of(a), name, p.old_mean, p.new_mean, unit, p.new_interval.low, p.new_interval.high, p.gain,
      p.gain_interval.low, p.gain_interval.high, std::floor(100.0 * p.sure),
      std::floor(100.0 * p.sure_of_prints), p.prints, source_of(p));
}

std::string tune_text(const TuneAnswer& a) {
  std::string s = tune_line(a) + "\n";
  if (a.verification) s += verification_text(a);
  s += fmt::format("laboratory: {} (last third of the layers: ", a.lab.lab->meaning);
  for (std::size_t n = 0; n < a.lab.scores.size(); ++n)
    s += fmt::format("{}{} {:.1f}", n ? ", " : "", a.lab.scores[n].lab, a.lab.scores[n].log_predictive);
  s += fmt::format(
      "); largest deviation {:.1f} of {:.1f} allowed, of all features together {:.1f} of {:.1f}\n",
      a.lab.check.largest, a.lab.check.limit, a.lab.check.joint, a.lab.check.joint_limit);
  if (a.advice) {
    const Advice& d = *a.advice;
    s += fmt::format(
        "intervals: 95 %, of the mean of {} prints in laboratories of this class that fit the logs; an error "
        "of the "
        "class itself moves both absolute values alike, and is in neither interval\n",
        d.promise.prints);
    for (const Profile& f : d.profiles)
      s += fmt::format("within {:.0f} % of the optimum: {} from {} to {}\n", 100 * kFlat, a.keys[f.key].key(),
                       a.keys[f.key].text(f.flat_low), a.keys[f.key].text(f.flat_high));
    for (std::size_t k = 0; k < a.keys.size() && d.gain_shown; ++k)
      if (a.keys[k].at_open_end(d.new_setting[k]))
        s += fmt::format("{} = {} is an end of the range that was searched: a wider one may gain more\n",
                         a.keys[k].key(), a.keys[k].text(d.new_setting[k]));
    for (std::size_t n = 0; n < std::min<std::size_t>(d.rejected.size(), 3); ++n)
      s += "left out: " + d.rejected[n].setting + ": " + d.rejected[n].reason + "\n";
    if (d.rejected.size() > 3)
      s += fmt::format("left out: {} more settings (--json)\n", d.rejected.size() - 3);
  }
  for (const NextPrint& n : a.next) {
    s += fmt::format("next, would tell most: {} ({:.1f} nats; {} to {:.0f} % of its uncertainty){}\n", n.name,
                     n.information, n.narrows.empty() ? "no parameter" : n.narrows, 100 * n.narrows_to,
                     n.how.empty() ? "" : ": " + n.how);
    break;
  }
  return s;
}

std::string tune_json(const TuneAnswer& a) {
  ordered_json j{{"answer", tune_line(a)}};
  for (const RecordedRun& r : a.runs) j["runs"].push_back(r.name);
  j["seed"] = a.seed;
  ordered_json lab{{"class", a.lab.lab->name}, {"prints", a.lab.prints}, {"unfinished", a.lab.failed}};
  for (const ClassScore& c : a.lab.scores) lab["log_predictive"][std::string(c.lab)] = c.log_predictive;
  for (std::size_t p = 0; p < a.lab.lab->parameters.size(); ++p) {
    const LabParameter& q = a.lab.lab->parameters[p];
    const double m = a.lab.posterior.mean[p], d = a.lab.posterior.std(p);
    lab["parameters"].push_back({{"name", q.name},
                                 {"unit", q.unit},
                                 {"value", q.value(m)},
                                 {"interval", {q.value(m - 1.96 * d), q.value(m + 1.96 * d)}},
                                 {"share_of_prior", d}});
  }
  j["laboratory"] = lab;
  j["check"] = {{"passed", a.lab.check.passed()},
                {"largest_deviation", a.lab.check.largest},
                {"limit", a.lab.check.limit},
                {"joint_deviation", a.lab.check.joint},
                {"joint_limit", a.lab.check.joint_limit}};
  for (const auto& m : a.lab.check.missed)
    j["check"]["missed"].push_back(
        {{"feature", m.feature}, {"deviation", m.deviation}, {"constant_in_simulations", m.constant}});
  if (a.advice) j["advice"] = advice_json(a);
  if (a.verification) j["verification"] = verification_json(*a.verification);
  for (const NextPrint& n : a.next)
    j["next"].push_back({{"print", n.name}, {"options", n.how}, {"information_nats", n.information}});
  return j.dump(2) + "\n";
}

}  // namespace firn::tune
