#include <catch2/catch.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "core/grid/random.h"
#include "drivers/link/link.h"
#include "tests/docs/lkg_codec.h"

namespace firn::drivers::point_laser {
namespace {

std::string file(const std::string& path) {
  std::ifstream in(std::string(FIRN_SOURCE_DIR) + "/" + path);
  REQUIRE(in.good());
  return {std::istreambuf_iterator<char>(in), {}};
}

// The link with the dialect, and an instrument that sends the lines of the script.
struct Bench {
  LkgDialect dialect;
  Link link{dialect};
  Effects fx;
  std::int64_t now_us = 0;
  std::vector<std::string> replies, unsolicited;

  Bench() {
    link.opened(now_us);
    poll();
  }
  void poll() {
    while (const auto e = link.poll(now_us, fx)) {
      const std::string text(reinterpret_cast<const char*>(e->frame.data()), e->frame.size());
      if (e->kind == LinkEvent::Kind::kReply) replies.push_back(text.substr(0, text.find('\r')));
      if (e->kind == LinkEvent::Kind::kUnsolicited) unsolicited.push_back(text);
    }
  }
  void ask() {
    link.push(measure(1));
    poll();
  }
  void says(const std::string& bytes) {
    link.received(std::as_bytes(std::span(bytes)), now_us);
    poll();
  }
};

TEST_CASE("the driver page leads to the codec that is compiled here, which keeps to 100 lines") {
  const std::string code = file("tests/docs/lkg_codec.h");
  REQUIRE(file("docs/write-a-driver.md").find("](../tests/docs/lkg_codec.h)") != std::string::npos);
  REQUIRE(std::count(code.begin(), code.end(), '\n') <= 100);
}

TEST_CASE("the page's codec reads the manual's replies") {
  REQUIRE(parse("M1,+01.2345").height_mm == Approx(1.2345).epsilon(1e-12));
  REQUIRE(parse("M1,-00.0120").height_mm == Approx(-0.0120).epsilon(1e-12));
  REQUIRE(parse("M1,-00001.2").height_mm == Approx(-1.2).epsilon(1e-12));
  for (const auto& [reply, status] :
       {std::pair("M1,-FFFFFFF", Status::kBelow), std::pair("M1,+FFFFFFF", Status::kAbove),
        std::pair("M1,XXXXXXXX", Status::kNoValue)}) {
    REQUIRE(std::isnan(parse(reply).height_mm));
    REQUIRE(parse(reply).status == status);
  }
  REQUIRE(parse("ER,M1,01").status == Status::kRefused);
  REQUIRE(parse("ER,M1,01").error == 1);
}

TEST_CASE(
    "a reply cut at any place reads the same, and a timing event between question and answer is not the "
    "answer") {
  const std::string bytes = "TG,1,+00.5000\rM1,+01.2345\r";
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    Bench b;
    b.ask();
    b.says(bytes.substr(0, cut));
    b.says(bytes.substr(cut));
    CAPTURE(cut);
    REQUIRE(b.replies == std::vector<std::string>{"M1,+01.2345"});
    REQUIRE(b.unsolicited.size() == 1);
  }
}

TEST_CASE("noise is never read as a height, and never hangs the link") {
  RandomStream r(3, Purpose::kTest);
  for (int n = 0; n < 2000; ++n) {
    std::string noise;
    for (std::uint32_t k = r.below(40); k > 0; --k) noise += char(r.below(256));
    const Reading reading = parse(noise);
    REQUIRE((reading.status == Status::kOk) == std::isfinite(reading.height_mm));
    const LkgDialect dialect;
    const Request asked = measure(1);
    const std::string endless(300, 'A');
    REQUIRE(dialect.frame(std::as_bytes(std::span(endless)), &asked).kind == Frame::Kind::kCorrupt);
    if (!noise.empty()) {
      const Frame f = dialect.frame(std::as_bytes(std::span(noise)), &asked);
      REQUIRE((f.kind == Frame::Kind::kIncomplete) == (f.size == 0));
    }
  }
}

}  // namespace
}  // namespace firn::drivers::point_laser
