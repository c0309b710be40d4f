#include "print/own/own_message.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <stdexcept>

#include "lcmtypes/schema.h"
#include "lcmtypes/utf8.h"
#include "lcmtypes/validate.h"
#include "print/own/message_from_json.h"
#include "runtime/transport_wire.h"

namespace firn {
namespace {

constexpr std::size_t kFingerprintBytes = 8, kSeqEnd = 28;  // of header_t: run_id 8, incarnation 4, seq 8

template <class Message>
OwnMessage decoded(std::span<const std::byte> bytes) {
  Message m;
  if (m.decode(bytes.data(), 0, int(bytes.size())) < 0) throw std::invalid_argument("does not decode");
  return m;
}

struct Row {
  std::string_view channel;
  OwnMessage (*decode)(std::span<const std::byte>);
};

const std::array<Row, std::variant_size_v<OwnMessage>>& rows() {
  static const std::array<Row, std::variant_size_v<OwnMessage>> all{{
      {channels::kOwnValues.name, &decoded<own_values_t>},
      {channels::kOwnHeightModel.name, &decoded<own_height_model_t>},
      {channels::kOwnFlowModel.name, &decoded<own_flow_model_t>},
  }};
  return all;
}

const Row& row_of(std::string_view channel) {
  const auto row = std::ranges::find(rows(), channel, &Row::channel);
  if (row != rows().end()) return *row;
  std::string known;
  for (const std::string_view name : own_channels()) known += (known.empty() ? "" : ", ") + std::string(name);
  throw std::invalid_argument(
      valid_utf8(channel) + ": " +
      (find_channel(channel) ? "is not for programs of the lab's own" : "there is no such channel") +
      "; they may publish " + known);
}

}  // namespace

std::span<const std::string_view> own_channels() {
  static const auto names = [] {
    std::array<std::string_view, std::variant_size_v<OwnMessage>> all;
    std::ranges::transform(rows(), all.begin(), &Row::channel);
    return all;
  }();
  return names;
}

OwnMessage own_message(std::string_view program, std::string_view channel, std::span<const std::byte> bytes) {
  const Row& row = row_of(channel);
  std::vector<std::byte> message(bytes.begin(), bytes.end());
  if (message.size() >= wire::kHeaderEnd) {
    std::fill(message.begin() + kFingerprintBytes, message.begin() + wire::kHeaderEnd, std::byte{0});
    message[kSeqEnd - 1] = std::byte{1};
  }
  if (const auto problem = validate(*find_channel(channel), message)) throw std::invalid_argument(*problem);
  OwnMessage out = row.decode(message);
  std::visit([&](auto& m) { m.program = program; }, out);
  return out;
}

OwnMessage own_message_from_json(std::string_view program, std::string_view channel, std::string_view json) {
  (void)row_of(channel);
  const schema::Type* const type = Schema::builtin().find(find_channel(channel)->type);
  std::vector<std::byte> bytes;
  try {
    bytes = message_from_json(*type, json, {"program"});
  } catch (const std::invalid_argument& e) {
    throw std::invalid_argument(std::string(channel) + ": " + e.what());
  }
  return own_message(program, channel, bytes);
}

}  // namespace firn
