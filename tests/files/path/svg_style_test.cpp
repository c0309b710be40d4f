// Which shapes of an SVG are drawn, and where: style sheets, painting, CSS transforms, lengths, <use>,
// <switch>.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "files/path/path_file.h"
#include "tests/files/path/path_reader.h"

namespace firn {
namespace {

constexpr test::PathReader<read_paths_svg> styled{"part.svg"};

std::string hundred(const std::string& content) {
  return "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' width='100mm' "
         "height='100mm' viewBox='0 0 100 100'>" +
         content + "</svg>";
}

/// Ends of the paths on a page of 100 x 100 mm whose unit is a millimetre.
std::vector<Point2> last_points(const std::string& content) {
  std::vector<Point2> out;
  for (const InputPath& p : styled(hundred(content))) out.push_back(p.path.points.back());
  return out;
}

std::size_t paths_on(const std::string& content) { return last_points(content).size(); }

/// Number of paths of a page that has a stroked line besides, which no rule for paths or fills hides.
std::size_t drawn(const std::string& content) {
  return paths_on(content + "<line x2='1' stroke='red'/>") - 1;
}

std::string refused_as(const std::string& content) { return styled.refusal(hundred(content)); }

bool are_near(Point2 a, Point2 b) { return distance(a, b) < 1e-9; }

}  // namespace

TEST_CASE("A shape is drawn if it is filled or stroked, and nothing around it hides it") {
  const char* kHidden[] = {"fill='none'",
                           "fill='none' stroke='none'",
                           "style='fill:none;stroke:none'",
                           "fill='none' stroke='red' stroke-width='0'",
                           "fill='none' stroke='red' stroke-opacity='0'",
                           "fill-opacity='0'",
                           "opacity='0%'",
                           "fill='transparent'",
                           "fill='rgba(1, 2, 3, 0)'",
                           "fill='rgb(1 2 3 / 0%)'",
                           "fill='#12345600'",
                           "fill='currentColor' color='transparent'",
                           "display='none'",
                           "visibility='hidden'",
                           "transform='scale(0)'"};
  for (const char* attributes : kHidden) {
    INFO(attributes);
    CHECK(drawn(std::string("<path d='M0 0H9' ") + attributes + "/>") == 0);
    CHECK(drawn(std::string("<g ") + attributes + "><path d='M0 0H9'/></g>") == 0);
  }
  const char* kShown[] = {"",
                          "fill='none' stroke='red'",
                          "fill='#fff'",
                          "fill='none' stroke='currentColor'",
                          "opacity='0.01'",
                          "style='display:inline'",
                          "fill='#12345601'"};
  for (const char* attributes : kShown) {
    INFO(attributes);
    CHECK(drawn(std::string("<path d='M0 0H9' ") + attributes + "/>") == 1);
  }
}

TEST_CASE("Hidden and unpainted shapes are counted in a note") {
  const auto notes =
      styled.notes(hundred("<path d='M0 0H9'/><path fill='none' d='M0 0H9'/><g display='none'/>"));
  REQUIRE(notes.size() == 1);
  CHECK(notes[0] == "part.svg: 2 hidden, or neither filled nor stroked");
  CHECK(refused_as("<path fill='none' d='M0 0H9'/>").find("holds no path that is drawn: 1 hidden") !=
        std::string::npos);
}

TEST_CASE(
    "Of several rules the important, then the inline, then the most specific, then the last one counts") {
  const auto shows = [](const std::string& sheet, const std::string& attributes) {
    return drawn("<style>" + sheet + "</style><g class='outer'><path d='M0 0H9' " + attributes + "/></g>") ==
           1;
  };
  CHECK_FALSE(shows("path{fill:none}", ""));
  CHECK_FALSE(shows("path{fill:none}", "fill='red'"));
  CHECK_FALSE(shows("*{fill:none}", "fill='red'"));
  CHECK(shows("path{fill:none}", "style='fill:red'"));
  CHECK_FALSE(shows("path{fill:none!important}", "style='fill:red'"));
  CHECK(shows("path{fill:none ! important}", "style='fill:red !important'"));
  CHECK(shows(".a{fill:red} path{fill:none}", "class='a'"));
  CHECK(shows("#i{fill:red} .a.b{fill:none}", "class='a b' id='i'"));
  CHECK_FALSE(shows(".a.b{fill:none} .a{fill:red}", "class=' b  a '"));
  CHECK_FALSE(shows(".a{fill:red} .b{fill:none}", "class='a b'"));
  CHECK_FALSE(shows("rect, path {fill:none}", ""));
  CHECK_FALSE(shows("g path{fill:none}", ""));
  CHECK_FALSE(shows("svg>.outer > path{fill:none}", ""));
  CHECK(shows("svg > path{fill:none}", ""));
  CHECK(shows("g g path{fill:none}", ""));
  CHECK_FALSE(shows(".outer{fill:none}", ""));
  CHECK(shows(".outer{fill:none}", "fill='initial'"));
  CHECK_FALSE(shows(".outer{fill:none} path{fill:inherit}", "fill='red'"));
  CHECK(shows("PATH{fill:none}", ""));
  CHECK(shows("path:hover{fill:none}", ""));
  CHECK_FALSE(shows("@media screen{path{fill:none}}", ""));
  CHECK_FALSE(shows("@font-face{font-family:x;src:url(a;b)} /* path{} */ path{fill:none}", ""));
  CHECK_FALSE(shows("<!-- path{fill:none} -->path{FILL : none}", ""));
}

TEST_CASE("A style sheet that is not read is named where it decides what is drawn") {
  const auto names = [](const std::string& sheet, const std::string& words) {
    const std::string text = refused_as("<path d='M0 0H9'/>\n<style>" + sheet + "</style>");
    INFO(text);
    CHECK(text.find("part.svg:2: style: \"") == 0);
    CHECK(text.find(words) != std::string::npos);
  };
  names("path:nth-child(2){fill:none}", "\"path:nth-child(2)\" is not read, but sets fill");
  names("[id]{display:none}", "sets display");
  names("a + path{stroke:none}", "sets stroke");
  names("@import url(a.css);", "@import url(a.css)");
  names("@media print{path{fill:none}}", "@media print");
  names("path{fill:var(--a)}", "var()");
  names("g{path{fill:none}}", "a rule within a rule");
  CHECK(
      drawn("<style>path:nth-child(2){font-size:3px} @media print{text{font:x}}</style><path d='M0 0H9'/>") ==
      1);
  CHECK(styled.refusal("<?xml-stylesheet href='a.css'?><svg><path d='M0 0H9'/></svg>").find("another file") !=
        std::string::npos);
}

TEST_CASE("Transforms of styles have units, and leave their origin in place") {
  const auto end = [](const std::string& attributes) {
    return last_points("<path d='M10 10H30' " + attributes + "/>").at(0);
  };
  CHECK(are_near(end("style='transform:translate(20px,0px) scale(2)'"), {80, 80}));
  CHECK(are_near(end("style='transform:rotate(.25turn)'"), {-10, 70}));
  CHECK(are_near(end("style='transform:translate(10%, 5mm)'"), {40, 90 - 5 * 96 / 25.4}));
  CHECK(are_near(end("transform='rotate(90)' transform-origin='20 20'"), {30, 70}));
  CHECK(are_near(end("transform='rotate(90)' style='transform-origin:center'"), {90, 70}));
  CHECK(are_near(end("transform='scale(2)' transform-origin='right top'"), {-40, 80}));
  CHECK(are_near(end("transform='scale(2)' transform-origin='top right'"), {-40, 80}));
  CHECK(are_near(end("transform='scale(2)' style='transform:none'"), {30, 90}));
  const auto names = [](const std::string& attributes, const std::string& words) {
    const std::string text = refused_as("<path d='M10 10H30' " + attributes + "/>");
    INFO(text);
    CHECK(text.find(words) != std::string::npos);
  };
  names("style='transform:translate(20,0)'", "needs its unit");
  names("style='transform:rotate(20)'", "needs its unit");
  names("style='transform:rotate3d(1,0,0,20deg)'", "'rotate3d'");
  names("style='rotate:20deg'", "rotate is not read");
  names("transform='translate(2.5mm)'", "not 'mm)'");
  names("transform='scale(2)' style='transform-box:fill-box'", "transform-box = fill-box");
}

TEST_CASE("Lengths have units, and percentages are of the page or the viewport") {
  const auto corner = [](const std::string& attributes) {
    const auto paths =
        styled("<svg width='200mm' height='100mm' viewBox='0 0 200 100'><rect " + attributes + "/></svg>");
    return paths.at(0).path.points.at(2);
  };
  CHECK(are_near(corner("width='100%' height='50%'"), {200, 50}));
  CHECK(are_near(corner("x='25%' y='10%' width='5' height='5'"), {55, 85}));
  CHECK(are_near(corner("width='1in' height='1'"), {96, 99}));
  CHECK(are_near(corner("style='width:30px;height:10px' width='99' height='9'"), {30, 90}));
  const auto circle = styled("<svg viewBox='0 0 30 40'><circle r='10%'/></svg>");
  CHECK(are_near(circle.at(0).path.points.at(0), {3.5355339059327378 * 25.4 / 96, 40 * 25.4 / 96}));
  const auto sized =
      styled("<svg style='width:100mm;height:100mm' viewBox='0 0 200 200'><path d='M0 0H20'/></svg>");
  CHECK(are_near(sized.at(0).path.points.back(), {10, 100}));
}

TEST_CASE("A number that goes on is refused with its text") {
  const auto names = [](const std::string& shape, const std::string& words) {
    const std::string text = refused_as(shape);
    INFO(text);
    CHECK(text.find("part.svg:1: ") == 0);
    CHECK(text.find(words) != std::string::npos);
  };
  names("<rect x='2,5' width='1' height='1'/>", "x = \"2,5\"");
  names("<rect width='2.5 mm' height='1'/>", "width = \"2.5 mm\"");
  names("<rect width='2.5m' height='1'/>", "width = \"2.5m\"");
  names("<circle r='1e'/>", "r = \"1e\"");
  names("<line x2='1;5'/>", "x2 = \"1;5\"");
  names("<circle r='2em'/>", "em, rem, ex");
  names("<rect style='width:5' width='2' height='1'/>", "width = \"5\"");
  names("<rect width='-5' height='1'/>", "must not be below 0");
  names("<polygon points='1,2 3mm,4'/>", "not 'mm,4'");
  names("<path d='M1 2 L3,5mm'/>", "a finite number is needed");
  names("<path opacity='0,5' d='M0 0H9'/>", "opacity = \"0,5\"");
}

TEST_CASE("A use draws the element again, at its place and with its paint") {
  const std::string square = "<defs><path id='a' d='M10 10h20'/></defs>";
  const auto ends = last_points(square + "<use xlink:href='#a' x='30' transform='scale(2)'/>");
  REQUIRE(ends.size() == 1);
  CHECK(are_near(ends[0], {120, 80}));
  CHECK(drawn(square + "<use href='#a' fill='none'/>") == 0);
  CHECK(drawn("<g id='b'><path d='M0 0H9'/></g><use href='#b'/><g display='none'><use href='#b'/></g>") == 2);
  const std::string symbol =
      "<symbol id='s' viewBox='0 0 10 10'><path d='M0 0H10'/></symbol><use href='#s' x='5' width='40' "
      "height='20'/>";
  CHECK(are_near(last_points(symbol).at(0), {35, 100}));
  CHECK(refused_as("<use href='#gone'/>").find("\"#gone\", which the file does not hold") !=
        std::string::npos);
  CHECK(refused_as("<use href='other.svg#a'/>").find("other.svg#a") != std::string::npos);
  CHECK(refused_as("<g id='a'><use href='#a'/></g>").find("within itself") != std::string::npos);
}

TEST_CASE("An inner svg places its content, and what leaves it is refused") {
  const std::string inner = "<svg x='10' y='20' width='50%' height='50' viewBox='0 0 10 10'>";
  CHECK(are_near(last_points(inner + "<path d='M0 0H10'/></svg>").at(0), {60, 80}));
  CHECK(refused_as(inner + "<path d='M0 0H11'/></svg>").find("goes beyond the <svg> in line 1") !=
        std::string::npos);
  CHECK(paths_on("<svg overflow='visible' width='5' height='5'><path d='M0 0H11'/></svg>") == 1);
}

TEST_CASE("A clip-path that is a rectangle around all is passed, any other is refused") {
  const std::string clip = "<clipPath id='c'><rect x='5' width='20' height='20'/></clipPath>";
  CHECK(paths_on(clip + "<g clip-path='url(#c)'><path d='M5 0H25'/></g>") == 1);
  CHECK(refused_as(clip + "<g clip-path='url(#c)'><path d='M4 0H25'/></g>")
            .find("goes beyond the clip-path in line 1") != std::string::npos);
  CHECK(refused_as("<clipPath id='c'><circle r='9'/></clipPath><path style='clip-path:url(#c)' d='M0 0H1'/>")
            .find("clip-path = url(#c)") != std::string::npos);
}

TEST_CASE("A switch draws its first child whose conditions are met") {
  CHECK(
      drawn(
          "<switch><foreignObject requiredExtensions='http://a/'/><g><path d='M0 0H9'/><path d='M0 0H9'/></g>"
          "<path d='M0 0H9'/></switch>") == 2);
  CHECK(drawn("<switch><path systemLanguage='de' d='M0 0H9'/><path systemLanguage='fr, en' d='M0 "
              "0H9'/></switch>") == 1);
  CHECK(drawn("<path requiredExtensions='http://a/' d='M0 0H9'/>") == 0);
}

TEST_CASE("Text that is seen is refused, and hidden or empty text is not") {
  CHECK(refused_as("<text>\n R1</text>").find("<text> is not read") != std::string::npos);
  CHECK(refused_as("<text><tspan>R1</tspan></text>").find("<text> is not read") != std::string::npos);
  for (const char* text :
       {"<text opacity='0'>R1</text>", "<text/>", "<text> </text>", "<text fill='none'>R</text>",
        "<text><tspan display='none'>R</tspan></text>", "<g display='none'><text>R</text></g>"}) {
    INFO(text);
    CHECK(drawn(text) == 0);
  }
  CHECK(refused_as("<image href='a.png' width='5' height='5'/>").find("<image> is not read") !=
        std::string::npos);
  CHECK(refused_as("<blink/>").find("<blink> is not read") != std::string::npos);
}

TEST_CASE("Elements of other namespaces are no part of the drawing") {
  CHECK(drawn("<a:path xmlns:a='http://a/' d='M0 0H9'/><x xmlns='http://a/'><path d='M0 0H9'/></x>") == 0);
  CHECK(drawn("<s:path xmlns:s='http://www.w3.org/2000/svg' d='M0 0H9'/>") == 1);
}

TEST_CASE("What an effect adds to a shape is passed over and counted") {
  const auto notes = styled.notes(hundred(
      "<marker id='m'/><filter id='f'/><pattern id='p'><path d='M0 0H9'/></pattern><path d='M0 0H9' "
      "marker-end='url(#m)'/>"
      "<path d='M0 0H9' style='filter:url(#f)' fill='url(#p)'><animate/></path><script/><path d='M3 3h0'/>"));
  REQUIRE(notes.size() == 1);
  CHECK(notes[0].find("1 of length 0 left out, the first in line 1") != std::string::npos);
  CHECK(notes[0].find("passed over: 1 <animate>, 1 <pattern>, 1 <script>, 1 filter, 1 marker-end") !=
        std::string::npos);
}

}  // namespace firn
