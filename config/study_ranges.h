// Ranges of keys from which a study draws: settings of its schemes (a design) and labs of its seeds (priors).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace firn {

/// The values of a key between two ends, or a normal distribution of them.
struct KeyRange {
  enum class Law { kUniform, kLogUniform, kNormal };
  std::string key;
  double low = 0.0, high = 1.0;  ///< both ends; of kNormal mean and standard deviation
  Law law = Law::kUniform;
  bool whole = false;  ///< integers, both ends among them
  int line = 0;        ///< in the study file

  /// Returns "KEY=VALUE" at the share u of the range, in six significant digits, so that computers whose
  /// logarithms differ in the last bit draw the same. @pre not kNormal, 0 <= u < 1
  std::string at(double u) const;
  /// Returns "KEY=VALUE" of a seed's lab: a draw of its own for each seed and key. A normal one keeps within
  /// three standard deviations.
  std::string drawn(std::uint64_t seed) const;
  std::string lowest() const;   ///< "KEY=VALUE" that can be drawn
  std::string highest() const;  ///< likewise
  /// Returns the law in words: "0.1 to 10, even in the logarithm".
  std::string words() const;
};

/// A design over the ranges of some keys.
struct SampleDesign {
  enum class Kind { kLatin, kSobol };
  Kind kind = Kind::kLatin;
  int points = 0;
  std::uint64_t seed = 1;
  std::vector<KeyRange> ranges;

  /// Returns the settings of each point, a "KEY=VALUE" for each range.
  std::vector<std::vector<std::string>> settings() const;
};

}  // namespace firn
