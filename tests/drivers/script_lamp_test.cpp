// A lamp that a class in Python drives: the driver when the class works, refuses, raises, hangs or
// dies.
#include "drivers/lamp/script_lamp.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "core/grid/random.h"
#include "tests/drivers/script_bench.h"

using namespace firn::drivers;
using Catch::Contains;
using firn::DeviceState;
using firn::Outcome;
using firn::Severity;
using firn::drivers::test::ScriptBench;

namespace {

const ScriptOptions kScript{"lamp", "psu.py", "Lamp", "", false, 0.0};

struct LampBench {
  ScriptLamp lamp{kScript, LampOptions{}};
  ScriptBench bench{lamp};

  void expose(double s, int iris = 80) {
    bench.command([&](std::int64_t t, Effects& fx) { lamp.expose(s, iris, t, fx); });
  }
  Result last_result() const {
    const auto all = bench.all<Result>();
    REQUIRE_FALSE(all.empty());
    return all.back();
  }
  Fault last_fault() const {
    const auto all = bench.all<Fault>();
    REQUIRE_FALSE(all.empty());
    return all.back();
  }
};

constexpr const char* kSafeBytes = "OFF\n";

}  // namespace

TEST_CASE("a class in Python is imported, made, asked who is there and made safe before its lamp is safe",
          "[script]") {
  LampBench b;
  b.bench.open_line();
  b.bench.open_program();
  CHECK(b.bench.newest() == "begin psu.py Lamp : 1 on off identify safe");
  b.bench.done(": timeout_s=1 safe_bytes=79,70,70,10");
  CHECK(b.bench.newest() == "call connect");
  b.bench.done();
  CHECK(b.bench.newest() == "call identify");
  b.bench.done(":SCPI%20lamp");
  CHECK(b.bench.newest() == "stop");
  CHECK_FALSE(b.lamp.safe());
  b.bench.done();
  CHECK(b.lamp.safe());
  CHECK(b.lamp.identity() == "SCPI lamp");
}

TEST_CASE("an exposure is on, its time and off", "[script]") {
  LampBench b;
  b.bench.become_safe();
  b.expose(0.5, 70);
  CHECK(b.bench.newest() == "call on iris_percent=70");
  CHECK(b.lamp.state() == DeviceState::kActive);
  b.bench.done();
  b.bench.advance_us(499'000);
  CHECK(b.bench.newest() == "call on iris_percent=70");
  b.bench.advance_us(1'000);
  CHECK(b.bench.newest() == "call off");
  CHECK(b.lamp.busy());
  b.bench.done();
  CHECK(b.last_result().outcome == Outcome::kDone);
  CHECK(b.lamp.safe());
}

TEST_CASE("a lamp that does not shine when it was switched on is a fault and made safe", "[script]") {
  LampBench b;
  b.bench.become_safe("timeout_s=1 safe_bytes=79,70,70,10 has_lit=1");
  b.expose(0.5);
  b.bench.done();
  CHECK(b.bench.newest() == "call lit");
  b.bench.done(": value=0");
  CHECK_THAT(b.last_fault().text, Contains("does not shine"));
  CHECK(b.bench.newest() == "stop");
  b.bench.done();
  CHECK(b.last_result().outcome == Outcome::kFailed);
}

TEST_CASE("a lamp that shines when it was switched off is a fault and made safe", "[script]") {
  LampBench b;
  b.bench.become_safe("timeout_s=1 safe_bytes=79,70,70,10 has_lit=1");
  b.expose(0.5);
  b.bench.done();
  b.bench.done(": value=1");
  b.bench.advance_us(500'000);
  b.bench.done();
  b.bench.done(": value=1");
  CHECK_THAT(b.last_fault().text, Contains("and shines"));
  CHECK(b.bench.newest() == "stop");
}

TEST_CASE("a stop sends the declared bytes in the same step, ahead of the class", "[script]") {
  LampBench b;
  b.bench.become_safe();
  b.expose(5.0);
  b.bench.done();
  b.bench.safe_stop();
  CHECK(b.bench.line == kSafeBytes);
  CHECK(b.bench.newest() == "stop");
  CHECK_FALSE(b.lamp.safe());
  b.bench.done();
  CHECK(b.lamp.safe());
  CHECK(b.last_result().text == "safe stop");
}

TEST_CASE("what a broken-off call still writes reaches no instrument", "[script]") {
  LampBench b;
  b.bench.become_safe();
  b.expose(5.0);
  const std::string on = b.bench.number();
  b.bench.say("write " + on + " 4f4e0a");
  CHECK(b.bench.line == "ON\n");
  b.bench.line.clear();
  b.bench.safe_stop();
  b.bench.say("write " + on + " 4f4e0a");
  CHECK(b.bench.line == kSafeBytes);
  b.bench.say("fail " + on + " stopped :");
  b.bench.say("write " + b.bench.number() + " 3f");
  CHECK(b.bench.line == std::string(kSafeBytes) + "?");
}

TEST_CASE("a method that never returns is named, its lamp gets the declared bytes, its program is ended",
          "[script]") {
  LampBench b;
  b.bench.become_safe("timeout_s=1 time_on=0.25 safe_bytes=79,70,70,10");
  b.expose(5.0);
  b.bench.advance_us(249'000);
  CHECK(b.bench.line.empty());
  b.bench.advance_us(1'000);
  CHECK(b.bench.line == kSafeBytes);
  CHECK(b.bench.reopens == 1);
  CHECK_THAT(b.last_fault().text, Contains("lamp: psu.py: Lamp.on: it has not returned within 0.25 s"));
  CHECK(b.last_fault().severity == Severity::kStop);
  CHECK(b.last_result().outcome == Outcome::kUnknown);
  CHECK(b.lamp.state() == DeviceState::kDisconnected);
}

TEST_CASE("a program that dies during an exposure is named and its lamp gets the declared bytes",
          "[script]") {
  LampBench b;
  b.bench.become_safe();
  b.expose(5.0);
  b.bench.done();
  b.bench.close_program();
  CHECK(b.bench.line == kSafeBytes);
  CHECK_THAT(b.last_fault().text, Contains("its program has ended"));
  CHECK(b.last_result().outcome == Outcome::kUnknown);
}

TEST_CASE("a program that dies between commands is started again without a stop of the print", "[script]") {
  LampBench b;
  b.bench.become_safe();
  b.bench.close_program();
  CHECK(b.last_fault().severity == Severity::kWarning);
  b.bench.advance_us(200'000);
  CHECK(b.bench.reopens == 1);
  b.bench.open_program();
  b.bench.done(": timeout_s=1 safe_bytes=79,70,70,10");
  b.bench.done();
  b.bench.done(":SCPI%20lamp");
  b.bench.done();
  CHECK(b.lamp.safe());
}

TEST_CASE("an exception is told with file, line and method, and the lamp is made safe", "[script]") {
  LampBench b;
  b.bench.become_safe();
  b.expose(5.0);
  b.bench.fail("error :psu.py%2c%20line%209%3a%20ValueError%3a%20bad");
  CHECK_THAT(b.last_fault().text, Contains("Lamp.on: psu.py, line 9: ValueError: bad"));
  CHECK(b.bench.line == kSafeBytes);
  CHECK(b.bench.newest() == "stop");
  b.bench.done();
  CHECK(b.last_result().outcome == Outcome::kFailed);
  CHECK(b.lamp.safe());
}

TEST_CASE("an order that the class refuses ends as none, without a fault", "[script]") {
  LampBench b;
  b.bench.become_safe();
  b.expose(5.0);
  b.bench.fail("refused :the%20door%20is%20open");
  b.bench.done();
  CHECK(b.bench.all<Fault>().empty());
  CHECK(b.last_result().outcome == Outcome::kNone);
  CHECK(b.last_result().text == "the door is open");
}

TEST_CASE("a class whose safe() fails is a fault that stops, and is never called safe", "[script]") {
  LampBench b;
  b.bench.become_safe();
  b.bench.safe_stop();
  b.bench.fail("error :still%20on");
  CHECK_THAT(b.bench.all<Fault>().front().text, Contains("Lamp.safe: still on: it may not be safe"));
  CHECK(b.bench.all<Fault>().front().severity == Severity::kStop);
  CHECK(b.lamp.state() == DeviceState::kDisconnected);
}

TEST_CASE("a class without safe_bytes is refused by name where bytes pass through Firn", "[script]") {
  LampBench b;
  b.bench.open_line();
  b.bench.open_program();
  b.bench.done(": timeout_s=1");
  CHECK(b.lamp.state() == DeviceState::kFault);
  CHECK_THAT(b.last_fault().text, Contains("declares no safe_bytes"));
}

TEST_CASE("a class that opens its instrument itself needs no safe_bytes and no port", "[script]") {
  ScriptOptions own = kScript;
  own.own_port = true;
  ScriptLamp lamp(own, {});
  ScriptBench bench(lamp);
  CHECK_FALSE(lamp.has_line());
  bench.open_program();
  CHECK(bench.newest() == "begin psu.py Lamp : 0 on off identify safe");
  bench.done(": timeout_s=1");
  bench.done();
  bench.done(":own");
  bench.done();
  CHECK(lamp.safe());
}

TEST_CASE("a class that cannot be imported is told once and not tried again", "[script]") {
  LampBench b;
  b.bench.open_line();
  b.bench.open_program();
  b.bench.fail("error :psu.py%2c%20line%203%3a%20SyntaxError%3a%20invalid%20syntax");
  b.bench.advance_us(60'000'000);
  CHECK(b.bench.all<Fault>().size() == 1);
  CHECK_THAT(b.last_fault().text, Contains("psu.py, line 3: SyntaxError"));
  CHECK(b.bench.reopens == 0);
}

TEST_CASE("limits of an exposure are those of every lamp", "[script]") {
  LampBench b;
  b.bench.become_safe();
  for (const auto& [s, iris] :
       {std::pair{0.0, 80}, {-1.0, 80}, {20.001, 80}, {NAN, 80}, {1.0, 0}, {1.0, 101}}) {
    b.expose(s, iris);
    INFO(s << " s, " << iris << " %");
    CHECK(b.last_result().outcome == Outcome::kRefused);
  }
  CHECK(b.bench.calls.empty());
  CHECK(b.bench.line.empty());
}

TEST_CASE("interlock 9 ends an exposure when the stage moves", "[script]") {
  LampBench b;
  b.bench.become_safe();
  b.expose(5.0);
  b.bench.done();
  b.bench.command([&](std::int64_t t, Effects& fx) { b.lamp.bar("the stage moves", t, fx); });
  CHECK(b.bench.newest() == "stop");
  CHECK(b.last_fault().code == kLampOn);
}

TEST_CASE("a port that closes during an exposure ends it in doubt, and the class begins anew", "[script]") {
  LampBench b;
  b.bench.become_safe();
  b.expose(5.0);
  b.bench.done();
  b.bench.close_line();
  CHECK(b.bench.line_reopens == 1);
  CHECK_THAT(b.last_fault().text, Contains("port has closed"));
  CHECK(b.last_result().outcome == Outcome::kUnknown);
}

TEST_CASE("rubbish from a program never makes a lamp safe nor crashes its driver", "[script]") {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    firn::RandomStream random(seed, firn::Purpose::kTest);
    LampBench b;
    b.bench.become_safe();
    b.expose(5.0);
    const std::string number = b.bench.number();
    for (int n = 0; n < 20; ++n) {
      std::string text;
      static constexpr std::string_view kWords[] = {"done ",  "fail ", "write ", "note ", " ",
                                                    "=",      ":",     "%",      "1,",    "nan ",
                                                    "error ", "0f",    "value",  "\xff",  "99"};
      for (std::uint32_t k = random.below(8); k > 0; --k) text += kWords[random.below(std::size(kWords))];
      b.bench.say(text);
    }
    INFO(seed);
    CHECK((!b.lamp.safe() || b.bench.all<Result>().size() == 1));
  }
}

TEST_CASE("a command that comes while the class is polled waits for the poll, whose bytes still pass",
          "[script]") {
  LampBench b;
  b.bench.become_safe("timeout_s=1 safe_bytes=79,70,70,10 has_poll=1 poll_s=2");
  b.bench.advance_us(2'000'000);
  CHECK(b.bench.newest() == "call poll");
  b.expose(0.5);
  CHECK(b.bench.newest() == "call poll");
  b.bench.say("write " + b.bench.number() + " 3f");
  CHECK(b.bench.line == "?");
  b.bench.done();
  CHECK(b.bench.newest() == "call on iris_percent=80");
}
