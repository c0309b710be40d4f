#include "studies/tune/tune_keys.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/changes.h"
#include "config/fields.h"
#include "config/find_key.h"
#include "config/labs.h"
#include "core/options/number.h"
#include "files/nearest.h"
#include "files/usage_error.h"

namespace firn::tune {
namespace {

constexpr std::string_view kSections[] = {"control.", "process.", "estimator.", "model."};
constexpr double kWidestPower = 8.0;
constexpr double kWide = 200.0;  // times the recorded value: beyond it a range is narrowed
constexpr double kSpacingFold = 1.3, kSpacingMost = 2.0;
constexpr double kFold = 4.0;  // to these parts and times of it

double number_in(const std::string& text, const std::string& whole) {
  if (const auto value = whole_number<double>(text)) return *value;
  throw UsageError("--keys " + whole + ": '" + text + "' is not a number");
}

double value_of(const Field& field) {
  struct Read {
    double operator()(double* v) const { return *v; }
    double operator()(std::int32_t* v) const { return double(*v); }
    double operator()(std::int64_t* v) const { return double(*v); }
    double operator()(std::uint64_t* v) const { return double(*v); }
    double operator()(std::vector<AlphaStep>* v) const { return v->size() == 1 ? v->front().alpha : NAN; }
    double operator()(const WordMember& v) const { return double(v.get(v.member)); }
    double operator()(std::vector<double>*) const { return NAN; }
    double operator()(std::string*) const { return NAN; }
  };
  return std::visit(Read{}, field.value);
}

void write_value(const Field& field, double value, const std::vector<std::string>& words) {
  struct Write {
    double value;
    const std::vector<std::string>& words;
    void operator()(double* v) const { *v = value; }
    void operator()(std::int32_t* v) const { *v = std::int32_t(std::lround(value)); }
    void operator()(std::int64_t* v) const { *v = std::int64_t(std::llround(value)); }
    void operator()(std::uint64_t* v) const { *v = std::uint64_t(std::llround(value)); }
    void operator()(std::vector<AlphaStep>* v) const { *v = {{1, value}}; }
    void operator()(const WordMember& v) const { v.set(v.member, std::size_t(std::lround(value))); }
    void operator()(std::vector<double>*) const {}
    void operator()(std::string* v) const { *v = words[std::size_t(std::lround(value))]; }
  };
  std::visit(Write{value, words}, field.value);
}

const Field& find(const std::vector<Field>& table, const std::string& key, const Experiment& e) {
  const auto found = std::ranges::find(table, key, &Field::key);
  if (found != table.end() && !belongs(*found, e))
    throw UsageError("--keys: '" + key + "' is a key of another lab; the run's is " +
                     std::string(lab_of(e).name));
  if (found == table.end()) {
    std::string near = likeliest_key(table, key);
    if (near.empty()) {  // no word is known, but the letters may be
      std::vector<std::string_view> known;
      for (const Field& f : table) known.push_back(f.key);
      near = nearest(key, known);
    }
    throw UsageError("--keys: there is no key '" + key + "'" +
                     (near.empty() ? "" : "; the nearest known one is " + near));
  }
  return *found;
}

bool is_whole(const Field& field) {
  return std::holds_alternative<std::int32_t*>(field.value) ||
         std::holds_alternative<std::int64_t*>(field.value) ||
         std::holds_alternative<std::uint64_t*>(field.value);
}

}  // namespace

bool is_tuned_section(std::string_view key) {
  return std::ranges::any_of(kSections, [&](std::string_view s) { return key.starts_with(s); }) &&
         !key.ends_with(".seed");
}

TuneKey::TuneKey(const std::string& text, const Experiment& experiment) {
  const std::size_t equals = text.find('=');
  key_ = text.substr(0, equals);
  if (spacing()) {
    take_spacing(text, experiment);
    return;
  }
  Experiment e = experiment;
  const std::vector<Field> table = fields(e);
  const Field& field = find(table, key_, e);
  if (key_.starts_with("ice."))
    throw UsageError("--keys " + key_ + ": the part was sliced by [ice] before its print; " +
                     std::string(kTunedSections));
  if (!is_tuned_section(key_)) throw UsageError("--keys " + key_ + ": " + std::string(kTunedSections));
  if (const std::string why = unread_by_scheme(e, key_); !why.empty())
    throw UsageError("--keys " + key_ + " " + why);
  whole_ = is_whole(field);
  recorded_ = value_of(field);
  for (const std::string_view word : field.limits.choices) words_.emplace_back(word);
  if (!words_.empty()) {
    if (auto* const word = std::get_if<std::string*>(&field.value))
      recorded_ = double(std::ranges::find(words_, **word) - words_.begin());
    if (equals != std::string::npos) throw UsageError("--keys " + text + ": a key of words has no range");
    for (std::size_t n = 0; n < words_.size(); ++n) values_.push_back(double(n));
    return;
  }
  if (!std::isfinite(recorded_)) throw UsageError("--keys " + key_ + ": its value is no single number");
  low_ = least_ = field.limits.min;
  high_ = most_ = field.limits.max;
  if (equals != std::string::npos) {
    take_range(text);
    if (!(low_ < high_) || !field.limits.holds(high_) ||
        !(field.limits.holds(low_) || (field.limits.min_excluded && low_ == field.limits.min)))
      throw UsageError("--keys " + text + ": the range must be ascending and within " + limits_text(field));
  }
  if (equals == std::string::npos && high_ > kWide * std::max(1.0, std::abs(recorded_))) narrow();
  if (field.limits.min_excluded && low_ <= field.limits.min) low_ = field.limits.min + 1e-6 * (high_ - low_);
  if (!std::isfinite(low_) || !std::isfinite(high_))
    throw UsageError("--keys " + key_ + ": it has no bounds; give a range, " + key_ + "=LOW:HIGH");
  if (whole_ && high_ - low_ < kMaxEnumerated)
    for (double v = std::ceil(low_); v <= high_; v += 1.0) values_.push_back(v);
  take_power();
}

void TuneKey::take_power() {
  const double share = (recorded_ - low_) / (high_ - low_);
  power_ = share > 0.0 && share < 1.0
               ? std::clamp(std::log(share) / std::log(0.5), 1.0 / kWidestPower, kWidestPower)
               : 3.0;
}

void TuneKey::take_range(const std::string& text) {
  const std::string range = text.substr(text.find('=') + 1);
  const std::size_t colon = range.find(':');
  if (colon == std::string::npos)
    throw UsageError("--keys " + text + ": a range LOW:HIGH is wanted after '='");
  low_ = number_in(range.substr(0, colon), text);
  high_ = number_in(range.substr(colon + 1), text);
}

void TuneKey::take_spacing(const std::string& text, const Experiment& e) {
  if (e.grid.pitch_x_mm != e.grid.pitch_y_mm || !e.part.image.empty() || !e.part.mesh.empty() ||
      prints_paths(e))
    throw UsageError("--keys " + key_ +
                     ": the spacing of droplets is tuned of parts of a plain shape on square cells");
  recorded_ = e.grid.pitch_x_mm;
  low_ = recorded_ / kSpacingFold;
  high_ = recorded_ * kSpacingFold;
  least_ = recorded_ / kSpacingMost;
  most_ = recorded_ * kSpacingMost;
  if (text.size() > key_.size()) take_range(text);
  if (!(low_ < high_) || low_ < least_ || high_ > most_)
    throw UsageError("--keys " + text +
                     ": the range must be ascending and within a half and twice the recorded " +
                     this->text(recorded_) + " mm");
  take_power();
}

// Bounds that only keep nonsense out are no range to search.
void TuneKey::narrow() {
  if (!(recorded_ > 0.0))
    throw UsageError("--keys " + key_ + ": its bounds are too wide to search; give a range, " + key_ +
                     "=LOW:HIGH");
  low_ = std::max(low_, recorded_ / kFold);
  high_ = kFold * recorded_;
}

double TuneKey::at(double u) const {
  const double value = low_ + (high_ - low_) * std::pow(std::clamp(u, 0.0, 1.0), power_);
  return whole_ ? std::round(value) : value;
}

double TuneKey::place(double value) const {
  return std::pow(std::clamp((value - low_) / (high_ - low_), 0.0, 1.0), 1.0 / power_);
}

void TuneKey::set(double value, Experiment& experiment) const {
  if (spacing()) {
    GridSpec& grid = experiment.grid;
    const double times = value / grid.pitch_x_mm;
    if (times == 1.0) return;
    grid.nx = std::int32_t(std::ceil(grid.nx / times));
    grid.ny = std::int32_t(std::ceil(grid.ny / times));
    grid.pitch_x_mm = grid.pitch_y_mm = value;
    for (double* h : {&experiment.model.h1_mm, &experiment.model.h2_mm, &experiment.model.h3_mm})
      *h /= times * times;
    return;
  }
  const std::vector<Field> table = fields(experiment);
  write_value(find(table, key_, experiment), value, words_);
}

bool TuneKey::at_open_end(double value) const {
  constexpr double kNear = 0.02;  // of the searched range
  if (!words_.empty()) return false;
  const double near = kNear * (high_ - low_);
  return (value <= low_ + near && low_ - least_ > near) || (value >= high_ - near && most_ - high_ > near);
}

std::string TuneKey::text(double value) const {
  if (!words_.empty()) return words_[std::size_t(std::lround(value))];
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

Setting recorded_setting(std::span<const TuneKey> keys) {
  Setting s;
  for (const TuneKey& k : keys) s.push_back(k.recorded());
  return s;
}

Experiment with_setting(std::span<const TuneKey> keys, const Setting& values, const Experiment& experiment) {
  Experiment e = experiment;
  for (std::size_t n = 0; n < keys.size(); ++n) keys[n].set(values[n], e);
  return parse_experiment(dump(e), "the setting " + text_of(keys, values));
}

std::string text_of(std::span<const TuneKey> keys, const Setting& values) {
  std::string s;
  for (std::size_t n = 0; n < keys.size(); ++n)
    s += (n ? ", " : "") + keys[n].key() + " = " + keys[n].text(values[n]);
  return s;
}

}  // namespace firn::tune
