// RunView's reading of measurements, instruments, estimators and the end of a print.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/grid/decision.h"
#include "core/grid/device.h"
#include "core/options/enumerators.h"
#include "core/options/for_people.h"
#include "firn/answer_t.hpp"
#include "firn/deposition_report_t.hpp"
#include "firn/device_state_t.hpp"
#include "firn/enums.h"
#include "firn/flow_model_t.hpp"
#include "firn/height_model_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/line_plan_t.hpp"
#include "firn/path_report_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "firn/temperature_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/told_heights.h"
#include "page/event_words.h"
#include "page/map_head.h"
#include "page/run_view.h"

namespace firn::page {
namespace {

constexpr double kMeasuredUm = 1e3;  // per mm
constexpr const char* kDeviceStates[] = {"disconnected", "connecting", "identifying", "safe",  "staged",
                                         "armed",        "active",     "suspect",     "fault", "estop"};
static_assert(std::size(kDeviceStates) == kTableSize<DeviceState>);
constexpr const char* kOutcomes[] = {"ready", "done", "nothing done", "unknown", "refused", "failed"};
static_assert(std::size(kOutcomes) == kTableSize<Outcome>);
constexpr const char* kTemperaturePlaces[] = {"tip", "laser", "conduit joint"};

template <std::size_t N>
std::string word_of(const char* const (&words)[N], int value) {
  return value >= 0 && std::size_t(value) < N ? words[value] : "unknown";
}

}  // namespace

void RunView::doubt(int layer, const std::string& where, std::int64_t droplets) {
  doubt_layer_ = layer;
  doubt_words_ = (droplets > 0 ? std::to_string(droplets) + " droplets" : std::string("the deposition")) +
                 " of " + where + " may or may not have been deposited";
  EventRow& e = event(Weight::kWarning, "scheduler", doubt_words_);
  e.cause = "an instrument was lost or reset while they were deposited";
  e.remedy = "the closed loop measures and goes on; the open loop waits for your word";
  e.manual = kDoubtPage;
  if (droplets > 0) {
    e.value = double(droplets);
    e.unit = "droplets";
  }
  new_.state = true;
}

void RunView::on_measurement(std::string_view channel, std::span<const std::byte> bytes) {
  if (channel == channels::kLayerMetrics.name) return on_metrics(bytes);
  if (channel == channels::kHeightMap.name) {
    const auto m = map_head(bytes);
    if (!m) return;
    at_time(m->utime_us);
    surface_us_ = utime_us_;
    set_phase(Phase::kDeciding, "deciding layer " + std::to_string(m->layer + 1));
    if (!doubt_layer_ || m->layer < *doubt_layer_) return;
    doubt_layer_.reset();
    event(Weight::kInfo, "print", "the doubt of layer " + std::to_string(m->layer) + " is measured").cause =
        "the surface was scanned: the next layer answers what is there";
  } else if (channel == channels::kDepositionReport.name) {
    deposition_report_t m{};
    if (decode(bytes, m) && Outcome(m.outcome) == Outcome::kUnknown)
      doubt(m.layer, "layer " + std::to_string(m.layer) + ", pass " + std::to_string(m.pass_index + 1),
            m.unknown_to - m.unknown_from);
  } else {
    path_report_t m{};
    if (decode(bytes, m) && Outcome(m.outcome) == Outcome::kUnknown)
      doubt(m.layer, "layer " + std::to_string(m.layer) + ", path " + std::to_string(m.path), 0);
  }
}

void RunView::on_metrics(std::span<const std::byte> bytes) {
  layer_metrics_t m{};
  if (!decode(bytes, m)) return;
  LayerRow r;
  r.n = m.layer;
  r.t_s = double(m.header.utime_us) * 1e-6;
  r.rms_um = m.rms_mm * kMeasuredUm;
  r.mean_um = m.mean_error_mm * kMeasuredUm;
  r.max_um = std::max(std::abs(m.min_error_mm), std::abs(m.max_error_mm)) * kMeasuredUm;
  if (!heights_told(m)) r.rms_um = r.mean_um = r.max_um = std::nan("");
  r.droplets = m.drops;
  r.decide_ms = m.decide_s * 1e3;
  if (const auto p = predicted_.find(m.layer); p != predicted_.end()) r.predicted_rms_um = p->second;
  if (const auto o = outlines_.find(m.layer); o != outlines_.end()) r.outline = o->second;
  layers_[m.layer] = r;
  changed_layers_.insert(m.layer);
  layers_expected_ = m.layers_expected;
  layer_ = std::max(layer_, m.layer);
  new_.state = true;
  if (first_layer_ < 0) {
    first_layer_ = m.layer;
    first_s_ = r.t_s;
  }
}

void RunView::predicted(int layer, double rms_um) {
  predicted_[layer] = rms_um;
  const auto row = layers_.find(layer);
  if (row == layers_.end()) return;
  row->second.predicted_rms_um = rms_um;
  changed_layers_.insert(layer);
}

void RunView::outline(int layer, const OutlineStats& stats) {
  outlines_[layer] = stats;
  const auto row = layers_.find(layer);
  if (row == layers_.end()) return;
  row->second.outline = stats;
  changed_layers_.insert(layer);
}

void RunView::on_instrument(std::string_view channel, std::span<const std::byte> bytes) {
  if (channel == channels::kTemperature.name) {
    temperature_t m{};
    if (!decode(bytes, m)) return;
    temperatures_.clear();
    if (facts_.platen) return void(temperatures_.emplace_back("platen", m.degC[0], m.set_degC[0]));
    for (std::size_t n = 0; n < std::size(kTemperaturePlaces); ++n)
      temperatures_.emplace_back(kTemperaturePlaces[n], m.degC[n], m.set_degC[n]);
    return;
  }
  if (channel.starts_with("STATE_")) {
    device_state_t m{};
    if (!decode(bytes, m)) return;
    InstrumentRow& i = instrument(m.node);
    i.state = word_of(kDeviceStates, m.state);
    i.words = m.text;
    if (!m.identity.empty()) put_detail(i, "identity", m.identity, "");
  } else {
    answer_t m{};
    if (!decode(bytes, m)) return;
    InstrumentRow& i = instrument(m.node);
    i.last_text = word_of(kOutcomes, m.outcome) + (m.text.empty() ? "" : ": " + m.text);
    i.last_t_s = double(utime_us_) * 1e-6;
  }
  instruments_us_ = utime_us_;
}

// Shutter and flow are learned from the lines of the layers before.
void RunView::on_line_plan(std::span<const std::byte> bytes) {
  line_plan_t m{};
  if (!decode(bytes, m)) return;
  decided(m.decision, m.reason);
  const auto add = [&](const char* name, double value, const char* unit) {
    estimates_.push_back({double(utime_us_) * 1e-6, name, value, std::nan(""), unit});
    new_.estimates.push_back(estimates_.back());
  };
  // Else no layer follows that has a shutter and a flow.
  if (PlanDecision(m.decision) == PlanDecision::kPrint) {
    add("flow", m.flow_share, "");
    add("sheath_gas", m.sheath_share, "");
    add("shutter_opens_late_by", m.open_delay_s * 1e3, "ms");
    add("shutter_closes_late_by", m.close_delay_s * 1e3, "ms");
  }
  for (const auto& [name, mm] :
       {std::pair("lines_start_late_by", m.start_error_mm), std::pair("lines_end_late_by", m.end_error_mm)})
    if (std::isfinite(mm)) add(name, mm, "mm");
}

void RunView::on_estimate(std::string_view channel, std::span<const std::byte> bytes) {
  const auto add = [&](const std::string& name, double value, double sd, const std::string& unit) {
    estimates_.push_back({double(utime_us_) * 1e-6, name, value, sd, unit});
    new_.estimates.push_back(estimates_.back());
  };
  if (channel == channels::kHeightModel.name) {
    height_model_t m{};
    if (!decode(bytes, m)) return;
    const double values[] = {m.h1_mm, m.h2_mm, m.h3_mm};
    for (std::size_t n = 0; n < 3; ++n)
      add("h" + std::to_string(n + 1), values[n] * kMeasuredUm,
          std::sqrt(std::max(0.0, m.covariance_mm2[4 * n])) * kMeasuredUm, "um");
    return;
  }
  flow_model_t m{};
  if (!decode(bytes, m)) return;
  add("flow_a", m.factor[0], m.factor_std[0], "");
  flow_ = estimates_.back();
  add("flow_b", m.factor[1], m.factor_std[1], "");
}

void RunView::on_stop(std::string_view channel, std::span<const std::byte> bytes) {
  if (channel == channels::kSafeStop.name) {
    safe_stop_t m{};
    if (!decode(bytes, m) || phase_ == Phase::kStopping || phase_ == Phase::kStopped) return;
    if (end_ && end_->whole) return;  // a finished print ends safe, too
    set_phase(Phase::kStopping, "the lab is made safe: " + m.cause);
    if (operator_stopped_) {
      last_stop_ = {.words = m.cause, .by_operator = true};
      event(Weight::kNotice, "safety", "safe stop").cause = m.cause;
      return;
    }
    if (last_stop_.words.empty())
      last_stop_ = {.words = m.cause, .remedy = std::string(kResume), .manual = std::string(kStopPage)};
    EventRow& e = event(Weight::kStop, "safety", "safe stop");
    e.cause = m.cause;
    e.remedy = last_stop_.remedy;
    e.manual = kStopPage;
    return;
  }
  run_end_t m{};
  if (!decode(bytes, m)) return;
  constexpr const char* kEnds[] = {"finished", "ended early", "stopped safely", "waits for operator",
                                   "out of tolerance"};
  static_assert(std::size(kEnds) == kTableSize<RunOutcome>);
  over(word_of(kEnds, m.outcome), m.reason);
}

void RunView::over(const std::string& outcome, const std::string& reason) {
  if (end_ && end_->outcome == outcome) return;
  const bool whole = outcome == "finished" || outcome == "out of tolerance";
  const bool stopped = outcome == "stopped safely";
  EndRow end;
  if (stopped) end = last_stop_;
  end.outcome = outcome;
  end.whole = whole;
  end.words = outcome + (reason.empty() ? "" : ": " + for_people(reason));
  if (end.cause.empty())
    end.cause = stopped && !last_stop_.words.empty() ? last_stop_.words : for_people(reason);
  if (end.remedy.empty() && !whole)
    end.remedy = outcome == "waits for operator"
                     ? "decide, then: firn print --resume RUN (with --accept-doubt or --set)"
                     : "firn print --resume RUN goes on with it";
  if (end.manual.empty() && stopped && !end.by_operator) end.manual = kStopPage;
  end_ = end;
  paused_ = false;
  stopping_ = false;
  doubt_layer_.reset();
  new_.ended = true;
  set_phase(whole                      ? Phase::kFinished
            : outcome == "interrupted" ? Phase::kInterrupted
                                       : Phase::kStopped,
            end.words);
  EventRow& e = event(outcome == "finished" ? Weight::kInfo
                      : whole               ? Weight::kWarning
                      : end.by_operator     ? Weight::kNotice
                                            : Weight::kStop,
                      "print", end.words);
  e.cause = end.cause == for_people(reason) ? "" : end.cause;
  e.remedy = end.remedy;
  e.manual = end.manual;
}

void RunView::judged(const std::string& verdict, std::optional<bool> within, const std::string& facts) {
  if (!end_ || (end_->verdict == verdict && end_->facts == facts)) return;
  end_->verdict = verdict;
  end_->within = within;
  end_->facts = facts;
  new_.ended = true;
}

void RunView::resumed() {
  end_.reset();
  last_stop_ = {};
  operator_stopped_ = false;
  paused_ = false;
  stopping_ = false;
  new_.state = true;
}

}  // namespace firn::page
