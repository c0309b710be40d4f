#include "runtime/jump_check.h"

#include <algorithm>
#include <array>

#include "firn/camera_command_t.hpp"
#include "firn/control_surface_t.hpp"
#include "firn/deposition_report_t.hpp"
#include "firn/device_state_t.hpp"
#include "firn/enable_t.hpp"
#include "firn/gas_command_t.hpp"
#include "firn/heater_command_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/height_profile_t.hpp"
#include "firn/jet_command_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/laser_command_t.hpp"
#include "firn/laser_samples_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/path_report_t.hpp"
#include "firn/profiler_command_t.hpp"
#include "firn/robot_command_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "firn/scan_done_t.hpp"
#include "firn/stage_command_t.hpp"
#include "firn/valve_command_t.hpp"

namespace firn {
namespace {

/// Bytes from the message's begin to a member that no text or array precedes; 0 = there is none. The epoch of
/// device_state_t comes after a text that begins there, and one byte.
struct Places {
  std::string_view type;
  std::int64_t fingerprint;
  std::size_t epoch;
  std::size_t layer = 0;
  std::size_t number = 0;
  const char* number_name = "";
};

const Places* places_of(std::string_view type) {
  constexpr std::size_t kFirst = wire::kHeaderEnd;
  static const std::array kPlaces{
      Places{"enable_t", enable_t::getHash(), kFirst},
      Places{"safe_stop_t", safe_stop_t::getHash(), kFirst},
      Places{"device_state_t", device_state_t::getHash(), kFirst},
      Places{"stage_command_t", stage_command_t::getHash(), kFirst + 12},
      Places{"jet_command_t", jet_command_t::getHash(), kFirst + 8},
      Places{"profiler_command_t", profiler_command_t::getHash(), kFirst + 8},
      Places{"lamp_command_t", lamp_command_t::getHash(), kFirst + 8},
      Places{"robot_command_t", robot_command_t::getHash(), kFirst + 8},
      Places{"valve_command_t", valve_command_t::getHash(), kFirst + 8},
      Places{"laser_command_t", laser_command_t::getHash(), kFirst + 8},
      Places{"heater_command_t", heater_command_t::getHash(), kFirst + 8},
      Places{"camera_command_t", camera_command_t::getHash(), kFirst + 8},
      Places{"gas_command_t", gas_command_t::getHash(), kFirst + 8},
      Places{"height_map_t", height_map_t::getHash(), 0, kFirst + 4, kFirst + 12, "map_id"},
      Places{"layer_plan_t", layer_plan_t::getHash(), 0, kFirst + 4, kFirst + 12, "map_id"},
      Places{"control_surface_t", control_surface_t::getHash(), 0, kFirst + 4, kFirst + 12, "map_id"},
      Places{"height_profile_t", height_profile_t::getHash(), 0, kFirst + 4, kFirst + 12, "scan_id"},
      Places{"laser_samples_t", laser_samples_t::getHash(), 0, kFirst + 4, kFirst + 12, "scan_id"},
      Places{"scan_done_t", scan_done_t::getHash(), 0, kFirst, kFirst + 8, "scan_id"},
      Places{"deposition_report_t", deposition_report_t::getHash(), 0, kFirst + 4, kFirst + 20, "map_id"},
      Places{"path_job_t", path_job_t::getHash(), 0, kFirst + 24, kFirst + 28, "map_id"},
      Places{"path_report_t", path_report_t::getHash(), 0, kFirst + 16, 0},
      Places{"layer_metrics_t", layer_metrics_t::getHash(), 0, kFirst, kFirst + 8, "map_id"}};
  const auto it = std::ranges::find(kPlaces, type, &Places::type);
  return it == kPlaces.end() ? nullptr : &*it;
}

std::int64_t number_at(std::span<const std::byte> message, std::size_t at, std::size_t size) {
  std::uint64_t v = 0;
  for (const std::byte b : message.subspan(at, size)) v = v << 8 | std::uint64_t(b);
  return size == 4 ? std::int64_t(std::int32_t(v)) : std::int64_t(v);
}

std::string beyond(const char* member, std::int64_t value, std::int64_t most) {
  return std::string(member) + " = " + std::to_string(value) + " cannot follow, at most " +
         std::to_string(most) + " can";
}

}  // namespace

std::string JumpCheck::take(const ChannelInfo& channel, const wire::Header& header,
                            std::span<const std::byte> message) {
  return follow(channel, header, message, false);
}

std::string JumpCheck::restore(const ChannelInfo& channel, const wire::Header& header,
                               std::span<const std::byte> message) {
  return follow(channel, header, message, !last_.contains(channel.name));
}

std::string JumpCheck::follow(const ChannelInfo& channel, const wire::Header& header,
                              std::span<const std::byte> message, bool any_first) {
  const Places* p = places_of(channel.type);
  if (!p) return {};
  const std::size_t end = std::max({p->epoch, p->layer, p->number}) + 8;
  if (message.size() < end || number_at(message, 0, 8) != p->fingerprint) return {};
  if (p->epoch) {
    std::size_t at = p->epoch;
    if (p->type == "device_state_t") {
      at += 4 + std::size_t(number_at(message, at, 4)) + 1;
      if (at > message.size() || message.size() - at < 8) return {};
    }
    const std::int64_t epoch = number_at(message, at, 8);
    const std::int64_t most = largest_epoch(header.incarnation);
    return epoch > most ? beyond("enable_epoch", epoch, most) : std::string();
  }
  const std::int64_t layer = number_at(message, p->layer, 4);
  const std::int64_t number = p->number ? number_at(message, p->number, 8) : 0;
  Last& last = last_[channel.name];
  if (!any_first) {
    if (layer - last.layer > kMaxLayersAtOnce) return beyond("layer", layer, last.layer + kMaxLayersAtOnce);
    if (number > 0 && number - kMaxScansAtOnce > last.number)
      return beyond(p->number_name, number, last.number + kMaxScansAtOnce);
  }
  last = {std::max(last.layer, layer), std::max(last.number, number)};
  return {};
}

}  // namespace firn
