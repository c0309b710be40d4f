#include <catch2/catch.hpp>

#include "config/error.h"
#include "config/fields.h"
#include "core/grid/random.h"
#include "tests/config/texts.h"

using namespace firn;

namespace {

std::string damaged(std::string text, RandomStream& random) {
  static const std::string kAlphabet = "\"'[]{}=.,#\n\\-+0123456789eE_naif\0\xff\x80\xc3\r\t xu";
  for (std::uint32_t edits = 1 + random.below(4); edits > 0; --edits) {
    const std::size_t at = text.empty() ? 0 : random.below(std::uint32_t(text.size()));
    const char byte =
        random.below(4) ? kAlphabet[random.below(std::uint32_t(kAlphabet.size()))] : char(random.below(256));
    switch (random.below(5)) {
      case 0:
        if (!text.empty()) text[at] = byte;
        break;
      case 1:
        text.insert(at, 1, byte);
        break;
      case 2:
        text.erase(at, 1 + random.below(8));
        break;
      case 3:
        text.insert(at, text.substr(random.below(std::uint32_t(text.size() + 1)), random.below(40)));
        break;
      default:
        text.resize(at);
    }
  }
  return text;
}

}  // namespace

TEST_CASE(
    "Random damage to a valid file gives an experiment within all limits or a ConfigError, nothing else") {
  RandomStream random(20150, Purpose::kTest);
  const std::string texts[] = {test::kExperiment, dump(Experiment{})};
  int accepted = 0, refused = 0;
  for (int n = 0; n < 6000; ++n) {
    const std::string text = damaged(texts[n % 2], random);
    try {
      Experiment e = parse_experiment(text, "x.toml");
      for (const Field& f : fields(e)) REQUIRE(broken_limit(f) == "");
      REQUIRE(differences(e, parse_experiment(dump(e), "dump")).empty());
      ++accepted;
    } catch (const ConfigError& e) {
      REQUIRE(std::string(e.what()).starts_with("x.toml"));
      ++refused;
    }
  }
  CHECK(accepted > 100);  // both ways out were taken
  CHECK(refused > 1000);
}

TEST_CASE("Deep nesting of any kind ends in a ConfigError") {
  const auto repeated = [](const std::string& unit, int n) {
    std::string out;
    for (int k = 0; k < n; ++k) out += unit;
    return out;
  };
  CHECK_THROWS_AS(parse_experiment("x = " + repeated("[", 1900), "x.toml"), ConfigError);
  CHECK_THROWS_AS(parse_experiment("x = " + repeated("{a=", 600), "x.toml"), ConfigError);
  CHECK_THROWS_AS(parse_experiment(repeated("a.", 990) + "a = 1", "x.toml"), ConfigError);
  CHECK_THROWS_AS(parse_experiment("x = " + repeated("[{" + repeated("a.", 900) + "a =\n", 4), "x.toml"),
                  ConfigError);
  CHECK_THROWS_AS(parse_experiment(repeated("[" + repeated("a.", 900) + "a]\n", 60), "x.toml"), ConfigError);
}
