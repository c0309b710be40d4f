#include "print/live/run_watch.h"

#include "core/path/path.h"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/robot_command_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "firn/stage_command_t.hpp"

namespace firn {
namespace {

template <class Message>
std::optional<Message> decode(std::span<const std::byte> bytes) {
  Message m{};
  if (m.decode(bytes.data(), 0, int(bytes.size())) != int(bytes.size())) return std::nullopt;
  return m;
}

}  // namespace

std::vector<std::string_view> RunWatch::channels() {
  std::vector<std::string_view> names{channels::kStageCommand.name, channels::kPathJob.name,
                                      channels::kRobotCommand.name, channels::kLayerMetrics.name,
                                      channels::kRunEnd.name,       channels::kSafeStop.name};
  for (const NodeInfo& n : nodes())
    if (n.id != NodeId::kLauncher) names.push_back(channels::fault(n.id).name);
  return names;
}

void RunWatch::on_message(const ChannelInfo& row, std::span<const std::byte> bytes) {
  if (row.name == channels::kStageCommand.name) {
    const auto m = decode<stage_command_t>(bytes);
    if (!m) return;
    layer_ = m->layer;
    pass_ = m->verb == std::int8_t(StageVerb::kPass) ? m->pass_index : -1;
  } else if (row.name == channels::kPathJob.name) {
    const auto m = decode<path_job_t>(bytes);
    if (m) paths_[m->path] = {m->layer, PathKind(m->kind) == PathKind::kMeasurement};
  } else if (row.name == channels::kRobotCommand.name) {
    const auto m = decode<robot_command_t>(bytes);
    if (m && m->path > 0) path_ = m->path;
  } else if (row.name == channels::kLayerMetrics.name) {
    auto m = decode<layer_metrics_t>(bytes);
    if (m && m->header.incarnation == incarnation_) metrics_ = std::move(m);
  } else if (row.name == channels::kRunEnd.name) {
    auto m = decode<run_end_t>(bytes);
    if (m && m->header.incarnation == incarnation_) end_ = std::move(m);
  } else if (row.name == channels::kSafeStop.name) {
    const auto m = decode<safe_stop_t>(bytes);
    if (!m || m->header.incarnation < incarnation_) return;
    safe_stop_ = true;
    if (fault_.empty()) fault_ = m->cause;
  } else if (const auto m = decode<fault_t>(bytes)) {
    if (m->header.incarnation == incarnation_ && m->severity == std::int8_t(Severity::kWarning))
      warnings_.push_back(*m);
    if (m->header.incarnation == incarnation_ && m->severity == std::int8_t(Severity::kNotice) &&
        row.publisher == NodeId::kScheduler)
      notices_.push_back(m->text);
    if (m->header.incarnation == incarnation_ && m->severity == std::int8_t(Severity::kStop) &&
        fault_.empty()) {
      fault_ = m->node + ": " + m->text;
      fault_code_ = m->code;
    }
  }
}

void RunWatch::on_earlier_end(std::span<const std::byte> message) {
  const auto m = decode<run_end_t>(message);
  if (m && (RunOutcome(m->outcome) == RunOutcome::kFinished ||
            RunOutcome(m->outcome) == RunOutcome::kOutOfTolerance))
    end_ = *m;
}

std::string RunWatch::place() const {
  if (path_ > 0) {
    const auto path = paths_.find(path_);
    const std::string number = "path " + std::to_string(path_);
    if (path == paths_.end()) return "during " + number;
    const auto& [layer, measures] = path->second;
    return (measures ? "during the scan of layer " : "during layer ") + std::to_string(layer) + ", " + number;
  }
  if (layer_ == 0) return "before the first layer";
  return "during layer " + std::to_string(layer_) + (pass_ >= 0 ? ", pass " + std::to_string(pass_ + 1) : "");
}

}  // namespace firn
