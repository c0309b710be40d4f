// Computes worst-rank scores of paired outcomes. A run that stopped before its end has no value. That is an
// outcome too, and worse than any value: leaving such pairs out would favour the method that stops most.
#pragma once

#include <span>
#include <vector>

namespace firn::statistics {

struct PairOutcome {
  double stops = 0.0;       ///< how many more of a than of b stopped
  double difference = 0.0;  ///< a - b over the runs that both completed; ignored where `stops` is not 0
};

/// Wilcoxon's signed ranks with worst-rank scores [Lachin, Control. Clin. Trials 20 (1999) 408]: pairs that
/// differ in stops rank above all others, by their number; the others by |difference|; ties share their mean
/// rank, pairs without any difference have none (0). Above 0: a is worse. Their sign-flip test (sign_flip_p)
/// is valid for any pattern of stops: under the null hypothesis the two of a pair are exchangeable, stops
/// included.
std::vector<double> signed_worst_ranks(std::span<const PairOutcome> pairs);

}  // namespace firn::statistics
