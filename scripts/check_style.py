#!/usr/bin/env python3
"""The look of the sources: clang-format, no line above 110 columns, no statements joined by commas.

    scripts/check_style.py [ROOT]
"""
import re
import shutil
import subprocess
import sys
from pathlib import Path

from firn_tree import finish, read, sources

MAX_COLUMNS = 110
TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)


def check_columns(root):
    """Raw strings (style sheets, recorded texts) are as long as they are."""
    problems = []
    for path in sources(root):
        text = re.sub(r'R"(\w*)\(.*?\)\1"', lambda m: "\n" * m.group(0).count("\n"), read(root, path), flags=re.S)
        problems += [f"{path}:{n}: {len(line)} columns, the limit is {MAX_COLUMNS}"
                     for n, line in enumerate(text.split("\n"), 1) if len(line) > MAX_COLUMNS]
    return problems


def masked(text):
    """C++ of the same length, without comments, contents of strings, and preprocessor lines."""
    def blank(match):
        token = match.group(0)
        if token.startswith("/"):
            return re.sub(r"[^\n]", " ", token)
        return '"' + re.sub(r"[^\n]", "_", token[1:-1]) + '"'
    text = TOKEN.sub(blank, re.sub(r"(?<=[0-9a-fA-F])'(?=[0-9a-fA-F])", "_", text))
    lines, goes_on = [], False
    for line in text.split("\n"):
        if goes_on or re.match(r"\s*#", line):
            goes_on, line = line.rstrip().endswith("\\"), " " * len(line)
        lines.append(line)
    return "\n".join(lines)


def opens_block(head, in_parentheses):
    """Does the { behind `head` open a block of statements, and no list of initial values?"""
    if re.search(r"\b(struct|class|enum|namespace|union)\b[^=()]*$", head) or re.search(r'\bextern "_*"$', head):
        return True
    if head[-1:] in ("", ";", "{", "}", ":"):
        return not in_parentheses
    if head.endswith("]"):
        return bool(re.search(r"(?:[=(,]|return|^)\s*\[[^\[\]]*\]$", head))
    return head.endswith(")") or bool(re.search(r"(\belse|\bdo|\btry|\bconst|\bnoexcept|\boverride|\bfinal|\bmutable)$", head)
                                      or re.search(r"\)\s*->\s*[\w:<>,\s&*]+$", head))


def simple_statements(text):
    """(begin, end) of everything that ends at a ; outside of parentheses; `text` is masked."""
    stack, begin, found = [], 0, []
    for i, c in enumerate(text):
        if c in "([":
            stack.append(c)
        elif c in ")]":
            if stack and stack[-1] in "([":
                stack.pop()
        elif c == "{":
            block = opens_block(text[begin:i].rstrip(), bool(stack) and stack[-1] in "([")
            stack.append("block" if block else c)
            begin = i + 1 if block else begin
        elif c == "}":
            while stack and stack[-1] in "([":
                stack.pop()
            if stack and stack.pop() == "block":
                begin = i + 1
        elif c == ";" and not (stack and stack[-1] != "block"):
            found.append((begin, i))
            begin = i + 1
    return found


HEAD = re.compile(r"\s*(?:else\b|do\b|case\b[^:?]*(?:::[^:?]*)*:(?!:)|default\s*:|(?:public|private|protected)\s*:)")
CONTROL = re.compile(r"\s*(?:if\s+constexpr|if|while|for|switch)\s*(?=\()")
OPERAND = re.compile(r"(?:\+\+|--|return\b|\(void\)|\*?[A-Za-z_][\w:]*(?:\.|->|\[|\(|\s*(?:[-+*/|&^%]|<<|>>)?=[^=]|\+\+|--))")
DECLARES = re.compile(r"(using|template|typedef|static_assert|alignas|friend|goto|throw|delete|new|operator)\b")


def behind_heads(statement):
    """What a statement does, without its if (…), for (…), else, case and default."""
    while True:
        match = HEAD.match(statement)
        if not match and CONTROL.match(statement):
            depth, end = 0, CONTROL.match(statement).end()
            for end in range(end, len(statement)):
                depth += (statement[end] == "(") - (statement[end] == ")")
                if depth == 0:
                    break
            statement = statement[end + 1:]
            continue
        if not match:
            return statement.strip()
        statement = statement[match.end():]


def joined_by_commas(statement):
    """Is it `a = 1, b = 2`? A declaration of several variables is none."""
    if not OPERAND.match(statement) or DECLARES.match(statement):
        return False
    depth, pieces = 0, [""]
    for c in re.sub(r"<[\w\s,:*&()]*>(?=\()", "", statement):  # arguments of templates
        depth += (c in "([{") - (c in ")]}")
        if c == "," and depth == 0:
            pieces.append("")
        else:
            pieces[-1] += c
    return len(pieces) > 1 and depth == 0 and all(re.match(r"\s*(?:\+\+|--|\(void\)|[*(]?[A-Za-z_])", p) for p in pieces)


def check_commas(root):
    problems = []
    for path in sources(root):
        text = masked(read(root, path))
        for begin, end in simple_statements(text):
            statement = behind_heads(text[begin:end])
            if joined_by_commas(statement):
                problems.append(f"{path}:{text.count(chr(10), 0, end) + 1}: two statements joined by a comma "
                                f"({' '.join(statement.split())[:60]})")
    return problems


def check_format(root):
    program = shutil.which("clang-format") or shutil.which("clang-format-14")
    if not program:
        return ["clang-format is not installed (scripts/packages.txt names its package)"]
    if not (Path(root) / ".clang-format").is_file():
        return []
    answer = subprocess.run([program, "--dry-run", "-Werror", *sources(root)], cwd=root, capture_output=True, text=True)
    return sorted({line.split(":")[0] + ": clang-format would change it" for line in answer.stderr.split("\n") if ": error:" in line})


CHECKS = (check_columns, check_commas, check_format)


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent)
    return finish("check_style", [problem for check in CHECKS for problem in check(root)])


if __name__ == "__main__":
    sys.exit(main())
