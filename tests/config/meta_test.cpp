// [meta] of an experiment: facts about a print, typed and required by the lab, part of no node's
// configuration.
#include <catch2/catch.hpp>

#include <cmath>

#include "config/error.h"
#include "config/experiment.h"
#include "config/meta.h"

namespace firn::test {
namespace {

using Catch::Contains;

using Texts = std::vector<std::pair<std::string, std::string>>;

const std::string kLab =
    "[lab.meta]\n"
    "sample = {type = \"text\", required = true, meaning = \"label of the board\"}\n"
    "humidity_percent = {type = \"number\"}\n"
    "pass = {type = \"integer\"}\n"
    "primed = {type = \"boolean\"}\n"
    "opened = {type = \"date\"}\n"
    "ink = {type = \"text\", one_of = [\"TPGDA\", \"HDDA\"]}\n";

Meta meta_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return parse_meta({{"lab.toml", kLab}, {"x.toml", text}}, overrides).values;
}

std::string refusal(const Texts& texts, const std::vector<std::string>& overrides = {}) try {
  parse_meta(texts, overrides);
  return "";
} catch (const ConfigError& error) {
  return error.what();
}

TEST_CASE("[lab.use] limits a batch and instruments, in the order of the keys") {
  const UseLimits use =
      parse_meta({{"lab.toml", "[lab.use]\nlamp_h = 1000\nbatch_mm3 = 5e4\nwarn_percent = 80\n"}}, {}).use;
  REQUIRE(use.limits.size() == 2);
  CHECK(use.limits[0].key == "batch_mm3");
  CHECK(use.limits[0].limit == 5e4);
  CHECK(use.limits[1].key == "lamp_h");
  CHECK(use.limits[1].limit == 1000.0);
  CHECK(use.warn_percent == 80.0);
  CHECK(parse_meta({{"x.toml", ""}}, {}).use.limits.empty());
  CHECK(parse_meta({{"x.toml", ""}}, {}).use.warn_percent == 90.0);
}

TEST_CASE("an experiment's own [lab.use] wins over that of the lab that it includes, key by key") {
  const Texts texts{{"lab.toml", "[lab.use]\nlamp_h = 1000\nbatch_mm3 = 5e4\n"},
                    {"x.toml", "[lab.use]\nlamp_h = 10\n"}};
  const UseLimits use = parse_meta(texts, {}).use;
  REQUIRE(use.limits.size() == 2);
  CHECK(use.limits[0].limit == 5e4);
  CHECK(use.limits[1].limit == 10.0);
}

TEST_CASE("a limit of [lab.use] that is none is refused by file, line and requirement") {
  const auto refused = [](const std::string& line) {
    return refusal({{"lab.toml", "[lab.use]\n" + line + "\n"}});
  };
  CHECK_THAT(refused("controller_h = 5"),
             Contains("lab.toml:2: lab.use.controller_h: unknown; there are batch_mm3"));
  CHECK_THAT(refused("lamp = 5"), Contains("lab.use.lamp: unknown"));
  for (const char* bad : {"lamp_h = 0", "lamp_h = -1", "lamp_h = \"many\"", "lamp_h = nan", "lamp_h = 2e12",
                          "warn_percent = 101", "batch_mm3 = [1]", "batch_mm3 = true"}) {
    INFO(bad);
    CHECK_THAT(refused(bad), Contains("lab.toml:2: lab.use.") && Contains("must be a number above 0"));
  }
  CHECK_THAT(refusal({{"lab.toml", "[lab]\nuse = 3\n"}}), Contains("lab.use"));
}

TEST_CASE("[meta] holds texts, numbers, booleans and dates, in the order of their keys") {
  const Meta meta = meta_of(
      "[meta]\nsample = \"PCB-7\"\nhumidity_percent = 41\nprimed = true\nopened = 2026-11-30\nown = 2.5\n");
  CHECK(meta == Meta{{"humidity_percent", 41.0},
                     {"opened", std::string("2026-11-30")},
                     {"own", 2.5},
                     {"primed", true},
                     {"sample", std::string("PCB-7")}});
  CHECK(parse_meta({{"x.toml", ""}}, {}).values.empty());
}

TEST_CASE("option --meta follows the file, and a declared text stays a text whatever it looks like") {
  const Meta meta =
      meta_of("[meta]\nsample = \"old\"\n", {"meta.sample=007", "meta.batch=12", "meta.own=12",
                                             "meta.lot=0042", "meta.dry=true", "meta.humidity_percent=41.5"});
  CHECK(meta == Meta{{"batch", std::string("12")},
                     {"dry", true},
                     {"humidity_percent", 41.5},
                     {"lot", std::string("0042")},
                     {"own", std::int64_t{12}},
                     {"sample", std::string("007")}});
  CHECK(meta_of("", {"meta.sample=\"a = b\""}).front().value == MetaValue(std::string("a = b")));
}

TEST_CASE("a mistake in [meta] names file, line, key and requirement") {
  const auto of = [](const std::string& text) { return refusal({{"lab.toml", kLab}, {"x.toml", text}}); };
  CHECK_THAT(of("[meta]\nsample = 7\n"),
             Contains("x.toml:2: meta.sample = 7: must be a text, in quotes") && Contains("lab.toml:2"));
  CHECK_THAT(of("[meta]\nhumidity_percent = \"wet\"\n"),
             Contains("x.toml:2: meta.humidity_percent") && Contains("must be a number"));
  CHECK_THAT(of("[meta]\npass = 1.5\n"), Contains("must be an integer"));
  CHECK_THAT(of("[meta]\nprimed = \"yes\"\n"), Contains("must be true or false"));
  for (const char* date :
       {"\"2026-02-29\"", "\"2026-13-01\"", "\"yesterday\"", "20261130", "\"2026-1-01\"", "\"2026-11-31\""})
    CHECK_THAT(of(std::string("[meta]\nopened = ") + date + "\n"),
               Contains("must be a date, such as 2026-11-30"));
  CHECK(of("[meta]\nopened = \"2028-02-29\"\n").empty());
  CHECK_THAT(of("[meta]\nink = \"water\"\n"), Contains("must be one of TPGDA, HDDA"));
  CHECK_THAT(of("[meta]\noperator = 3\n"), Contains("meta.operator = 3: must be a text"));
  CHECK_THAT(of("[meta]\nSample = \"a\"\n"),
             Contains("x.toml:2: meta.Sample: a key has 1 to 40 letters a to z"));
  CHECK_THAT(of("[meta]\nlist = [1, 2]\n"),
             Contains("meta.list: must be a text, a number, true, false or a date"));
  CHECK_THAT(of("[meta]\nsample = \"\"\n"), Contains("must not be empty"));
  CHECK_THAT(of("[meta]\nsample = \"a\\nb\"\n"), Contains("control characters"));
  CHECK_THAT(of("[meta]\nsample = \"" + std::string(501, 'x') + "\"\n"), Contains("at most 500 bytes"));
  CHECK_THAT(of("[meta]\nown = inf\n"), Contains("must be finite"));
  CHECK_THAT(of("meta = 3\n"), Contains("meta: is a section of keys, not a value"));
  std::string many = "[meta]\n";
  for (int n = 0; n < 65; ++n) many += "k" + std::to_string(n) + " = 1\n";
  CHECK_THAT(of(many), Contains("more than 64 keys"));
}

TEST_CASE("a mistake in a lab's declarations is named, and so is one of --meta") {
  const auto of = [](const std::string& text) { return refusal({{"lab.toml", "[lab.meta]\n" + text}}); };
  CHECK_THAT(
      of("sample = {type = \"txt\"}\n"),
      Contains("lab.toml:2: lab.meta.sample.type: must be one of text, number, integer, boolean, date"));
  CHECK_THAT(of("sample = \"text\"\n"), Contains("lab.meta.sample: must be a table"));
  CHECK_THAT(of("sample = {typ = \"text\"}\n"), Contains("lab.meta.sample.typ: unknown"));
  CHECK_THAT(of("sample = {required = 1}\n"), Contains("must be true or false"));
  CHECK_THAT(of("sample = {one_of = []}\n"), Contains("must be a list of texts"));
  CHECK_THAT(of("pass = {type = \"integer\", one_of = [\"a\"]}\n"), Contains("is of texts"));
  CHECK_THAT(refusal({}, {"meta.Bad-Key=1"}), Contains("--meta: meta.Bad-Key: a key has 1 to 40 letters"));
  CHECK_THAT(refusal({}, {"meta.sample"}), Contains("--meta: 'sample': must read KEY=VALUE"));
  CHECK_THAT(refusal({}, {"meta.sample="}), Contains("meta.sample = \"\": must not be empty"));
  CHECK_THAT(refusal({{"lab.toml", kLab}}, {"meta.pass=two"}),
             Contains("--meta: meta.pass = \"two\": must be an integer"));
}

TEST_CASE("a key that the lab requires is missed by name, with its meaning and the place that requires it") {
  const PrintMeta meta = parse_meta({{"lab.toml", kLab}, {"x.toml", "[meta]\nink = \"HDDA\"\n"}}, {});
  REQUIRE(meta.missing.size() == 1);
  CHECK_THROWS_WITH(require_meta(meta), Contains("lab.toml:2") && Contains("sample (label of the board)") &&
                                            Contains("--meta sample=VALUE"));
  CHECK_NOTHROW(require_meta(parse_meta({{"lab.toml", kLab}}, {"meta.sample=a"})));
}

TEST_CASE("run.name takes values of [meta], and one that no folder can be named by is refused") {
  const auto name = [](const std::string& text, const std::vector<std::string>& set = {}) {
    return parse_experiment(Texts{{"x.toml", text}}, set).run.name;
  };
  const std::string pattern =
      "[run]\nname = \"{meta.sample}-cube-{meta.pass}\"\n[meta]\nsample = \"PCB-7\"\npass = 3\n";
  CHECK(name(pattern) == "PCB-7-cube-3");
  CHECK(name(pattern, {"meta.sample=a.b"}) == "a.b-cube-3");
  CHECK(name("[run]\nname = \"plain\"\n[meta]\nsample = \"a/b\"\n") == "plain");
  CHECK_THROWS_WITH(
      name(pattern, {"meta.sample=../x"}),
      Contains("x.toml:2: run.name") && Contains("meta.sample = \"../x\" cannot be part of a folder's name"));
  CHECK_THROWS_WITH(name("[run]\nname = \"{meta.sample}\"\n"),
                    Contains("meta.sample is not set; --meta sample=VALUE"));
  CHECK_THROWS_WITH(name("[run]\nname = \"{meta.sample\"\n[meta]\nsample = \"a\"\n"),
                    Contains("without its '}'"));
  CHECK_THROWS_WITH(name("[run]\nname = \"{sample}\"\n"), Contains("must be 1 to 100 letters"));
  CHECK_THROWS_WITH(
      name("[run]\nname = \"{meta.sample}\"\n[meta]\nsample = \"" + std::string(101, 'a') + "\"\n"),
      Contains("must be 1 to 100 letters"));
}

TEST_CASE("no node's configuration knows [meta], and mistakes in it are counted with the others") {
  const Texts with{{"lab.toml", kLab}, {"x.toml", "[meta]\nsample = \"a\"\nfree = 1\n"}};
  CHECK(dump(parse_experiment(with, {})) == dump(Experiment{}));
  CHECK(mistakes_of(with, {}).empty());
  const auto wrong = mistakes_of({{"x.toml", "[meta]\nBad = 1\nsample = [1]\n[grid]\nnx = -1\n"}}, {});
  REQUIRE(wrong.size() >= 2);
  CHECK(wrong.front().key == "meta.Bad");
}

TEST_CASE("[meta] written as TOML reads back as the same values") {
  const Meta meta = meta_of(
      "[meta]\nsample = \"say \\\"a\\\\b\\\"\"\nhumidity_percent = 41\nprimed = false\nn = -3\nx = 1e-7\n");
  CHECK(parse_meta({{"y.toml", meta_toml(meta)}}, {}).values == meta);
  CHECK(meta_toml({}).empty());
}

}  // namespace
}  // namespace firn::test
