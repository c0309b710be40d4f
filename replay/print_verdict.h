// Writes a verdict as text and as JSON.
#pragma once

#include <string>

#include "replay/verdict.h"

namespace firn::replay {

/// Returns "identical: 8 nodes, 12,345 steps, 6,789 messages (1,234,567 bytes)", or the differences, the
/// first divergence first and in full. Provenance and changed settings come before them.
std::string to_text(const RunVerdict& verdict);
std::string to_json(const RunVerdict& verdict);
}  // namespace firn::replay
