// G-code of slicers, lasers, milling machines and printers' firmware: lengths as their makers meant them, or
// the reason.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "core/path/polyline.h"
#include "files/path/path_file.h"
#include "tests/files/path/path_reader.h"

namespace firn {
namespace {

constexpr test::PathReader<read_paths_gcode> read_foreign{"job.gcode"};

struct Case {
  const char* what;
  std::string text;
  std::vector<double> lengths_mm;
};

std::vector<double> lengths_of(const std::vector<InputPath>& paths) {
  std::vector<double> lengths;
  for (const InputPath& p : paths) lengths.push_back(path_length_mm(p.path.points, p.path.closed));
  return lengths;
}

void check(const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    CAPTURE(c.what, read_foreign.refusal(c.text));
    const std::vector<double> lengths = lengths_of(read_foreign(c.text));
    REQUIRE(lengths.size() == c.lengths_mm.size());
    for (std::size_t n = 0; n < lengths.size(); ++n)
      CHECK(lengths[n] == Approx(c.lengths_mm[n]).epsilon(1e-3));  // arcs: the chords of their samples
  }
}

const std::string kLine = "G90\nG21\nG0 X10 Y10\n";
constexpr double kPi = std::numbers::pi;

}  // namespace

TEST_CASE("In a file whose moves bear E, a move without a growing E is travel") {
  check({
      {"relative E", "M83\nG1 X10 F600\nG1 X30 E1\nG1 X60\nG1 X80 E1\n", {20, 20}},
      {"absolute E", "M82\nG1 X10\nG1 X30 E1\nG1 X60 E1\nG1 X80 E2\n", {20, 20}},
      {"absolute E without M82", "G1 X10\nG1 X30 E1.5\nG1 X60\nG1 X80 E2\n", {20, 20}},
      {"G92 E0 counts anew", "M82\nG1 X10\nG1 X30 E5\nG92 E0\nG1 X50 E1\nG1 X60 E0\n", {40}},
      {"a retraction ends a path", "M83\nG1 X10\nG1 X30 E1\nG1 E-1\nG1 E1\nG1 X40 E1\n", {20, 10}},
      {"a wipe is travel", "M83\nG1 X10\nG1 X30 E1\nG1 X25 E-.4\nG1 X0\nG1 X5 E1\n", {20, 5}},
      {"an absolute wipe is travel",
       "M82\nG1 X10\nG1 X30 E9\nG1 X25 E8.6\nG1 X0\nG1 E9\nG1 X5 E9.1\n",
       {20, 5}},
      {"M83 holds in spite of G90", "M83\nG90\nG1 X10\nG1 X30 E.5\nG1 X50 E.5\n", {40}},
      {"G91 makes E relative", "M82\nG1 X10 E1\nG91\nG1 X20 E1\nG1 X5\nG90\nG1 X0 E2.5\n", {30, 35}},
      {"G0 may deposit", "M83\nG0 X10\nG0 X30 E1\n", {20}},
      {"firmware retraction", "M83\nG1 X10\nG1 X30 E1\nG10\nG1 X60\nG11\nG1 X80 E1\n", {20, 20}},
      {"arcs deposit, too",
       "M83\nG1 X10 Y0\nG3 X-10 Y0 I-10 J0 E3\nG2 X10 Y0 I10 J0\nG1 X11 E1\n",
       {10 * kPi, 1}},
      {"end code", "M83\nG1 X10\nG1 X30 E1\nG1 E-5\nG28 X Y\nM84\n", {20}},
      {"a change of the tool ends a path", "M83\nT0\nG1 X10\nG1 X30 E1\nT1\nG1 X40 E1\n", {20, 10}},
      {"travel may climb", "M83\nG1 X10 Z.2\nG1 X30 E1\nG1 X60 Z.6\nG1 Z.2\nG1 X80 E1\n", {20, 20}},
      {"a compact file", "M83\nG1X10Y0\nG1X30Y0E1\nG1X60\nG1X80E1.5\n", {20, 20}},
      {"an exponent behind E", "M83\nG1 X10\nG1 X30 E1e-05\nG1 X60 E0\n", {20}},
      {"milling words in a printer's file", "M83\nM3 S0\nG1 X10\nG1 X30 E1\nM5\nG1 X40 E1\n", {30}},
  });
}

TEST_CASE("A beam that is off deposits nothing: S0, M5, G0") {
  check({
      {"S0", kLine + "M4 S0\nG1 X30 S800\nG1 X60 S0\nG1 X80 S800\nM5\n", {20, 20}},
      {"M5", kLine + "M3 S500\nG1 X30\nM5\nG1 X60\nM3\nG1 X80\nM5\n", {20, 20}},
      {"S stays through G0", kLine + "M4\nG1 X30 S80\nG0 X60\nG1 X80\n", {20, 20}},
      {"S of a G0 holds for what follows", kLine + "M4\nG0 X20 S80\nG1 X30\n", {10}},
      {"M3 without any S", kLine + "M3\nG1 X30\nM5\nG1 X40\n", {20}},
      {"a spindle that turns all the time", kLine + "S1000 M3\nG1 X30\nG0 X40\nG1 X60\nM5\n", {20, 20}},
      {"S without M3 or M4", kLine + "G1 X30 S255\nG1 X60 S0\nG1 X80 S255\n", {20, 20}},
      {"S alone on a line", kLine + "M3\nS800\nG1 X30\nS0\nG1 X60\n", {20}},
      {"S of other commands is no power",
       kLine + "M3 S9\nG1 X30\nM106 S0\nG1 X40\nG4 S0\nG1 X50\n",
       {30, 10}},
      {"inline power", kLine + "M3 I\nG1 X30 S80\nM5 I\nG1 X40\n", {20}},
      {"no beam at all", kLine + "G1 X30\nG1 X60\n", {50}},
  });
}

TEST_CASE("Known flags need no number, commands of the firmware are passed over, other words are named") {
  const std::vector<Case> cases{
      {"home flags", "G28 X Y\nG28 Z\n" + kLine + "G1 X30\n", {20}},
      {"home flags without blanks", "G28 XY\nG28 W\n" + kLine + "G1 X30\n", {20}},
      {"Klipper",
       "START_PRINT BED=60 NAME=a_1\n_START\nSET_VELOCITY_LIMIT ACCEL=3\n" + kLine + "G1 X30\n",
       {20}},
      {"Klipper's states",
       "M83\nG1 X10\nSAVE_GCODE_STATE NAME=a\nG91\nG1 X5\nRESTORE_GCODE_STATE NAME=a\nG1 X30 E1\n",
       {15}},
      {"Prusa's prompts", "Tx\nT?\nTc\n" + kLine + "G1 X30\n", {20}},
      {"senders' commands", "$H\n$32=1\n@pause\n" + kLine + "G1 X30\n", {20}},
      {"G53", "G53 G0 Z0\n" + kLine + "G43 Z15 H1\nG1 Z0 F100\nG1 X30 F600\nG53 G0 Z0\nM30\n", {20}},
      {"G53 loses the place", kLine + "G1 X30\nG53 G0 X0 Y0\nG0 X50 Y10\nG1 X60\n", {20, 10}},
      {"one coordinate system", "G55\n" + kLine + "G1 X30\nG55\nG1 X40\n", {30}},
      {"a probe", "G38.2 Z-9 F5\nG92 Z0\n" + kLine + "G1 X30\n", {20}},
      {"tool temperatures", "G10 P0 S200 R150\n" + kLine + "G1 X30\n", {20}},
      {"bed levelling of a printer", "M83\nG28\nG29 A\nG1 X10 Y10\nG1 X30 E1\n", {20}},
      {"lower case, line numbers, checksums", "n1 g90*3\nN2 g0 x10 y10*7\nn3 g1 x30 (mm) y10 ; end\n", {20}},
      {"comments of two strokes", "// made by hand\nG0 X1 // here\nG1 X3\n", {2}},
      {"text of M117 and M0", "M117 G1 X99 (\n" + kLine + "M0 Press G1 now\nG1 X30\n", {20}},
      {"a slicer's long settings", "; start = " + std::string(20000, 'x') + "\n" + kLine + "G1 X30\n", {20}},
      {"lines that end with CR", "G0 X1\rG1 X3\r\rG0 X9\rG1 X10\r", {2, 1}},
      {"UTF-16",
       std::string("G\0"
                   "0\0X\0"
                   "1\0\n\0G\0"
                   "1\0X\0"
                   "5\0\n\0",
                   20),
       {4}},
  };
  check(cases);
  const auto refused = [](const std::string& text, const std::string& reason) {
    CAPTURE(text);
    CHECK_THAT(read_foreign.refusal(text), Catch::Contains(reason));
  };
  refused("G1 X Y5\n", "job.gcode:1: X Y5: X must be followed by a finite number");
  refused("G0 X0\nG1 X1\nG55\nG1 X2\n", "job.gcode:3: G55: a second coordinate system");
  refused("G10 L2 P1 X5\nG1 X1\n", "job.gcode:1: G10 L2 sets the zero of a coordinate system");
  refused("G53 G1 X5\n", "job.gcode:1: G53 with a move that deposits");
  refused("G92\nG1 X1\n", "G92 without a coordinate");
  refused("G81 X1 Z-1\n", "G81 (a drilling cycle) is not known here");
  refused("IF [#1 LT 5] GOTO 10\n", "IF: variables, branches and loops are not read");
  refused("WHILE [#1 LT 5] DO1\n", "WHILE: variables");
  refused("var x = 5\nG1 X1\n", "VAR: variables");
  refused("M62 P1 G1 X5\n", "M62 with a G code behind it");
  refused("M83\nG1 X10 E0\n", "no move in X and Y has a growing E");
  refused("M3 S0\nG1 X10\n", "no G1, G2, G3 or G5 comes while M3 or M4 holds and S is above 0");
  refused("START_PRINT\nM104 S200\n",
          "holds no path: a G1, G2, G3 or G5 is needed; passed over: M104, START_PRINT");
}

TEST_CASE(
    "A number that goes on is refused with its text, and an exponent is read where no axis E is possible") {
  check({
      {"exponents of programs", kLine + "G1 X1e-05 F1.2e+03\nG1 X2.5e1\n", {35}},
      {"upper case", kLine + "G1 X2.5E+01\n", {15}},
  });
  const auto refused = [](const std::string& text, const std::string& reason) {
    CAPTURE(text);
    CHECK_THAT(read_foreign.refusal(text), Catch::Contains(reason));
  };
  refused("G1 X1,5\n", "job.gcode:1: X1,5 is no number: it goes on with ','");
  refused("G1 X1.5.2\n", "X1.5.2 is no number: it goes on with '.'");
  refused("G1 X10 20\n", "20: a number without its letter");
  refused("G1 X--5\n", "X--5: X must be followed by a finite number");
  refused("G0 X0\nG1X10Y5E1\n", "Y5E1 is an exponent or a word E");
  refused("M83\nG1 X5 E1\nG1 X1e-05 E1\n", "job.gcode:3: X1e-05 is an exponent or a word E");
}

TEST_CASE("A full circle is one whose ends coincide within the file's last decimal") {
  check({
      {"equal ends", "G0 X10 Y0\nG2 X10 Y0 I-10\n", {20 * kPi}},
      {"no end", "G0 X10 Y0\nG3 I-10 J0\n", {20 * kPi}},
      {"rounded to 3 decimals", "G0 X0.001 Y0\nG2 X0 Y0 I5 J0\n", {10 * kPi}},
      {"rounded to 2 decimals", "G0 X5.01 Y0.01\nG3 X5 Y0 I-5 J0\n", {10 * kPi}},
      {"rounded in inches", "G20 G0 X0.0001 Y0\nG2 X0 Y0 I1 J0\n", {2 * 25.4 * kPi}},
      {"a short arc of whole numbers", "G0 X0 Y0\nG3 X1 Y1 I0 J1\n", {kPi / 2}},
      {"a short arc of a large radius", "G0 X0.000 Y0\nG3 X0.500 Y0 I0.250 J1000\n", {0.5}},
      {"a half circle by R", "G0 X0 Y0\nG2 X10 Y0 R5\n", {5 * kPi}},
  });
  const auto refused = [](const std::string& text, const std::string& reason) {
    CAPTURE(text);
    CHECK_THAT(read_foreign.refusal(text), Catch::Contains(reason));
  };
  refused("G0 X10 Y0\nG2 X10 Y0 R5\n", "a full circle of R5 has no known centre");
  refused("G0 X0.001 Y0\nG2 X0 Y0 R-5\n", "a full circle of R-5 has no known centre");
}

TEST_CASE("200 drawn files of slicers and lasers have the length with which they were built") {
  for (std::uint32_t n = 0; n < 200; ++n) {
    RandomStream random(4700 + n, Purpose::kTest);
    const bool laser = n % 4 == 3, relative = n % 2 == 0, compact = n % 3 == 0, wipes = n % 5 < 3;
    const std::string gap = compact && !laser ? "" : " ";
    std::string text = laser ? "G21\nG90\nM4 S0\n" : relative ? "M83\nG90\n" : "M82\nG92 E0\n";
    char word[80];
    double x = 0, y = 0, e = 0, built_mm = 0, travel_mm = 0;
    std::size_t built = 0;
    const auto number = [&](const char* format, double value) {
      std::snprintf(word, sizeof word, format, value);
      text += gap + word;
      return std::strtod(word + 1, nullptr);
    };
    const auto feed = [&](double amount) {
      e += amount;
      number("E%.5f", relative ? amount : e);
    };
    const auto move = [&](const char* code) {
      text += code;
      const double from_x = x, from_y = y;
      x = number("X%.3f", random.below(100000) * 1e-3);
      y = number("Y%.3f", random.below(100000) * 1e-3);
      return std::hypot(x - from_x, y - from_y);
    };
    for (std::uint32_t path = 0, paths = 1 + random.below(8); path < paths; ++path) {
      travel_mm += move(random.below(2) ? "G0" : "G1");
      if (laser) text += " S0";
      text += "\n";
      if (!laser) {
        text += "G1";
        feed(0.8);
        text += "\n";
      }
      for (std::uint32_t k = 1 + random.below(6); k > 0; --k) {
        const double length = move("G1");
        built_mm += length;
        if (laser)
          number("S%.0f", 100.0 + random.below(900));
        else
          feed(0.01 + 0.04 * length);
        text += random.below(4) ? "\n" : "\nM106 S127 ; fan\n";
      }
      ++built;
      if (!laser && wipes) {
        travel_mm += move("G1");
        feed(-0.3);
        text += "\n";
      }
      if (!laser) {
        text += "G1";
        feed(-0.5);
        text += "\n";
      }
    }
    text += laser ? "M5\nG0 X0 Y0\n" : "M107\nEND_PRINT\n";
    travel_mm += laser ? std::hypot(x, y) : 0.0;
    CAPTURE(n, text);
    double read_travel_mm = -1.0;
    std::vector<InputPath> paths;
    std::istringstream in(text);
    read_paths_gcode(in, "drawn", double(text.size()),
                     PathSink([&](InputPath&& p) { paths.push_back(std::move(p)); },
                              [](const std::string&) {}, [&](double mm) { read_travel_mm = mm; }));
    double read_mm = 0.0;
    for (const double length : lengths_of(paths)) read_mm += length;
    REQUIRE(paths.size() == built);
    REQUIRE(std::abs(read_mm - built_mm) < 1e-6);
    REQUIRE(std::abs(read_travel_mm - travel_mm) < 1e-6);
  }
}

}  // namespace firn
