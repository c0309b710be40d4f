// Describes events and outputs in words and as JSON, for findings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "runtime/event.h"

namespace firn::runs {

/// Returns the channel, timer or port: "LAYER_PLAN", "timer 3", "port stage".
std::string place_of(const Event& event, const std::vector<std::string>& ports);
std::string place_of(const Output& output, const std::vector<std::string>& ports);
/// Returns the output in words: "send LAYER_PLAN 7", "arm timer 3 for 2.500000 s", "write 12 bytes".
std::string in_words(const Output& output);
/// Returns the event as one line of JSON: messages by field, long arrays shortened, instrument bytes as text
/// with escapes.
std::string as_json(std::uint64_t step, const Event& event, const std::vector<std::string>& ports);
/// Returns printable text with \r, \n and \xNN.
std::string escaped(std::span<const std::byte> bytes, std::size_t at_most);

}  // namespace firn::runs
