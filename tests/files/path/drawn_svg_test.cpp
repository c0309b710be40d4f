// SVG drawings made by a generator: nested transforms, viewports, <use> and style sheets, against the shapes
// themselves.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <sstream>

#include "core/grid/random.h"
#include "files/path/path_file.h"
#include "tests/files/path/expected_drawing.h"
#include "tests/files/path/path_reader.h"

namespace firn {
namespace {

using test::Affine;

constexpr test::PathReader<read_paths_svg> read_drawn_svg{"drawn.svg"};

/// Writes a drawing and computes its curves.
class SvgMaker {
 public:
  explicit SvgMaker(std::uint64_t seed) : draw_(seed, Purpose::kTest) {}

  /// A page of 200 x 100 mm whose unit is half a millimetre.
  std::string text() {
    std::ostringstream body;
    body.precision(17);
    const Affine page{0.5, 0, 0, 0, -0.5, 100};
    for (int i = 0; i < 4; ++i) node(body, {page, true, true}, 0);
    return "<svg xmlns='http://www.w3.org/2000/svg' width='200mm' height='10cm' viewBox='0 0 400 200'>"
           "<style>/* drawn */ rect{fill:none} .hide,.gone{fill:none;stroke:none} g.off{display:none}\n"
           "g > .line{fill:none;stroke:red!important} #never{fill:red}</style>" +
           body.str() + "<style><![CDATA[" + sheet_ + "]]></style></svg>";
  }

  test::ExpectedDrawing expected;

 private:
  struct Place {
    Affine to_mm;
    bool shown = true, filled = true;  ///< by those around
  };

  double number(double low, double high) { return draw_.uniform(low, high); }

  /// Writes the start of an element with a random transform, as an attribute, a style or a rule.
  Affine transform(std::ostream& out, std::string& style) {
    const double degrees = number(-180.0, 180.0), angle = degrees * std::numbers::pi / 180.0,
                 c = std::cos(angle), s = std::sin(angle), x = number(-20.0, 20.0), y = number(-20.0, 20.0);
    const double sx = number(0.5, 1.5), sy = number(0.5, 1.5);
    std::ostringstream words;
    words.precision(17);
    switch (draw_.below(5)) {
      case 0:
        words << "translate(" << x << ' ' << y << ") rotate(" << degrees << ") scale(" << sx << ',' << sy
              << ')';
        out << " transform='" << words.str() << "'";
        return test::after({c, -s, x, s, c, y}, {sx, 0, 0, 0, sy, 0});
      case 1:
        words << "transform:rotate(" << angle << "rad);transform-origin:" << x << "px " << y << "px";
        style += words.str();
        return test::after(test::after({1, 0, x, 0, 1, y}, {c, -s, 0, s, c, 0}), {1, 0, -x, 0, 1, -y});
      case 2:
        words << "#n" << ++names_ << "{transform:translateX(" << x << "px) skewY(" << degrees / 4
              << "deg)}\n";
        sheet_ += words.str();
        out << " id='n" << names_ << "' transform='scale(9)'";
        return test::after({1, 0, x, 0, 1, 0}, {1, 0, 0, std::tan(angle / 4), 1, 0});
      case 3:
        out << " transform='matrix(" << sx << " 0.25 -0.5 " << sy << ' ' << x << ' ' << y << ")'";
        return {sx, -0.5, x, 0.25, sy, y};
      default:
        return {};
    }
  }

  void node(std::ostream& out, const Place& at, int depth) {
    switch (draw_.below(depth < 3 ? 7 : 3)) {
      case 0:
      case 1:
      case 2:
        return shape(out, at);
      case 3:
        return viewport(out, at, depth);
      case 4:
        return insert(out, at);
      default:
        return group(out, at, depth);
    }
  }

  void group(std::ostream& out, Place at, int depth) {
    std::string style;
    out << "<g";
    at.to_mm = test::after(at.to_mm, transform(out, style));
    const std::uint32_t kind = draw_.below(8);
    if (kind == 0) out << " class='other off'";
    if (kind == 1) style += ";opacity:0";
    if (kind == 2) out << " fill='none'";
    if (kind < 2) at.shown = false;
    if (kind == 2) at.filled = false;
    out << " style='" << style << "'>";
    const int n = 1 + int(draw_.below(3));
    for (int i = 0; i < n; ++i) node(out, at, depth + 1);
    out << "</g>";
  }

  /// An inner svg with a viewBox of its own, stretched.
  void viewport(std::ostream& out, Place at, int depth) {
    const double x = number(-9.0, 9.0), y = number(-9.0, 9.0), w = number(50.0, 150.0),
                 h = number(50.0, 150.0);
    out << "<svg overflow='visible' x='" << x << "' y='" << y << "' width='" << w << "' height='" << h
        << "' viewBox='10 20 100 80' preserveAspectRatio='none'>";
    at.to_mm = test::after(at.to_mm, {w / 100, 0, x - 10 * w / 100, 0, h / 80, y - 20 * h / 80});
    node(out, at, depth + 1);
    out << "</svg>";
  }

  void insert(std::ostream& out, Place at) {
    std::string style;
    const double x = number(-9.0, 9.0), y = number(-9.0, 9.0);
    ++names_;
    out << "<defs><g id='d" << names_ << "' stroke='#000'><path fill='none' d='M1 2 L30 40'/></g></defs>"
        << "<use href='#d" << names_ << "' x='" << x << "' y='" << y << "'";
    at.to_mm = test::after(at.to_mm, transform_of_use(out));
    out << "/>";
    if (at.shown) expected.add({at.to_mm({1 + x, 2 + y}), at.to_mm({30 + x, 40 + y})});
  }

  Affine transform_of_use(std::ostream& out) {
    const double k = number(0.5, 2.0);
    out << " transform='scale(" << k << ")'";
    return {k, 0, 0, 0, k, 0};
  }

  /// Writes how a shape is painted, of which the strongest counts, and returns whether it is.
  bool paint(std::ostream& out, const Place& at, bool is_rect, std::string& style) {
    bool filled = at.filled && !is_rect;
    if (draw_.below(3) == 0) {  // an attribute is weaker than the sheet's rect{}
      out << " fill='#abc'";
      filled = filled || !is_rect;
    }
    if (draw_.below(4) == 0) {
      out << " class='gone x'";
      filled = false;
    }
    if (draw_.below(4) == 0) {
      out << " id='f" << ++names_ << "'";
      sheet_ += "#f" + std::to_string(names_) + "{fill:rgb(1,2,3)}\n";
      filled = true;
    }
    if (draw_.below(4) == 0) {
      const bool none = draw_.below(2) != 0;
      style += none ? "fill:NONE;" : "fill:rgba(1,2,3,0.5);";
      filled = !none;
    }
    const std::uint32_t kind = draw_.below(8);
    if (kind == 0) style += "fill-opacity:0%;";
    if (kind == 1) style += "visibility:hidden;";
    return at.shown && filled && kind > 1;
  }

  void shape(std::ostream& out, const Place& at) {
    std::string style;
    const std::uint32_t kind = draw_.below(3);
    const double x = number(-40.0, 40.0), y = number(-40.0, 40.0), w = number(1.0, 30.0),
                 h = number(1.0, 30.0);
    out << (kind == 0 ? "<rect" : kind == 1 ? "<ellipse" : "<path");
    const bool shown = paint(out, at, kind == 0, style);
    if (kind == 0) {
      out << " x='" << x << "' y='" << y << "' width='" << w << "' height='" << h << "'";
      const std::vector<Point2> corners{{x, y}, {x + w, y}, {x + w, y + h}, {x, y + h}, {x, y}};
      std::vector<Point2> path;
      for (const Point2& p : corners) path.push_back(at.to_mm(p));
      if (shown) expected.add(path);
    } else if (kind == 1) {
      out << " cx='" << x << "' cy='" << y << "' rx='" << w << "' ry='" << h << "'";
      if (shown)
        expected.add(at.to_mm, [=](double t) {
          const double a = 2.0 * std::numbers::pi * t;
          return Point2{x + w * std::cos(a), y + h * std::sin(a)};
        });
    } else {
      out << " d='M" << x << ' ' << y << " c0 " << h << ' ' << w << ' ' << h << ' ' << w << " 0'";
      if (shown)
        expected.add(at.to_mm, [=](double t) {
          const double u = 1.0 - t;
          return Point2{x + w * (3.0 * t * t * u + t * t * t), y + h * (3.0 * t * u * u + 3.0 * t * t * u)};
        });
    }
    out << " style='" << style << "'/>";
  }

  RandomStream draw_;
  std::string sheet_;
  int names_ = 0;
};

}  // namespace

TEST_CASE(
    "Two hundred pages of nested shapes and styles have the count, length and bounding box of their shapes") {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SvgMaker maker(seed);
    const std::string text = maker.text();
    CAPTURE(seed, text);
    if (maker.expected.count == 0)
      CHECK(read_drawn_svg.refusal(text).find("holds no path") != std::string::npos);
    else
      CHECK(difference(read_drawn_svg(text), maker.expected) == "");
  }
}

}  // namespace firn
