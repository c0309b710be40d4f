// The V+ interpreter alone: its language, its numbers, its tasks.
#include <catch2/catch.hpp>

#include <random>

#include "plant/twins/lines.h"
#include "tests/plant/still_arm.h"
#include "tests/plant/vplus_text.h"

using namespace firn;
using namespace firn::plant;
using namespace firn::plant::vplus;
using Catch::Contains;

namespace {

/// Runs statements as task 0 for a second.
struct Ran {
  explicit Ran(const std::string& body, const std::string& further = "", int statements_per_tick = 160)
      : code(parse({{"t.v2", ".PROGRAM main()\n" + body + "\n.END\n" + further}})),
        machine(code, arm, {.statements_per_tick = statements_per_tick}) {
    machine.execute(0, "main", 0);
    run_until(machine, 1'000'000);
  }
  float real(const std::string& name) const {
    CHECK(machine.stopped_by(0) == "");
    return machine.get(name).real;
  }
  std::string text(const std::string& name) const { return machine.get(name).text; }

  StillArm arm;
  Code code;
  Machine machine;
};

std::string refusal(const std::string& text) {
  try {
    parse({{"t.v2", text}});
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("V+ text that the interpreter does not know is refused by its file and line") {
  const std::pair<const char*, const char*> cases[] = {
      {"GOTO 10", "t.v2:2: this statement is not known"},
      {"a = SIN(1)", "t.v2:2: this function is not known"},
      {"a = 1 +", "t.v2:2: a value is missing"},
      {"a = \"x\"", "t.v2:2: types do not fit"},
      {"a = \"x\"*2", "t.v2:2: types do not fit the operator before"},
      {"$a = \"x", "t.v2:2: a string does not end"},
      {"CALL nobody()", "t.v2:2: no program is called nobody"},
      {"CALL main(1)", "t.v2:2: main takes 0 arguments"},
      {"IF a THEN", "t.v2:3: END is missing"},
      {"END", "t.v2:2: no block is open"},
      {"EXIT", "t.v2:2: no loop is open"},
      {"ELSE", "t.v2:2: no block is open"},
      {"VALUE 1:", "t.v2:2: no block is open"},
      {"a = ^HFFFFFFFF", "t.v2:2: no number of 24 bits"},
      {"a = b[1,2,3,4]", "t.v2:2: no such array"},
      {"MOVE a", "t.v2:2: MOVE goes to a precision point here"},
      {"$a = $ENCODE(/F8.3,b)", "t.v2:2: this format is not known"},
      {"WRITE (a, b) $c, /N", "t.v2:2: this format is not known"},
      {"a = 1 b", "t.v2:2: more than the statement"},
      {"a = 1 ? 2", "t.v2:2: unknown character '?'"},
  };
  for (const auto& [line, says] : cases) {
    INFO(line);
    CHECK_THAT(refusal(std::string(".PROGRAM main()\n") + line + "\n.END\n"), Catch::StartsWith(says));
  }
  CHECK_THAT(refusal("a = 1\n"), Contains("t.v2:1: a statement outside of a program"));
  CHECK_THAT(refusal(".PROGRAM a()\n"), Contains("has no .END"));
  CHECK_THAT(refusal(".PROGRAM a()\n.END\n.PROGRAM a()\n.END\n"),
             Contains("t.v2:3: program a is there twice"));
  CHECK_THAT(
      refusal(".PROGRAM a()\n\ta = " + std::string(100, '(') + "1" + std::string(100, ')') + "\n.END\n"),
      Contains("t.v2:2: brackets are too deep"));
  CHECK_THAT(refusal(".PROGRAM a()\n\ta = 1" + std::string(600, ' ') + "\n.END\n"),
             Contains("512 characters"));
}

TEST_CASE("V+ loops, branches and calls by reference go where the language says") {
  const Ran ran(R"(
	AUTO n, k, q[4]
	total = 0
	FOR n = 10 TO 2 STEP -3
		total = total*100+n
	END
	never = 0
	FOR n = 1 TO 0
		never = 1
	END
	n = 0
	odd = 0
	WHILE TRUE DO
		n = n+1
		IF n MOD 2 == 0 THEN
			NEXT
		END
		IF n > 7 THEN
			EXIT
		END
		odd = odd+n
	END
	chosen = 0
	FOR k = 1 TO 5
		CASE k OF
		  VALUE 1, 3:
			chosen = chosen*10+1
		  VALUE 2:
			chosen = chosen*10+2
		  ANY
			chosen = chosen*10+9
		END
	END
	by.name = 1
	by.value = 1
	list[3] = 1
	CALL twice(by.name, (by.value), list[3])
	nested = 0
	IF FALSE THEN
		nested = 1
	ELSE
		IF TRUE THEN
			nested = 2
		END
	END)",
                R"(
.PROGRAM twice(a, b, c)
	CALL once(a)
	b = b*2
	c = c*2
.END
.PROGRAM once(x)
	x = x*2
.END
)");
  CHECK(ran.real("total") == 100704.0F);
  CHECK(ran.real("never") == 0.0F);
  CHECK(ran.real("odd") == 16.0F);
  CHECK(ran.real("chosen") == 12199.0F);
  CHECK(ran.real("by.name") == 2.0F);
  CHECK(ran.real("by.value") == 1.0F);
  CHECK(ran.real("nested") == 2.0F);
}

TEST_CASE("V+ reals hold 24 bits, TRUE is -1, and operators bind in the order of the language") {
  const Ran ran(R"(
	big = 16777216+1
	third = 1/3
	yes = 3 > 2
	order = 1+2*3 == 7
	bits = ^HFF BAND ^H0F BXOR 1
	minus = -2*3
	cut = INT(-2.7)
	rest = -7 MOD 3
	both = NOT FALSE AND TRUE)");
  CHECK(ran.real("big") == 16777216.0F);
  CHECK(ran.real("third") == 1.0F / 3.0F);
  CHECK(ran.real("yes") == -1.0F);
  CHECK(ran.real("order") == -1.0F);
  CHECK(ran.real("bits") == 14.0F);
  CHECK(ran.real("minus") == -6.0F);
  CHECK(ran.real("cut") == -2.0F);
  CHECK(ran.real("rest") == -1.0F);
  CHECK(ran.real("both") == -1.0F);
}

TEST_CASE("V+ string functions count from 1 and take what is there") {
  const Ran ran(R"(
	$a = "PATH P 12"
	$w = $DECODE($a," ",0)
	$s = $DECODE($a," ",1)
	$m = $MID("abcdef",3,2)
	$n = $MID("abc",4,2)
	p = POS("abcabc","c",4)
	none = POS("abc","d",1)
	c = ASC("A",1)
	gone = ASC("A",2)
	v = VAL("-12.5x")
	$e = $ENCODE(/I0,12," ",-3)+$CHR(65)
	long = LEN($a))");
  CHECK(ran.text("$w") == "PATH");
  CHECK(ran.text("$s") == " ");
  CHECK(ran.text("$a") == "P 12");
  CHECK(ran.text("$m") == "cd");
  CHECK(ran.text("$n") == "");
  CHECK(ran.real("p") == 6.0F);
  CHECK(ran.real("none") == 0.0F);
  CHECK(ran.real("c") == 65.0F);
  CHECK(ran.real("gone") == -1.0F);
  CHECK(ran.real("v") == -12.5F);
  CHECK(ran.text("$e") == "12 -3A");
  CHECK(ran.real("long") == 4.0F);
}

TEST_CASE("a V+ statement that fails ends its task, names its line, and goes on behind it after REACTE") {
  const std::pair<const char*, const char*> cases[] = {
      {"a = b", "t.v2:2: undefined value"},
      {"a = 1/0", "t.v2:2: divide by zero"},
      {"a = list[40000]", "t.v2:2: invalid array index"},
      {"CALL main()", "t.v2:2: too many subroutine calls"},
      {"MOVE #PPOINT(0,0,0,0)", "t.v2:2: no robot is attached"},
      {"SPEED 0", "t.v2:2: a speed"},
      {"RETURNE", "t.v2:2: RETURNE belongs"},
  };
  for (const auto& [line, says] : cases) {
    INFO(line);
    CHECK_THAT(Ran(line).machine.stopped_by(0), Catch::StartsWith(says));
  }
  CHECK_THAT(Ran("\t$a = \"0123456789\"\n\tWHILE TRUE DO\n\t$a = $a+$a\nEND").machine.stopped_by(0),
             Contains("t.v2:4: string too long"));
  const Ran ran("\tREACTE heard\n\ta = 1\n\ta = 1/0\n\tb = 2",
                ".PROGRAM heard()\n\tseen = ERROR(-1)\n\tRETURNE\n.END\n");
  CHECK(ran.real("a") == 1.0F);
  CHECK(ran.real("b") == 2.0F);
  CHECK(ran.real("seen") < 0.0F);
}

TEST_CASE("V+ tasks share the statements of a tick, higher priorities first and equal ones in turn") {
  const std::string count = R"(
.PROGRAM a()
	na = 0
	WHILE TRUE DO
		na = na+1
	END
.END
.PROGRAM b()
	nb = 0
	WHILE TRUE DO
		nb = nb+1
	END
.END
)";
  for (const int budget : {16, 160, 1600}) {
    const Code code = parse({{"t.v2", count}});
    StillArm arm;
    MachineOptions options;
    options.statements_per_tick = budget;
    Machine equal(code, arm, options);
    options.priorities[1] = 30;
    Machine favoured(code, arm, options);
    for (Machine* m : {&equal, &favoured}) {
      m->execute(0, "a", 0);
      m->execute(1, "b", 0);
      run_until(*m, 16 * 16'000 - 1);
      CHECK(m->statements() == std::uint64_t(16 * budget));
    }
    CHECK(std::abs(equal.get("na").real - equal.get("nb").real) < 0.1F * equal.get("na").real + 3.0F);
    CHECK_FALSE(favoured.get("na").defined);
    CHECK(favoured.get("nb").real > 1.9F * equal.get("nb").real);
  }
}

TEST_CASE("a V+ task that waits goes on at the next tick, and one that stops costs nothing") {
  Ran ran("\tn = 0\n\tWHILE n < 10 DO\n\t\tn = n+1\n\t\tWAIT\n\tEND");
  CHECK(ran.real("n") == 10.0F);
  CHECK_FALSE(ran.machine.runs(0));
  CHECK(ran.machine.next_us() == kNeverRuns);
  CHECK(ran.machine.statements() < 50);
}

TEST_CASE("V+ READ returns segments as they come, at most 128 characters, and a client keeps its place") {
  const Code code = parse({{"t.v2", R"(
.PROGRAM main()
	$all = ""
	pieces = 0
	ATTACH (5, 4) "TCP"
	FOPEN (5, 16) "/LOCAL_PORT 4096 /CLIENTS 1"
	opened = IOSTAT(5)
	WHILE TRUE DO
		READ (5, handle, 1) $piece
		got = IOSTAT(5)
		CASE got OF
		  VALUE -526:
			WAIT
		  VALUE 101:
			IF frees THEN
				FCMND (5, 600) $INTB(handle)
			END
		  VALUE 1:
			pieces = pieces+1
			last = LEN($piece)
			bytes = bytes+last
		END
	END
.END
)"}});
  for (const bool frees : {false, true}) {
    StillArm arm;
    Machine m(code, arm, {});
    m.set("frees", frees ? -1.0F : 0.0F);
    m.set("bytes", 0.0F);
    m.execute(0, "main", 0);
    m.network().connected();
    for (const std::size_t n : {1, 2, 300}) m.network().arrived(std::string(n, 'x'));
    run_until(m, 100'000);
    CHECK(m.get("opened").real == 1.0F);
    CHECK(m.get("pieces").real == 5.0F);  // 1, 2, 128, 128, 44
    CHECK(m.get("last").real == 44.0F);
    m.network().disconnected();
    m.network().connected();
    m.network().arrived("again");
    run_until(m, 200'000);
    CHECK(m.get("bytes").real == (frees ? 308.0F : 303.0F));
  }
}

TEST_CASE("the shipped V+ program's CRC is CRC-16/CCITT-FALSE of any text") {
  IceRobotProgram program = shipped_program();
  std::vector<Source> sources;
  for (const IceProgramText& t : program.texts) sources.push_back({t.file, t.text});
  sources.push_back(
      {"t.v2", ".PROGRAM main()\n\tCALL fv.table()\n\tcrc = ^HFFFF\n\tCALL fv.sum($text, crc)\n.END\n"});
  std::mt19937 random(7);
  for (int n = 0; n < 20; ++n) {
    std::string text;
    for (std::size_t k = random() % 121; k-- > 0;) text += char(32 + random() % 95);
    std::string quoted = text;
    for (char& c : quoted) c = c == '"' ? '\'' : c;
    std::vector<Source> all = sources;
    all.back().text.insert(all.back().text.find("\tCALL"), "\t$text = \"" + quoted + "\"\n");
    const Code code = parse(all);
    StillArm arm;
    Machine m(code, arm, {.statements_per_tick = 1600});
    m.execute(0, "main", 0);
    run_until(m, 1'000'000);
    CHECK(m.stopped_by(0) == "");
    CHECK(m.get("crc").real == float(RemainderCcitt().add(quoted).value()));
  }
}

TEST_CASE("a V+ machine that is saved and restored goes on as one that was not") {
  const std::string text = R"(
.PROGRAM main()
	AUTO n
	$log = ""
	EXECUTE 1 other()
	FOR n = 1 TO 1000
		CALL add(n, list[n])
		$log = $ENCODE(/I0,n)+"x"
		WAIT
	END
.END
.PROGRAM add(a, b)
	b = a*2
	WAIT
.END
.PROGRAM other()
	WHILE TRUE DO
		m = TIMER(1)
		TIMER 1 = 0
		WAIT
	END
.END
)";
  const Code code = parse({{"t.v2", text}});
  StillArm arm;
  Machine whole(code, arm, {}), first(code, arm, {}), second(code, arm, {});
  for (Machine* m : {&whole, &first}) m->execute(0, "main", 0);
  run_until(first, 333'333);
  Archive saved;
  first.io(saved);
  Archive loaded(saved.bytes());
  second.io(loaded);
  loaded.expect_end();
  for (Machine* m : {&whole, &second}) run_until(*m, 900'000);
  Archive a, b;
  whole.io(a);
  second.io(b);
  CHECK(a.bytes() == b.bytes());
  const Code another = parse({{"t.v2", ".PROGRAM main()\n.END\n"}});
  Machine wrong(another, arm, {});
  Archive again(saved.bytes());
  CHECK_THROWS_WITH(wrong.io(again), Contains("world state"));
}
