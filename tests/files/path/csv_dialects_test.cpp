// CSV path files as spreadsheets, NumPy, pandas and instruments write them.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "core/path/polyline.h"
#include "files/path/path_file.h"
#include "tests/files/path/path_reader.h"

namespace firn {
namespace {

constexpr test::PathReader<read_paths_csv> read_dialect{"job.csv"};

std::string utf16(const std::string& ascii, bool big, bool mark) {
  std::string text = !mark ? "" : big ? "\xfe\xff" : "\xff\xfe";
  for (const char c : ascii) {
    text += big ? '\0' : c;
    text += big ? c : '\0';
  }
  return text;
}

struct Dialect {
  const char* separator;
  bool decimal_comma;
};
constexpr Dialect kDialects[] = {{",", false}, {";", false}, {";", true},    {"\t", false}, {"\t", true},
                                 {" ", false}, {" ", true},  {"   ", false}, {", ", false}};

}  // namespace

TEST_CASE("One path of 25.25 mm is read from every dialect of CSV") {
  const std::string plain = "x_mm,y_mm\n0,0\n10,0\n10,5\n0.25,5\n0.25,4.5\n";
  const std::vector<std::pair<const char*, std::string>> files{
      {"plain", plain},
      {"no header", "0,0\n10,0\n10,5\n0.25,5\n0.25,4.5\n"},
      {"decimal commas between semicolons", "0,0;0,0\n10,0;0\n10;5\n0,25;5,0\n0,25;4,5\n"},
      {"decimal commas between blanks", "0,0 0,0\n10,0 0,0\n10,0 5,0\n0,25 5,0\n0,25 4,5\n"},
      {"decimal commas between tabs", "x_mm\ty_mm\n0\t0\n10\t0\n10\t5\n0,25\t5\n0,25\t4,5\n"},
      {"a header between blanks", "x_mm y_mm\n0 0\n10 0\n10 5\n0.25 5\n0.25 4.5\n"},
      {"units between blanks", "X [mm]  Y [mm]\n0 0\n10 0\n10 5\n0.25 5\n0.25 4.5\n"},
      {"all quoted",
       "\"x_mm\",\"y_mm\"\n\"0\",\"0\"\n\"10\",\"0\"\n\"10\",\"5\"\n\"0.25\",\"5\"\n\"0.25\",\"4.5\"\n"},
      {"quoted decimal commas",
       "\"x_mm\";\"y_mm\"\n\"0,0\";\"0,0\"\n10;0\n10;5\n\"0,25\";5\n\"0,25\";\"4,5\"\n"},
      {"comments", "# made\n% here\n" + plain + "# end\n"},
      {"a comment in a path", "x_mm,y_mm\n0,0\n10,0\n # half\n10,5\n0.25,5\n0.25,4.5\n"},
      {"names in a comment", "# y_mm x_mm\n0.0 0.0\n0.0 10.0\n5.0 10.0\n5.0 0.25\n4.5 0.25\n"},
      {"savetxt",
       "0.000e+00 0.000e+00\n1.000e+01 0.000e+00\n1.000e+01 5.000e+00\n2.5e-01 5.0e+00\n2.5e-01 4.5e+00\n"},
      {"plus signs", "+0,+0\n+10,+0\n+10,+5\n+0.25,+5\n+0.25,+4.5\n"},
      {"sep=", "sep=;\nx_mm;y_mm\n0;0\n10;0\n10;5\n0,25;5\n0,25;4,5\n"},
      {"quoted sep=", "\"sep=,\"\n" + plain},
      {"an index of pandas", ",x_mm,y_mm\n0,0,0\n1,10,0\n2,10,5\n3,0.25,5\n4,0.25,4.5\n"},
      {"an index that was read once", "Unnamed: 0,x_mm,y_mm\n0,0,0\n1,10,0\n2,10,5\n3,0.25,5\n4,0.25,4.5\n"},
      {"separators at the ends", "x_mm,y_mm,\n0,0,\n10,0,\n10,5,\n0.25,5,\n0.25,4.5,\n"},
      {"names without units", "X,Y\n0,0\n10,0\n10,5\n0.25,5\n0.25,4.5\n"},
      {"units after strokes", "x/mm,y/mm\n0,0\n10,0\n10,5\n0.25,5\n0.25,4.5\n"},
      {"micrometres", "x [\xc2\xb5m];y (um)\n0;0\n10000;0\n10000;5000\n250;5000\n250;4500\n"},
      {"rows of separators alone", "x_mm,y_mm\n,\n0,0\n10,0\n10,5\n0.25,5\n0.25,4.5\n,\n,\n"},
      {"CR", "x_mm,y_mm\r0,0\r10,0\r10,5\r0.25,5\r0.25,4.5\r"},
      {"CR CR LF", "x_mm,y_mm\r\r\n0,0\r\r\n10,0\r\r\n10,5\r\r\n0.25,5\r\r\n0.25,4.5\r\r\n"},
      {"UTF-8 with its mark", "\xef\xbb\xbf" + plain},
      {"UTF-16 of little end", utf16(plain, false, true)},
      {"UTF-16 of big end", utf16(plain, true, true)},
      {"UTF-16 without a mark", utf16(plain, false, false)},
  };
  for (const auto& [what, text] : files) {
    CAPTURE(what, read_dialect.refusal(text));
    const auto paths = read_dialect(text);
    REQUIRE(paths.size() == 1);
    REQUIRE(paths[0].path.points.size() == 5);
    CHECK(path_length_mm(paths[0].path.points, false) == Approx(25.25).epsilon(1e-12));
    CHECK(paths[0].path.points[2] == Point2{10, 5});
  }
}

TEST_CASE("Every refusal of a table names its own cause") {
  const auto refused = [](const std::string& text, const std::string& reason) {
    CAPTURE(text);
    CHECK_THAT(read_dialect.refusal(text), Catch::Contains(reason));
  };
  refused("x_mm,speed\n", "column 'speed' names no unit: there are mm_s");
  refused("x [ell],y_mm\n1,2\n", "column 'x [ell]' names an unknown unit: there are mm, um");
  refused("x_mm,y_mm\n1.5,zwei\n", "job.csv:2: y_mm = zwei: is not a finite number");
  refused("x_mm,y_mm\n1,2\n0,5,3,5\n",
          "job.csv:3: 4 columns, the header has 2; numbers with decimal commas need");
  refused("x_mm;y_mm\n1.5;2\n1,5;2\n",
          "job.csv:3: x_mm = 1,5: line 2 has a decimal point, line 3 a decimal comma");
  refused("x_mm;y_mm\n1.234,5;2\n", "x_mm = 1.234,5: has a point and a comma");
  refused("x_mm,y_mm\n2.5mm,1\n", "x_mm = 2.5mm: is not a finite number");
  refused("x_mm,y_mm\n\"1,2\n", "job.csv:2: a quote without end");
  refused(",0,1\n0,1.5,2\n1,3,4\n", "as pandas' to_csv does: name the columns");
  refused("# nothing\n\n", "is empty");
}

TEST_CASE("200 drawn tables have the points with which they were built, in any dialect") {
  for (std::uint32_t n = 0; n < 200; ++n) {
    RandomStream random(4747 + n, Purpose::kTest);
    const Dialect& dialect = kDialects[n % std::size(kDialects)];
    const bool named = random.below(2), quoted = random.below(3) == 0, comments = random.below(2);
    const char* const ends[] = {"\n", "\r\n", "\r"};
    const std::string end = ends[random.below(3)];
    std::vector<std::vector<Point2>> built(1 + random.below(4));
    std::string text = named ? std::string("x_mm") + dialect.separator + "y_mm" + end : "";
    for (auto& path : built) {
      for (std::uint32_t k = 2 + random.below(20); k > 0; --k) {
        Point2 p;
        const auto number = [&](double& value) {
          char word[40];
          std::snprintf(word, sizeof word, random.below(4) ? "%.3f" : "%.6e",
                        (double(random.below(200000)) - 1e5) * 1e-3);
          value = std::strtod(word, nullptr);
          std::string shown = word;
          if (dialect.decimal_comma) shown[shown.find('.')] = ',';
          text += quoted ? '"' + shown + '"' : shown;
        };
        number(p.x_mm);
        text += dialect.separator;
        number(p.y_mm);
        text += end;
        if (comments && random.below(5) == 0) text += "# note; with, all\tseparators" + end;
        path.push_back(p);
      }
      text += end;
    }
    const std::string file = n % 7 == 6   ? utf16(text, n % 2, true)
                             : n % 7 == 5 ? "\xef\xbb\xbf" + text
                                          : text;
    CAPTURE(n, text, read_dialect.refusal(file));
    const auto paths = read_dialect(file);
    REQUIRE(paths.size() == built.size());
    for (std::size_t k = 0; k < built.size(); ++k) REQUIRE(paths[k].path.points == built[k]);
  }
}

}  // namespace firn
