#include "lcmtypes/schema.h"

#include <catch2/catch.hpp>
#include <set>

#include "lcmtypes/channels.h"
#include "tests/lcmtypes/samples.h"

using namespace firn;
using namespace firn::test;
using Catch::Matchers::Contains;

namespace {

const schema::Type& type(std::string_view name) {
  const schema::Type* t = Schema::builtin().find(name);
  REQUIRE(t);
  return *t;
}

template <class M>
void expect_fingerprint(std::set<std::string>& seen) {
  const schema::Type& t = type(M::getTypeName());
  INFO(t.name);
  CHECK(t.fingerprint == M::getHash());
  CHECK(Schema::builtin().find_fingerprint(M::getHash()) == &t);
  seen.insert(t.name);
}

template <class... M>
void expect_fingerprints(TypeList<M...>, std::set<std::string>& seen) {
  (expect_fingerprint<M>(seen), ...);
}

}  // namespace

TEST_CASE("Fingerprints computed from the .lcm texts are lcm-gen's, for every type") {
  std::set<std::string> seen;
  expect_fingerprints(AllTypes{}, seen);
  for (const schema::Type& t : Schema::builtin().types()) {
    INFO(t.name);
    CHECK(seen.count(t.name) == 1);
  }
}

TEST_CASE("Every channel's type is in the schema") {
  for (const ChannelInfo& c : channel_table()) {
    INFO(c.name);
    CHECK(Schema::builtin().find(c.type));
  }
}

TEST_CASE(
    "The .lcm language is read with comments, constants, lists and packages, and errors name the line") {
  const Schema s = Schema::parse(
      "/* two\nlines */ package a;\nstruct one_t { const int32_t K = 3, L = 4; double x, y[2]; // end\n}\n"
      "package b; struct two_t { int16_t n; a.one_t ones[n][3]; string s; }");
  REQUIRE(s.find("a.one_t"));
  CHECK(s.find("one_t")->members.size() == 2);
  CHECK(s.find("b.two_t")->fields.at(1).path == "ones");
  CHECK(s.find("two_t")->fields.at(1).element == s.find("one_t"));
  CHECK_FALSE(s.find("c.two_t"));
  CHECK_THROWS_WITH(Schema::parse("package a;\nstruct x_t {\n int32_t }"),
                    Contains("line 3") && Contains("name expected"));
  CHECK_THROWS_WITH(Schema::parse("struct x_t { double v[n]; }"),
                    Contains("'n' is no integer member or constant of x_t before"));
  CHECK_THROWS_WITH(Schema::parse("struct x_t { double v[0]; }"), Contains("not positive"));
  CHECK_THROWS_WITH(Schema::parse("struct x_t { y_t v; }"), Contains("unknown type 'y_t'"));
  CHECK_THROWS_WITH(Schema::parse("struct x_t { y_t v; } struct y_t { x_t w; }"),
                    Contains("contains itself"));
  CHECK_THROWS_WITH(Schema::parse("struct x_t { int8_t v; } struct x_t { int8_t v; }"),
                    Contains("defined twice"));
  std::string doubling = "struct t0_t { int8_t v; }";
  for (int i = 1; i < 30; ++i) {
    const std::string inner = "t" + std::to_string(i - 1) + "_t";
    doubling += "struct t" + std::to_string(i) + "_t { " + inner + " a; " + inner + " b; }";
  }
  CHECK_THROWS_WITH(Schema::parse(doubling), Contains("too deeply or too often"));
  CHECK_THROWS_WITH(Schema::parse("union e { A }"), Contains("found 'union'"));
}

TEST_CASE(
    "An array whose size is a constant has the fingerprint of current lcm-gen, which hashes the constant's "
    "text") {
  const Schema s = Schema::parse(
      "package lab;\nstruct const_t { const int8_t N = 3; const int32_t ROWS = 0x2, COLS = 2;"
      " int8_t a[N]; double m[ROWS][COLS]; }");
  const schema::Type& t = *s.find("lab.const_t");
  CHECK(std::uint64_t(t.fingerprint) == 0xa14a8e59cd8dd583);  // lcm-gen 1.5.9; 1.3.1 refuses such a size
  CHECK(t.smallest_bytes == 3 + 4 * 8);
  CHECK(t.fields.at(1).dimensions.at(0).text == "0x2");
}

TEST_CASE(
    "Sizes by constant, by member and by number, enumerations and nested packages have lcm-gen's "
    "fingerprints") {
  const Schema s = Schema::parse(
      "package r.s; enum mode_t { kOff = 0, kOn, kSafe = 0x10 } struct cell_t { int16_t v; }"
      "struct grid_t { const int8_t N = 3, W = 0x2; const int32_t C = 4; const double SCALE = -1.5e3;"
      " int16_t rows; mode_t mode; double m[N][W]; float k[rows][W]; cell_t cells[C]; r.s.mode_t modes[N];"
      " string names[W]; }");
  CHECK(std::uint64_t(s.find("r.s.mode_t")->fingerprint) == 0x21066d6f658c94fa);
  CHECK(std::uint64_t(s.find("r.s.grid_t")->fingerprint) == 0x3a313b410c722722);
  CHECK(s.find("mode_t")->smallest_bytes == 4);
  const auto& fields = s.find("grid_t")->fields;
  CHECK(fields.at(1).path == "mode");
  CHECK(fields.at(1).kind == schema::Kind::kInt32);
  CHECK(fields.at(5).dimensions.at(0).size == 3);
}

TEST_CASE("A constant that is no size is refused by its name, its value and its line") {
  const auto refused = [](const std::string& members, const std::string& why) {
    CHECK_THROWS_WITH(Schema::parse("package a;\nstruct x_t {\n" + members + "}"),
                      Contains("line 3") && Contains(why));
  };
  refused("const int32_t N = -0x3; double v[N];", "array size N = -0x3 is not positive");
  refused("const int32_t N = 0; double v[N];", "array size N = 0 is not positive");
  refused("const double N = 3; double v[N];", "array size N = 3 is no integer");
  refused("const int64_t N = 4294967296; double v[N];", "array size N = 4294967296 is above 2147483647");
  refused("double v[N]; const int32_t N = 3;", "'N' is no integer member or constant of x_t before");
  refused("double v[b.y_t.N];", "'b.y_t.N' is no integer member or constant of x_t");
  refused("const int8_t N = 128;", "N: '128' is no value of int8_t");
  refused("const int64_t N = 0x8000000000000000;", "is no value of int64_t");
  refused("const int32_t N = three;", "N: 'three' is no value of int32_t");
  refused("const string N = 3;", "a constant is of an integer type, float or double, found 'string'");
  refused("const int8_t N = 1; int8_t N;", "'N' is declared twice in x_t");
  refused("const int8_t N = 1, N = 2;", "'N' is declared twice in x_t");
  refused("int8_t v; int8_t v;", "'v' is declared twice in x_t");
  CHECK(Schema::parse(
            "struct x_t { const int64_t A = -9223372036854775808, B = 0x7fffffffffffffff; int8_t v[010]; }")
            .find("x_t")
            ->smallest_bytes == 8);
}

TEST_CASE("Leaves come with their path, value and byte, in encoded order") {
  const auto bytes = encode(some_height_map(2, 2));
  std::vector<std::string> seen;
  const auto error = for_each_leaf(type("height_map_t"), bytes, [&](const Leaf& leaf) {
    seen.push_back(std::string(leaf.path) + "=" + to_text(leaf));
    return true;
  });
  CHECK_FALSE(error);
  const std::vector<std::string> expected{"header.run_id=81985529216486895",
                                          "header.incarnation=2",
                                          "header.seq=41",
                                          "header.utime_us=7000000",
                                          "n=4",
                                          "layer=7",
                                          "attempt=0",
                                          "map_id=9",
                                          "sample_utime_us=6900000",
                                          "grid.nx=2",
                                          "grid.ny=2",
                                          "grid.pitch_x_mm=0.263256",
                                          "grid.pitch_y_mm=0.263256",
                                          "grid.origin_x_mm=-5",
                                          "grid.origin_y_mm=3",
                                          "noise_std_mm=0.001",
                                          "measured_fraction=0.98",
                                          "rows_expected=0",
                                          "rows_received=0",
                                          "height_mm[0]=0",
                                          "height_mm[1]=0.01",
                                          "height_mm[2]=0.02",
                                          "height_mm[3]=nan (0x7ff8000000000000)",
                                          "quality[0]=0",
                                          "quality[1]=1",
                                          "quality[2]=2",
                                          "quality[3]=0"};
  CHECK(seen == expected);
  int calls = 0;
  for_each_leaf(type("height_map_t"), bytes, [&](const Leaf&) { return ++calls < 3; });
  CHECK(calls == 3);
}

TEST_CASE("The first difference of two messages names the leaf and both values") {
  const layer_plan_t plan = some_layer_plan(8, 4);
  const auto a = encode(plan);
  CHECK_FALSE(first_difference(type("layer_plan_t"), a, a));

  layer_plan_t other = plan;
  other.drops[17] = 9;
  auto d = first_difference(type("layer_plan_t"), a, encode(other));
  REQUIRE(d);
  CHECK(d->path == "drops[17]");
  CHECK(d->a == "1");
  CHECK(d->b == "9");
  CHECK(d->offset == a.size() - 32 + 17);

  other = plan;
  other.grid.pitch_x_mm = 0.25;
  d = first_difference(type("layer_plan_t"), a, encode(other));
  CHECK(d->path == "grid.pitch_x_mm");
  CHECK(d->a == "0.263256");
  CHECK(d->b == "0.25");

  other = plan;
  other.reason = "other";
  d = first_difference(type("layer_plan_t"), a, encode(other));
  CHECK(d->path == "reason");
  CHECK(d->b == "\"other\"");

  other = plan;
  other.n = 0;
  other.drops.clear();
  d = first_difference(type("layer_plan_t"), a, encode(other));
  CHECK(d->path == "n");
  CHECK(d->a == "32");
  CHECK(d->b == "0");
}

TEST_CASE(
    "The first difference is told for other types, cut and lengthened messages, and strings in arrays") {
  const auto a = encode(some_layer_plan(8, 4));
  auto d = first_difference(type("layer_plan_t"), a, encode(some_height_map(8, 4)));
  CHECK(d->path == "(fingerprint)");
  CHECK(d->a == "layer_plan_t");
  CHECK(d->b == "height_map_t");
  d = first_difference(type("layer_plan_t"), a, std::span(a).first(a.size() - 3));
  CHECK(d->path == "drops[29]");
  CHECK(d->a == "1");
  CHECK_THAT(d->b, Contains("damaged"));
  auto longer = a;
  longer.push_back(std::byte{1});
  d = first_difference(type("layer_plan_t"), a, longer);
  CHECK(d->path == "(length)");
  heartbeat_t h = some_heartbeat();
  const auto b = encode(h);
  h.channel[1] = "STATE_LAMP";
  d = first_difference(type("heartbeat_t"), b, encode(h));
  CHECK(d->path == "channel[1]");
  CHECK(d->a == "\"STATE_JET\"");
}

TEST_CASE("JSON nests structs, escapes texts, writes NaN as null and shortens long arrays") {
  const auto map = encode(some_height_map(2, 2));
  CHECK(
      to_json(type("height_map_t"), map) ==
      R"({"header":{"run_id":81985529216486895,"incarnation":2,"seq":41,"utime_us":7000000},"n":4,"layer":7,"attempt":0,)"
      R"("map_id":9,"sample_utime_us":6900000,"grid":{"nx":2,"ny":2,"pitch_x_mm":0.263256,"pitch_y_mm":0.263256,)"
      R"("origin_x_mm":-5,"origin_y_mm":3},"noise_std_mm":0.001,"measured_fraction":0.98,"rows_expected":0,)"
      R"("rows_received":0,"height_mm":[0,0.01,0.02,null],)"
      R"("quality":[0,1,2,0]})");
  const auto plan = encode(some_layer_plan(8, 4));
  CHECK_THAT(
      to_json(type("layer_plan_t"), plan),
      Contains(
          R"("reason":"the surface is \"low\" at x > 3 µm","drops":{"count":32,"first":[0,1,2,3,0,1,2,3]}})"));
  JsonOptions full;
  full.full = true;
  CHECK_THAT(to_json(type("layer_plan_t"), plan, full), !Contains("count"));
  CHECK_THAT(to_json(type("heartbeat_t"), encode(some_heartbeat())),
             Contains(R"("channel":["ANSWER_JET","STATE_JET","FAULT_JET"],"last_seq":[4,5,0])"));
  CHECK(json_string("a\x01\n\xff\xc3\xa9\xed\xa0\x80") ==
        "\"a\\u0001\\n\xef\xbf\xbd\xc3\xa9\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\"");
}

TEST_CASE(
    "JSON of a damaged message has the members before the damage, closes what it opened, and says where") {
  const auto whole = encode(some_heartbeat());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::string json = to_json(type("heartbeat_t"), std::span(whole).first(size));
    INFO(json);
    REQUIRE(std::count(json.begin(), json.end(), '{') == std::count(json.begin(), json.end(), '}'));
    REQUIRE(std::count(json.begin(), json.end(), '[') == std::count(json.begin(), json.end(), ']'));
    REQUIRE_THAT(json, Contains("\"_error\":") && !Contains(",}") && !Contains("{,") && !Contains("[,"));
  }
}

TEST_CASE("Arrays of structs and of several dimensions have paths, JSON and differences") {
  const Schema s = Schema::parse(
      "struct p_t { int8_t x; string s; } struct q_t { int32_t n; p_t p[n][2]; int16_t m[2][2]; }");
  const schema::Type& q = *s.find("q_t");
  std::vector<std::byte> bytes(8);
  for (int i = 0; i < 8; ++i) bytes[std::size_t(i)] = std::byte(std::uint64_t(q.fingerprint) >> (56 - 8 * i));
  const auto put = [&](std::initializer_list<int> values) {
    for (int v : values) bytes.push_back(std::byte(v));
  };
  put({0, 0, 0, 2});
  for (int k = 0; k < 4; ++k) put({k, 0, 0, 0, 2, 'a' + k, 0});
  put({0, 1, 0, 2, 0, 3, 0xff, 0xff});
  CHECK_FALSE(check(q, bytes));
  CHECK(to_json(q, bytes) ==
        R"({"n":2,"p":[{"x":0,"s":"a"},{"x":1,"s":"b"},{"x":2,"s":"c"},{"x":3,"s":"d"}],"m":[1,2,3,-1]})");
  auto other = bytes;
  other[12 + 2 * 7 + 5] = std::byte{'z'};
  const auto d = first_difference(q, bytes, other);
  REQUIRE(d);
  CHECK(d->path == "p[1][0].s");
  CHECK(d->b == "\"z\"");
  other = bytes;
  other.back() = std::byte{0};
  CHECK(first_difference(q, bytes, other)->path == "m[1][1]");
}

TEST_CASE("A type may hold counted arrays of itself, with the fingerprint of lcm-gen") {
  const Schema s = Schema::parse(
      "package a.b;\nstruct node_t { int32_t n; node_t children[n]; double v; }\n"
      "struct m_t { n_t a[2]; int32_t k; m_t more[k]; }\n"
      "struct n_t { int32_t k; m_t z[k]; string s; boolean b; byte q[0x10]; }\n");
  // Of the Python classes that lcm-gen 1.3.1 makes of this text.
  CHECK(std::uint64_t(s.find("node_t")->fingerprint) == 0x13596d79fdde846eu);
  CHECK(std::uint64_t(s.find("m_t")->fingerprint) == 0xddd91a2158729ce1u);
  CHECK(std::uint64_t(s.find("n_t")->fingerprint) == 0xd9f5db549ba6d9d2u);
  CHECK(s.find("node_t")->smallest_bytes == 12);
  CHECK_THROWS_WITH(Schema::parse("struct x_t { int32_t n; x_t v[2]; }"), Contains("contains itself"));
}

TEST_CASE("An empty array of structs is an empty array in JSON") {
  const Schema s = Schema::parse("struct p_t { int8_t x; } struct q_t { int8_t n; p_t p[n]; int8_t z; }");
  const schema::Type& q = *s.find("q_t");
  std::vector<std::byte> bytes(10);
  for (int i = 0; i < 8; ++i) bytes[std::size_t(i)] = std::byte(std::uint64_t(q.fingerprint) >> (56 - 8 * i));
  CHECK(to_json(q, bytes) == R"({"n":0,"p":[],"z":0})");
}
