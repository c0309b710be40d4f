// service_questions() returns the questions of a person to the stage, beside a print (firn device);
// jog_refused() and pulses_refused() hold the limits of a person's moves.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/link/dialect.h"
#include "drivers/stage/ensemble.h"

namespace firn::drivers {

inline constexpr double kStageJogSpeed_mm_s = 10.0;

/// The questions of an order: its parameters, its version, or where the axes stand.
std::vector<Request> service_questions(std::string_view verb, const ensemble::Table& table);

/// The answer to one of them, as a text.
std::string service_answer(const Request& question, const ensemble::Reply& reply,
                           const std::string& identity);

/// The axis whose place a question asked for, or nothing.
std::optional<std::size_t> asked_place(const Request& question);

/// Why a jog of x, y, z [mm] at a speed [mm/s] (last: 1 = far) is refused, or nothing.
std::optional<std::string> jog_refused(std::span<const double> values);

/// Why a number of pulses at a pitch [mm] is refused, or nothing.
std::optional<std::string> pulses_refused(std::span<const double> values);

}  // namespace firn::drivers
