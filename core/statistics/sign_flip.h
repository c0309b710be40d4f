// Computes the p-value of the paired randomisation (sign-flip) test.
#pragma once

#include <cstdint>
#include <span>

namespace firn::statistics {

struct SignFlipOptions {
  int draws = 20'000;          ///< where there are too many sign patterns to try them all
  std::size_t all_up_to = 16;  ///< pairs for which all 2^n patterns are tried
  std::uint64_t seed = 1;
};

/// Two-sided p-value of "the two of a pair could be exchanged" for the mean of the paired differences: the
/// share of sign patterns of the differences whose |mean| is at least the one found [Fisher 1935; Good,
/// Permutation Tests, 2000]. No distribution is assumed. Exact for few pairs; else (1 + hits) / (1 + draws)
/// over keyed random patterns, which is a valid p-value too. No difference but zeros, or no pair: 1.
double sign_flip_p(std::span<const double> differences, const SignFlipOptions& options = {});

/// The smallest p-value that `pairs` differences can give.
double smallest_p(std::size_t pairs, const SignFlipOptions& options = {});

}  // namespace firn::statistics
