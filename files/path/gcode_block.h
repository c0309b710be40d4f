// GcodeBlock holds one line of G-code as words: a letter and its number. read_gcode_block() reads it as
// RS-274, as printers' firmware and as Klipper write it.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

/// Meaning of an e behind digits: an exponent, as in X1e-05, or the word E of an extruder, as in X1E5.
enum class GcodeExponent { kUnknown, kExponent, kWordE };

struct GcodeBlock {
  std::vector<double> g, m;  ///< codes, in their order
  std::array<std::optional<double>, 26> of{};
  std::array<bool, 26> flag{};  ///< letters without a number: G28 X Y
  std::string flag_text;        ///< from the first of them on, for messages
  /// A command of the firmware that is passed over, with its own words: "M104", "START_PRINT", "$32".
  std::string command;
  std::string_view arguments;  ///< behind a command, valid as long as the line is
  bool percent = false;        ///< the mark before and behind a program
  bool empty = true;           ///< nothing but comments
  bool e_axis = false;         ///< an E that is no exponent
  int decimals = 0;            ///< the most of a coordinate

  std::optional<double>& operator[](char letter) { return of[std::size_t(letter - 'A')]; }
  const std::optional<double>& operator[](char letter) const { return of[std::size_t(letter - 'A')]; }
  bool has_g(double code) const;
  bool has_m(double code) const;
};

/// @param fail throws an error with the given problem @throws the error of `fail`
GcodeBlock read_gcode_block(std::string_view line, GcodeExponent exponent,
                            const std::function<void(const std::string&)>& fail);

}  // namespace firn
