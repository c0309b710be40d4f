#include "core/control/auto/auto_scheme.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace firn::control {
namespace {

std::string um_text(double mm) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f um", 1e3 * mm);
  return text;
}

std::string percent_text(double share) { return std::to_string(std::lround(100.0 * share)) + " %"; }

std::string_view scheme_of(AutoChoice choice) {
  switch (choice) {
    case AutoChoice::kTogether:
    case AutoChoice::kStrips:
      return "mpc";
    case AutoChoice::kSmf:
      return "smf";
    case AutoChoice::kThreshold:
      return "threshold";
  }
  return "";
}

std::string name_of(AutoChoice choice) { return std::string(kAutoChoiceNames[std::size_t(choice)]); }

}  // namespace

AutoRule auto_rule(const LabSigns& signs, double droplet_mm, bool has_estimate,
                   std::optional<AutoChoice> now) {
  const std::string noise = "a height has " + um_text(signs.noise_mm()) + " of noise";
  const bool left = now == AutoChoice::kThreshold;
  if (signs.judged()) {
    const JudgedModel model = signs.better_model();
    const double share = signs.explained(model);
    if (share < (left ? kAutoModelTaken : kAutoModelLeft))
      return {AutoChoice::kThreshold, "neither model predicts how unlike the cells rise (the better one " +
                                          percent_text(share) + "), and " + noise};
  }
  const std::string of_models =
      signs.judged() ? "the " + std::string(kJudgedModelNames[std::size_t(signs.better_model())]) +
                           " predicts best how unlike the cells rise (" +
                           percent_text(signs.explained(signs.better_model())) + "), and "
                     : "the newest layers tell nothing of the models, and ";
  if (has_estimate) return {AutoChoice::kTogether, of_models + noise};
  const double noisy = now == AutoChoice::kSmf ? kAutoQuiet : kAutoNoisy;
  const bool smf = signs.noise_mm() > noisy * droplet_mm;
  return {smf ? AutoChoice::kSmf : AutoChoice::kStrips,
          of_models + noise + ", " + percent_text(signs.noise_mm() / droplet_mm) + " of a droplet's height"};
}

ControlOptions auto_options(AutoChoice choice, const ControlOptions& options,
                            const deposition::DropletModel& model) {
  ControlOptions o = options;
  o.scheme = scheme_of(choice);
  o.smf.ki_star = 0.0;
  if (choice != AutoChoice::kTogether && choice != AutoChoice::kStrips) return o;
  o.mpc.method = MpcMethod::kStripDp;
  o.mpc.horizon = 3;
  if (choice == AutoChoice::kStrips) return o;
  o.mpc.anneal_sweeps = 50;
  o.mpc.error = ErrorKind::kSquare;
  o.mpc.price_mm2 = kAutoScatter * kAutoScatter * model.sum_of_squares_mm2();
  o.mpc.finish_layers = 3.0;
  o.mpc.rim_lead_layers = kRimLead_layers;
  return o;
}

AutoScheme::AutoScheme(const Setup& setup, const ControlOptions& options)
    : setup_(setup),
      options_(options),
      droplet_mm_(setup.model.layer_height_mm()),
      before_(droplet_mm_),
      after_(droplet_mm_) {
  if (setup.offsets.table.size() > 1)
    throw std::invalid_argument(
        "auto: chooses among schemes that print the middles of cells; control.scheme = \"mpc\" knows "
        "actuation.offsets");
  for (std::size_t n = 0; n < kAutoChoiceNames.size(); ++n) made(AutoChoice(n));
}

std::shared_ptr<LayerController> AutoScheme::made(AutoChoice choice) const {
  Setup setup = setup_;
  if (choice != AutoChoice::kTogether && setup.rim.size() != 0) setup.rim = {};
  const ControlOptions options = auto_options(choice, options_, setup_.model);
  const auto row = std::ranges::find(schemes(), scheme_of(choice), &Scheme::name);
  std::shared_ptr<LayerController> scheme = row->make(setup, options);
  scheme->use_threads(parallel_);
  if (inside_ && choice == AutoChoice::kTogether) scheme->use_models(*inside_, *rim_);
  return scheme;
}

void AutoScheme::use_model(const deposition::DropletModel& model) {
  deposition::check(model);
  setup_.model = model;
  if (after_.scheme) after_.scheme->use_model(model);
}

void AutoScheme::use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) {
  inside_ = inside;
  rim_ = rim;
  if (after_.scheme && after_.choice == AutoChoice::kTogether) after_.scheme->use_models(inside, rim);
}

void AutoScheme::use_threads(const ParallelFor& parallel) {
  parallel_ = parallel;
  if (after_.scheme) after_.scheme->use_threads(parallel);
}

void AutoScheme::use_options(const ControlOptions& options) {
  for (std::size_t n = 0; n < kAutoChoiceNames.size(); ++n)
    made(AutoChoice(n))->use_options(auto_options(AutoChoice(n), options, setup_.model));  // or it throws
  options_ = options;
  if (after_.scheme) after_.scheme->use_options(auto_options(*after_.choice, options, setup_.model));
}

Decision AutoScheme::decide(const Measurement& m) {
  check(m, setup_);
  if (m.layer < after_.layer) before_ = after_ = State(droplet_mm_);
  if (m.layer > after_.layer)
    before_ = after_;
  else
    after_ = before_;  // measured again: as if the first time had not been

  const HeightMap height = known_heights(m);
  State& now = after_;
  if (before_.layer >= 0 && m.layer == before_.layer + 1 && before_.drops.total() > 0)
    now.signs.add(sign_of_layer(setup_, before_.height, before_.drops, before_.materials, height, m.layer,
                                m.noise_std_mm));
  const AutoRule rule = auto_rule(now.signs, droplet_mm_, m.estimate != nullptr, before_.choice);
  const bool changed = now.choice != rule.choice;
  if (changed) {
    now.choice = rule.choice;
    now.scheme = made(rule.choice);
  } else if (inside_ && rule.choice == AutoChoice::kTogether) {
    now.scheme->use_models(*inside_, *rim_);
  }
  Decision d = rule.choice == AutoChoice::kTogether
                   ? now.scheme->decide({*m.estimate, m.layer, m.attempt, m.estimate_std_mm})
                   : now.scheme->decide({m.height, m.layer, m.attempt, m.noise_std_mm});
  const std::string said = name_of(rule.choice) + ", since " + rule.why;
  const bool left_another = changed && before_.choice;
  if (left_another || (now.signs.judged() && !now.told))
    d.notice = "layer " + std::to_string(m.layer + 1) + (left_another ? ": from now on " : ": ") + said;
  now.told = now.told || now.signs.judged();
  d.reason = "auto: " + said + "; " + d.reason;
  now.layer = m.layer;
  now.height = height;
  now.drops = d.drops;
  now.materials = d.materials;
  return d;
}

}  // namespace firn::control
