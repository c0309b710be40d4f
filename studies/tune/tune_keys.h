// TuneKey holds a configuration key that is tuned, with the range that is searched.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"

namespace firn::tune {

/// Both pitches of a square grid at once: the field keeps its size and h1..h3 their volume.
inline constexpr std::string_view kSpacing = "grid.pitch_mm";

class TuneKey {
 public:
  /// @param text "control.smf.kp", or "control.smf.kp=0.2:2" with the range to search; without it, the key's
  /// own limits, or a quarter to four times the recorded value where they are far wider
  /// @param experiment the recorded one, whose value is compared with
  /// @throws UsageError: a key that is unknown (the nearest known one is named), of another scheme, of the
  /// plant or of the lab, no number and no word; a range that is empty or beyond the key's own; kSpacing of a
  /// part that is no plain shape
  TuneKey(const std::string& text, const Experiment& experiment);

  const std::string& key() const { return key_; }
  double recorded() const { return recorded_; }
  /// True where every value is tried: words, and integers of at most kMaxEnumerated values.
  bool enumerated() const { return !values_.empty(); }
  std::span<const double> values() const { return values_; }

  /// The searched range as [0, 1]: recorded() is at 1/2 unless it is an end. Integers are rounded.
  double at(double u) const;
  double place(double value) const;

  void set(double value, Experiment& experiment) const;
  /// True for kSpacing, whose values need inputs of their own.
  bool spacing() const { return key_ == kSpacing; }
  std::string text(double value) const;
  /// True for a value at an end of the searched range, beyond which the key's own limits allow more.
  bool at_open_end(double value) const;

 private:
  void narrow();
  void take_power();
  void take_spacing(const std::string& text, const Experiment& experiment);
  void take_range(const std::string& text);

  std::string key_;
  double low_ = 0.0, high_ = 1.0, power_ = 1.0, recorded_ = 0.0;
  double least_ = 0.0, most_ = 0.0;  ///< the key's own limits
  bool whole_ = false;
  std::vector<std::string> words_;
  std::vector<double> values_;
};

/// True for a key of the sections that a print may change on the same part.
bool is_tuned_section(std::string_view key);
inline constexpr std::string_view kTunedSections =
    "keys of [control], [process], [estimator] and [model] are tuned, seeds apart";

inline constexpr int kMaxEnumerated = 8;

/// Values of all keys, in their order.
using Setting = std::vector<double>;
Setting recorded_setting(std::span<const TuneKey> keys);
/// Returns the experiment with the values. @throws ConfigError: a rule between keys is broken
Experiment with_setting(std::span<const TuneKey> keys, const Setting& values, const Experiment& experiment);
/// "control.smf.kp = 0.8, control.smf.ki_star = 0.02"
std::string text_of(std::span<const TuneKey> keys, const Setting& values);

}  // namespace firn::tune
