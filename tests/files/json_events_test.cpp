// Firn's JSON reader against nlohmann's, event by event.
#include "files/json_events.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "core/grid/random.h"
#include "files/json.h"

namespace firn {
namespace {

std::string digits_of(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g",
                value == 0.0 ? 0.0 : value);  // nlohmann reads the integer -0 as 0
  return text;
}

/// The events as one text.
class Ours : public JsonHandler {
 public:
  void null() override { log += "null "; }
  void boolean(bool value) override { log += value ? "true " : "false "; }
  void integer(double value) override { log += "integer " + digits_of(value) + ' '; }
  void number(double value) override { log += "number " + digits_of(value) + ' '; }
  void text(const std::string& value) override { log += "text " + value + ' '; }
  void start_object() override { log += "{ "; }
  void key(const std::string& value) override { log += "key " + value + ' '; }
  void end_object() override { log += "} "; }
  void start_list() override { log += "[ "; }
  void end_list() override { log += "] "; }
  std::string log;
};

class Theirs : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit Theirs(Ours& to) : to_(to) {}
  bool null() override {
    to_.null();
    return true;
  }
  bool boolean(bool value) override {
    to_.boolean(value);
    return true;
  }
  bool number_integer(number_integer_t value) override {
    to_.integer(double(value));
    return true;
  }
  bool number_unsigned(number_unsigned_t value) override {
    to_.integer(double(value));
    return true;
  }
  bool number_float(number_float_t value, const string_t& text) override {
    // integers beyond 64 bits come as floating point there
    const bool whole = text.find_first_of(".eE") == text.npos;
    whole ? to_.integer(value) : to_.number(value);
    return true;
  }
  bool string(string_t& value) override {
    to_.text(value);
    return true;
  }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override {
    to_.start_object();
    return true;
  }
  bool key(string_t& value) override {
    to_.key(value);
    return true;
  }
  bool end_object() override {
    to_.end_object();
    return true;
  }
  bool start_array(std::size_t) override {
    to_.start_list();
    return true;
  }
  bool end_array() override {
    to_.end_list();
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override {
    return false;
  }

 private:
  Ours& to_;
};

struct Outcome {
  std::string log;
  bool good = true;
  std::uint64_t byte = 0;
};
Outcome ours(const std::string& text) {
  Ours events;
  std::istringstream in(text);
  ByteBlocks bytes(in);
  try {
    read_json_events(bytes, events);
  } catch (const JsonMistake& mistake) {
    return {events.log, false, mistake.byte};
  }
  return {events.log};
}
Outcome theirs(const std::string& text) {
  Ours events;
  Theirs sax(events);
  const bool good = nlohmann::json::sax_parse(text, &sax);
  return {events.log, good};
}

}  // namespace

TEST_CASE("JSON events: the same as nlohmann's on documents with every kind of value") {
  for (
      const std::string text :
      {R"({"a": [1, -2, 3.5, -0, 0.0, 1e3, 1E-3, 12345678901234567890, -9223372036854775808, 0.1, 123456789012345.6]})",
       R"([[], {}, [[]], {"k": {}}, true, false, null, "", "text", 0])",
       R"("\"\\\/\b\f\n\r\t\u00e9\u20ac\ud83d\ude00 é€😀")", "\xef\xbb\xbf [1]\n", " \t\r\n{ \"x\" : 1 } \n",
       "3", "-1.25e+2", "1e-400", "[0.000001, 98765.432101, 1.7976931348623157e308]"}) {
    INFO(text);
    const Outcome a = ours(text), b = theirs(text);
    CHECK(a.good);
    CHECK(b.good);
    CHECK(a.log == b.log);
  }
}

TEST_CASE("JSON events: what nlohmann's grammar refuses is refused, at a byte of the document") {
  for (const std::string text : {"",
                                 " ",
                                 "[",
                                 "{",
                                 "[1",
                                 "[1,",
                                 "[1,]",
                                 "{\"a\"}",
                                 "{\"a\":}",
                                 "{\"a\":1,}",
                                 "{a:1}",
                                 "[1 2]",
                                 "01",
                                 "-",
                                 "1.",
                                 ".5",
                                 "+1",
                                 "1e",
                                 "1e+",
                                 "tru",
                                 "nulll",
                                 "[1]]",
                                 "\"",
                                 "\"\\x\"",
                                 "\"\\u12g4\"",
                                 "\"\\ud800\"",
                                 "\"\\udc00\"",
                                 "\"\x01\"",
                                 "\"\xc0\x80\"",
                                 "\"\xed\xa0\x80\"",
                                 "\"\xf5\x80\x80\x80\"",
                                 "1e999",
                                 "-1e999",
                                 "[1,,2]",
                                 "{,}",
                                 "// 1"}) {
    INFO(text);
    CHECK_FALSE(theirs(text).good);
    const Outcome a = ours(text);
    CHECK_FALSE(a.good);
    CHECK(a.byte >= 1);
    CHECK(a.byte <= text.size() + 1);
  }
}

TEST_CASE(
    "JSON events: damaged documents are read or refused as by nlohmann, whatever the length of their "
    "numbers") {
  RandomStream random(2201, Purpose::kTest);
  const std::string alphabet = "[]{},:\"0123456789.-+eE\n \\ntrufalsx\xff\xc3\xa9";
  for (int trial = 0; trial < 6000; ++trial) {
    std::string text = R"({"version":1,"paths":[{"points":[)";
    for (std::uint32_t n = random.below(9); n > 0; --n) {
      std::string number = random.below(2) ? "-" : "";
      for (std::uint32_t k = 1 + random.below(20); k > 0; --k) number += char('0' + random.below(10));
      if (random.below(4)) number.insert(number.size() - random.below(std::uint32_t(number.size())), ".");
      if (random.below(5) == 0) number += "e" + std::to_string(int(random.below(50)) - 25);
      text += "[" + number + "," + number + "],";
    }
    text += R"([0,0],[1,2,50]],"kind":"fi\u006cl","closed":false,"layer":3}]})" +
            std::string(random.below(200), ' ');
    for (std::uint32_t n = random.below(4); n > 0; --n) {
      const std::size_t at = random.below(std::uint32_t(text.size()));
      const char c = alphabet[random.below(std::uint32_t(alphabet.size()))];
      if (random.below(3) == 0)
        text.erase(at, 1 + random.below(4));
      else if (random.below(2))
        text[at] = c;
      else
        text.insert(at, 1, c);
    }
    INFO(text);
    const Outcome a = ours(text), b = theirs(text);
    REQUIRE(a.good == b.good);
    REQUIRE(a.log == b.log);
  }
}

TEST_CASE("JSON events: a document of many blocks is read as one") {
  std::string text = "[";
  double sum = 0.0;
  for (int n = 0; n < 200000; ++n) {
    text += std::to_string(n * 0.001) + ", ";
    sum += n * 0.001;
  }
  text += "\"" + std::string(600000, 'x') + "\"]";
  struct Sum : Ours {
    void number(double value) override { total += value; }
    double total = 0.0;
  } events;
  std::istringstream in(text);
  ByteBlocks bytes(in);
  read_json_events(bytes, events);
  CHECK(events.total == Approx(sum).epsilon(1e-12));
  CHECK(events.log.size() == 600000 + 10);
}

}  // namespace firn
