#include "page/run_view.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/grid/decision.h"
#include "core/grid/device.h"
#include "core/options/for_people.h"
#include "core/path/path.h"
#include "firn/control_surface_t.hpp"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/operator_command_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/profiler_command_t.hpp"
#include "firn/robot_command_t.hpp"
#include "firn/run_start_t.hpp"
#include "firn/stage_command_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/convert.h"
#include "page/event_words.h"

namespace firn::page {
namespace {

constexpr std::size_t kMaxEvents = 1000;  // older ones are forgotten; the run's log keeps them
constexpr std::size_t kMaxPaths = 4096;

std::string layer_words(int layer) { return "layer " + std::to_string(layer); }

}  // namespace

RunView::RunView(ViewFacts facts) : facts_(std::move(facts)) {
  for (const auto& [node, port] : facts_.ports) instrument(node);
  changed_instruments_.clear();
}

std::set<std::string, std::less<>> RunView::channels() {
  std::set<std::string, std::less<>> names;
  for (const std::string_view name :
       {channels::kRunStart.name, channels::kRunEnd.name, channels::kStageCommand.name,
        channels::kLampCommand.name, channels::kProfilerCommand.name, channels::kRobotCommand.name,
        channels::kPathJob.name, channels::kHeightMap.name, channels::kLayerPlan.name,
        channels::kLinePlan.name, channels::kControlSurface.name, channels::kLayerMetrics.name,
        channels::kDepositionReport.name, channels::kPathReport.name, channels::kHeightModel.name,
        channels::kFlowModel.name, channels::kTemperature.name, channels::kSafeStop.name,
        channels::kOperatorCommand.name})
    names.emplace(name);
  for (const NodeInfo& n : nodes()) {
    names.emplace(channels::fault(n.id).name);
    if (n.driver) names.emplace(channels::device_state(n.id).name);
    if (n.driver) names.emplace(channels::answer(n.id).name);
  }
  return names;
}

void RunView::at_time(std::int64_t utime_us) {
  utime_us_ = utime_us;
  if (utime_us_ < newest_us_) return;
  newest_us_ = utime_us_;
  newest_s_ = now_s_;
}

void RunView::take(std::string_view channel, std::span<const std::byte> bytes, double now_s) {
  now_s_ = now_s;
  alive_s_ = now_s;
  if (channel == channels::kOperatorCommand.name) return on_operator(bytes);
  if (channel.starts_with("FAULT_")) return on_fault(bytes);
  if (channel.starts_with("STATE_") || channel.starts_with("ANSWER_") ||
      channel == channels::kTemperature.name)
    return on_instrument(channel, bytes);
  if (channel == channels::kHeightModel.name || channel == channels::kFlowModel.name)
    return on_estimate(channel, bytes);
  if (channel == channels::kRunEnd.name || channel == channels::kSafeStop.name)
    return on_stop(channel, bytes);
  if (channel == channels::kHeightMap.name || channel == channels::kLayerMetrics.name ||
      channel == channels::kDepositionReport.name || channel == channels::kPathReport.name)
    return on_measurement(channel, bytes);
  on_command(channel, bytes);
}

void RunView::on_command(std::string_view channel, std::span<const std::byte> bytes) {
  if (channel == channels::kRunStart.name) {
    run_start_t m{};
    if (!decode(bytes, m)) return;
    if (m.header.incarnation > 0) resumed();
    first_layer_ = -1;
    event(Weight::kInfo, "print", m.header.incarnation > 0 ? "the print goes on" : "the print begins");
    return set_phase(Phase::kStarting, "the lab is made ready");
  }
  if (channel == channels::kStageCommand.name) {
    stage_command_t m{};
    if (!decode(bytes, m)) return;
    if (m.layer > 0) layer_ = m.layer;
    if (StageVerb(m.verb) == StageVerb::kPass)
      set_phase(Phase::kDepositing,
                "depositing " + layer_words(m.layer) + ", pass " + std::to_string(m.pass_index + 1));
    if (StageVerb(m.verb) == StageVerb::kTrace)
      set_phase(Phase::kDepositing, "printing the lines of " + layer_words(m.layer));
    if (StageVerb(m.verb) == StageVerb::kScan)
      set_phase(Phase::kMeasuring,
                m.layer > 0 ? "measuring " + layer_words(m.layer) : "measuring the bare substrate");
  } else if (channel == channels::kLampCommand.name) {
    on_exposure(bytes);
  } else if (channel == channels::kLayerPlan.name) {
    layer_plan_t m{};
    if (!decode(bytes, m)) return;
    decided(m.decision, m.reason);
  } else if (channel == channels::kLinePlan.name) {
    on_line_plan(bytes);
  } else if (channel == channels::kControlSurface.name) {
    control_surface_t m{};
    if (!decode(bytes, m)) return;
    controller_us_ = utime_us_;
    set_phase(Phase::kDeciding, "planning the paths of " + layer_words(m.layer + 1));
  } else if (channel == channels::kPathJob.name) {
    path_job_t m{};
    if (!decode(bytes, m)) return;
    paths_[m.path] = {m.layer, m.index, m.count, PathKind(m.kind) == PathKind::kMeasurement};
    if (paths_.size() > kMaxPaths) paths_.erase(paths_.begin());
  } else if (channel == channels::kRobotCommand.name) {
    robot_command_t m{};
    if (!decode(bytes, m) || RobotVerb(m.verb) != RobotVerb::kRun) return;
    const auto path = paths_.find(m.path);
    if (path == paths_.end()) return;
    const PathPlace& p = path->second;
    layer_ = std::max(layer_, p.layer);
    interval_ = "path " + std::to_string(p.index + 1) + " of " + std::to_string(p.count);
    set_phase(p.measures ? Phase::kMeasuring : Phase::kDepositing,
              (p.measures ? "measuring " : "depositing ") + layer_words(p.layer) + ", " + interval_);
  }
}

void RunView::decided(int decision, const std::string& reason) {
  controller_us_ = utime_us_;
  if (PlanDecision(decision) == PlanDecision::kPrint) return;
  event(Weight::kNotice, "controller",
        PlanDecision(decision) == PlanDecision::kEnd ? "the controller ends the print"
                                                     : "the controller stops the print")
      .cause = for_people(reason);
}

// No message reports the lamp's own hours; those that this print adds can be counted.
void RunView::on_exposure(std::span<const std::byte> bytes) {
  lamp_command_t m{};
  if (!decode(bytes, m)) return;
  set_phase(Phase::kCuring, "curing " + layer_words(m.layer));
  lamp_open_s_ += m.exposure_s;
  ++exposures_;
  InstrumentRow& lamp = instrument("lamp");
  char hours[20];
  std::snprintf(hours, sizeof hours, "%.4f", lamp_open_s_ / 3600.0);
  put_detail(lamp, "exposures in this print", std::to_string(exposures_), "");
  put_detail(lamp, "open in this print", hours, "h");
}

void RunView::on_operator(std::span<const std::byte> bytes) {
  operator_command_t m{};
  if (!decode(bytes, m)) return;
  const auto told = [&](std::string words) {
    event(Weight::kInfo, "operator", std::move(words)).cause = m.text.empty() ? "" : "by " + m.text;
  };
  switch (OperatorVerb(m.verb)) {
    case OperatorVerb::kPause:
      paused_ = true;
      told("pause: the print waits before its next pass, path or scan");
      break;
    case OperatorVerb::kContinue:
      paused_ = false;
      told("continue");
      break;
    case OperatorVerb::kFinishLayer:
      stopping_ = true;
      told("stop after this layer");
      break;
    case OperatorVerb::kStop:
      operator_stopped_ = true;
      told("safe stop");
      break;
    case OperatorVerb::kAcceptDoubt:
      doubt_layer_.reset();
      told("the doubt is accepted: the print goes on");
      break;
    case OperatorVerb::kSet:
      new_.settings.emplace_back(m.key, m.value);
      told("set " + m.key + " = " + m.value + ", from the next decision on");
      break;
  }
  new_.state = true;
}

void RunView::on_fault(std::span<const std::byte> bytes) {
  fault_t m{};
  if (!decode(bytes, m)) return;
  const auto severity = Severity(m.severity);
  if (severity == Severity::kNotice && m.node == "scheduler") {
    if (m.text.starts_with("the print waits")) {
      before_pause_ = phase_;
      words_before_ = words_;
      set_phase(Phase::kPaused, m.text);
    } else if (m.text.starts_with("the print goes on") && phase_ == Phase::kPaused) {
      set_phase(before_pause_, words_before_);
    }
  }
  const Weight weight = severity == Severity::kStop      ? Weight::kFault
                        : severity == Severity::kWarning ? Weight::kWarning
                                                         : Weight::kNotice;
  EventRow& e = event(weight, m.node, m.text);
  const Figure figure = from_message(m.figure);
  e.value = figure.value;
  e.limit = figure.limit;
  e.unit = figure.unit;
  if (const InterlockWords* row = interlock_words(m.code)) {
    e.cause = row->cause;
    e.remedy = row->remedy;
    e.manual = std::string(kInterlockPage) + std::to_string(m.code);
    if (const auto limit = facts_.limits.find(m.code); limit != facts_.limits.end())
      e.cause += "; limits: " + limit->second;
  } else if (weight == Weight::kFault) {
    e.remedy = kResume;
    e.manual = kStopPage;
  }
  if (weight == Weight::kWarning || weight == Weight::kFault)
    if (const auto i = instruments_.find(m.node); i != instruments_.end()) {
      ++i->second.faults;
      changed_instruments_.insert(m.node);
    }
  if (weight == Weight::kFault && last_stop_.words.empty())
    last_stop_ = {.words = m.node + ": " + m.text, .cause = e.cause, .remedy = e.remedy, .manual = e.manual};
}

void RunView::set_phase(Phase phase, std::string words) {
  const bool ends = phase == Phase::kStopped || phase == Phase::kFinished || phase == Phase::kInterrupted;
  if ((phase_ == phase && words_ == for_people(words)) || (end_ && !ends))
    return;  // the last messages may come after the end
  new_.state = true;
  phase_ = phase;
  words_ = for_people(words);
}

EventRow& RunView::event(Weight weight, std::string source, std::string words) {
  EventRow e;
  e.n = ++events_count_;
  e.t_s = double(utime_us_) * 1e-6;
  e.weight = weight;
  e.source = std::move(source);
  e.words = for_people(words);
  if (events_.size() == kMaxEvents) events_.pop_front();
  return events_.emplace_back(std::move(e));
}

void RunView::put_detail(InstrumentRow& i, const std::string& label, const std::string& value,
                         const std::string& unit) {
  const auto at = std::ranges::find(i.details, label, [](const auto& row) { return std::get<0>(row); });
  if (at == i.details.end())
    i.details.emplace(i.details.begin(), label, value, unit);
  else
    *at = {label, value, unit};
}

InstrumentRow& RunView::instrument(const std::string& node) {
  changed_instruments_.insert(node);
  InstrumentRow& i = instruments_[node];
  if (!i.name.empty()) return i;
  i.name = node;
  i.kind = node.ends_with("_a") || node.ends_with("_b") ? node.substr(0, node.size() - 2) : node;
  i.state = "disconnected";
  i.real = facts_.real.contains(node);
  if (const auto port = facts_.ports.find(node); port != facts_.ports.end()) i.link = port->second;
  if (const auto d = facts_.details.find(node); d != facts_.details.end()) i.details = d->second;
  return i;
}

void RunView::exchanged(const std::string& node, const std::string& text) {
  InstrumentRow& i = instrument(node);
  i.last_text = text;
  i.last_t_s = double(newest_us_) * 1e-6;
}

StateRow RunView::state(double now_s) const {
  StateRow s;
  const double node_s = double(newest_us_) * 1e-6;
  const bool live = !end_;
  s.t_s = live ? node_s + std::max(0.0, now_s - newest_s_) * facts_.time_scale : node_s;
  s.phase = phase_;
  s.words = words_;
  s.layer = layer_;
  s.layers = layers_expected_;
  s.paused = paused_;
  s.stopping = stopping_;
  s.temperatures = temperatures_;
  s.flow = flow_;
  s.interval = interval_;
  if (live) {
    if (alive_s_) s.link_s = std::max(0.0, now_s - *alive_s_);
    const auto age = [&](const std::optional<std::int64_t>& us) -> std::optional<double> {
      if (!us) return std::nullopt;
      return double(newest_us_ - *us) * 1e-6 / facts_.time_scale + std::max(0.0, now_s - newest_s_);
    };
    s.surface_s = age(surface_us_);
    s.instruments_s = age(instruments_us_);
    s.controller_s = age(controller_us_);
    if (!layers_.empty() && first_layer_ >= 0) {
      const LayerRow& last = layers_.rbegin()->second;
      const int done = last.n - first_layer_, left = layers_expected_ - last.n;
      if (done > 0 && left >= 0)
        s.eta_s = std::max(0.0, (last.t_s - first_s_) * left / done - (s.t_s - last.t_s)) / facts_.time_scale;
    }
  }
  if (doubt_layer_)
    s.doubt = DoubtRow{doubt_words_,
                       "accept: go on with the next layer in spite of them; or stop, and look at the part"};
  return s;
}

NewRows RunView::take_new() {
  for (const std::string& name : changed_instruments_) new_.instruments.push_back(instruments_[name]);
  for (const int n : changed_layers_) new_.layers.push_back(layers_[n]);
  for (const EventRow& e : events_)
    if (e.n > events_told_) new_.events.push_back(e);
  events_told_ = events_count_;
  changed_instruments_.clear();
  changed_layers_.clear();
  return std::exchange(new_, {});
}

}  // namespace firn::page
