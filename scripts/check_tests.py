#!/usr/bin/env python3
"""Every TEST_CASE asserts something before it may return, and no assertion holds by itself.

Assertions are Catch's macros and calls of functions, lambdas and macros of tests/ that make some. A test that calls
skip() (tests/support/skip.h) is reported as skipped and may return. What no text shows, such as a loop over nothing, is
found as the tests run: each one without an assertion fails (tests/catch_main.cpp).

    scripts/check_tests.py [ROOT]
"""
import re
import sys
from pathlib import Path

from firn_tree import code, finish, read, sources

ASSERTION = re.compile(r"\b(?:CHECK|REQUIRE)(?:_FALSE|_THAT|_NOTHROW|_THROWS|_THROWS_AS|_THROWS_WITH|_THROWS_MATCHES)?\s*\(|\b(?:FAIL|FAIL_CHECK)\s*\(")
TRUTH = re.compile(r"\b(?:CHECK|REQUIRE)(?:_FALSE)?\s*\(")
TEST = re.compile(r"\b(?:TEMPLATE_|)TEST_CASE(?:_METHOD|_SIG)?\s*\(")
NAMED_LIKE_AN_OPTION = re.compile(r"TEST_CASE(?:_METHOD|_SIG)?\s*\(\s*\"-")
CALL = re.compile(r"(?<![\w.>])(~?[A-Za-z_]\w*)\s*(?:<[^<>;(){}]*>)?\s*\(|(?:\.|->)([A-Za-z_]\w*)\s*\(")
KEYWORDS = {"if", "for", "while", "switch", "catch", "return", "sizeof", "decltype", "alignof", "noexcept", "requires", "constexpr"}
OPEN, CLOSE = "([{", ")]}"


def closing(text, at):
    """Position of the bracket that closes the one at `at`; the text's end if none does."""
    depth = 0
    for n in range(at, len(text)):
        depth += (text[n] in OPEN) - (text[n] in CLOSE)
        if depth == 0:
            return n
    return len(text) - 1


def line_of(text, at):
    return text.count("\n", 0, at) + 1


def bodies(text):
    """(name, begin, end) of the braces of every function definition and test case."""
    found = []
    for match in CALL.finditer(text):
        name = match.group(1)
        if name is None or name in KEYWORDS:
            continue
        end = closing(text, match.end() - 1) + 1
        rest = re.match(r"\s*(?:const\b|noexcept\b|override\b|final\b|&&?|->\s*[\w:<>,&* ]+|:(?!:)[^;{}]*(?:\{[^{};]*\}[^;{}]*)*)?\s*", text[end:])
        begin = end + rest.end()
        if text[begin:begin + 1] == "{":
            found.append((name, begin, closing(text, begin)))
    return found


LAMBDA = re.compile(r"\[[^\[\]]*\]\s*(?:\([^()]*(?:\([^()]*\)[^()]*)*\)\s*)?(?:mutable\s*|noexcept\s*|->\s*[\w:<>&* ]+\s*)*\{")


def without_lambdas(text):
    """The text with the bodies of its lambdas blanked, and {name: body} of those that have a name."""
    named, out, at = {}, list(text), 0
    for match in LAMBDA.finditer(text):
        if match.start() < at:
            continue
        begin, end = match.end() - 1, closing(text, match.end() - 1)
        name = re.search(r"(\w+)\s*(?:=\s*|\{\s*)$", text[:match.start()])
        called_at_once = text[end + 1:end + 2] == "("
        if not called_at_once:
            if name:
                named[name.group(1)] = text[begin:end]
            out[begin + 1:end] = [c if c == "\n" else " " for c in text[begin + 1:end]]
            at = end
    return "".join(out), named


def calls(text):
    return {name for pair in CALL.findall(text) for name in pair if name}


def closure(functions, is_one):
    """Names of functions of which a body is one or calls one."""
    found, grew = {name for name, texts in functions.items() if any(map(is_one, texts))}, True
    called = {name: set().union(*map(calls, texts)) for name, texts in functions.items()}
    while grew:
        more = {name for name in functions if name not in found and called[name] & found}
        found, grew = found | more, bool(more)
    return found


class Tests:
    """What the files of tests/ define."""

    def __init__(self, root):
        self.texts = {path: code(read(root, path)) for path in sources(root, ("tests",))}
        functions, self.constants, self.macros = {}, {}, {}
        for text in self.texts.values():
            for name, begin, end in bodies(text):
                if not TEST.match(name + "("):
                    functions.setdefault(name, []).append(text[begin:end])
            for name, body in re.findall(r"\b(?:const|constexpr)\s+(?:auto|bool|int)\s+(\w+)\s*(?:=\s*|\{)\s*(true|false|[01])\s*[;}]", text):
                self.constants[name] = body
            for name, parameters, body in re.findall(r"^[ \t]*#[ \t]*define[ \t]+(\w+)(\([^)]*\))?((?:\\\n|[^\n])*)", text, re.M):
                self.macros[name] = body.replace("\\\n", " ")
                functions.setdefault(name, []).append(self.macros[name])
        self.asserting = closure(functions, ASSERTION.search)
        self.skipping = closure(functions, re.compile(r"\bskip\s*\(").search) | {"skip"}

    def expand(self, text):
        for _ in range(8):
            text = re.sub(r"\b\w+\b", lambda m: self.macros.get(m.group(0), self.constants.get(m.group(0), m.group(0))), text)
        return text


def blocks_of(text, at):
    """Positions of the braces that are open at `at`."""
    open_ = []
    for n in range(at):
        if text[n] == "{":
            open_.append(n)
        elif text[n] == "}" and open_:
            open_.pop()
    return open_


def statement_before(text, at):
    return re.split(r"[;{}]", text[:at])[-1]


def check_case(tests, path, text, begin, end, problems):
    body, named = without_lambdas(text[begin + 1:end])
    asserting = tests.asserting | closure({**{n: [t] for n, t in named.items()}}, lambda t: ASSERTION.search(t) or calls(t) & tests.asserting)
    whole = text[begin + 1:end]

    def places(text_):
        return [m.start() for m in ASSERTION.finditer(text_)] + \
            [m.start() for m in CALL.finditer(text_) if (m.group(1) or m.group(2)) in asserting]

    if not places(whole):
        problems.append(f"{path}:{line_of(text, begin)}: a test case without an assertion")
        return
    sure = [at for at in places(body) if not re.match(r"\s*(?:else\b|if\b|for\b|while\b|switch\b)", statement_before(body, at))]
    sure = [(at, blocks_of(body, at)) for at in sure]
    for match in re.finditer(r"\breturn\b", body):
        at = match.start()
        around = blocks_of(body, at)
        if any(q < at and inside == around[:len(inside)] for q, inside in sure):
            continue
        previous = [statement_before(body, at)]
        if not previous[0].strip() and around:
            previous += re.split(r"[;}]", body[around[-1] + 1:at]) + [statement_before(body, around[-1])]
        returned = body[at:body.find(";", at)]
        if calls(" ".join(previous + [returned])) & tests.skipping:
            continue
        problems.append(f"{path}:{line_of(text, begin + 1 + at)}: a test case that may return before its first assertion")


EITHER_WAY = re.compile(r"\btrue\s*\)*\s*\|\||\|\|\s*\(*\s*true\b|\bfalse\s*\)*\s*&&|&&\s*\(*\s*false\b")
LITERAL = re.compile(r"[\s()!&|<>=+*/%^~-]*(?:(?:true|false|nullptr|\d[\w.']*|\"\")[\s()!&|<>=+*/%^~-]*)+")


def check_truths(tests, path, text, problems):
    """Assertions whose argument has no variable and no call once macros and named constants are replaced."""
    wrappers = [name for name, body in tests.macros.items() if TRUTH.search(body)]
    makes = re.compile("|".join([TRUTH.pattern, *(rf"\b{name}\s*\(" for name in wrappers)]))
    for match in makes.finditer(text):
        if re.search(r"#[ \t]*define[ \t]+$", text[:match.start()]):
            continue
        argument = text[match.end():closing(text, match.end() - 1)]
        expanded = tests.expand(argument)
        same = re.fullmatch(r"\s*(\w+)\s*==\s*(\w+)\s*", argument)
        if LITERAL.fullmatch(expanded) or EITHER_WAY.search(expanded) or (same and same.group(1) == same.group(2)):
            problems.append(f"{path}:{line_of(text, match.start())}: an assertion that holds by itself ({' '.join(argument.split())})")


def check(root):
    tests, problems = Tests(root), check_long_cases(root)
    for path, text in tests.texts.items():
        for match in TEST.finditer(text):
            end = closing(text, match.end() - 1) + 1
            brace = re.match(r"\s*\{", text[end:])
            if brace:
                begin = end + brace.end() - 1
                check_case(tests, path, text, begin, closing(text, begin), problems)
        check_truths(tests, path, text, problems)
        for match in NAMED_LIKE_AN_OPTION.finditer(read(root, path)):
            problems.append(f"{path}:{line_of(read(root, path), match.start())}: a test case whose name begins with '-': Catch takes it for an option")
    return problems


LONG_CASES = "tests/support/long_cases.h"


def check_long_cases(root):
    return [f"{path}: asks for FIRN_FULL itself: {LONG_CASES} shortens long loops" for path in sources(root, ("tests",))
            if path not in (LONG_CASES, "tests/house/long_cases_test.cpp") and "FIRN_FULL" in code(read(root, path), keep_strings=True)]


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent)
    return finish("check_tests", check(root))


if __name__ == "__main__":
    sys.exit(main())
