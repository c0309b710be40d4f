// tune_text, tune_json and tune_page write the answer of firn tune: one line first, then its grounds.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "studies/tune/advice.h"
#include "studies/tune/next_print.h"
#include "studies/tune/verify_promise.h"

namespace firn::tune {

struct TuneAnswer {
  std::span<const RecordedRun> runs;
  std::span<const TuneKey> keys;
  std::string goal;  ///< name of the metric: "rms_um"
  const FittedLab& lab;
  std::optional<Advice> advice;  ///< none: the laboratory is of no known class
  std::vector<NextPrint> next;
  std::optional<Verification> verification;
  int promised_prints = 10;
  std::uint64_t seed = 1;
};

/// Returns the answer in one line, without an end of line.
std::string tune_line(const TuneAnswer& answer);
std::string tune_text(const TuneAnswer& answer);
std::string tune_json(const TuneAnswer& answer);
/// Returns the page: predicted curves, unidentifiable parameters, the next excitation. HTML.
std::string tune_page(const TuneAnswer& answer);

}  // namespace firn::tune
