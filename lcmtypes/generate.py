#!/usr/bin/env python3
"""Generates C++ from the words of the house: the .lcm files and channels.table (both described in lcmtypes/README.md).

    lcmtypes/generate.py ROOT OUT TYPE.lcm...

Writes OUT/firn/all_types.h (every message), OUT/firn/enums.h (the enums of the comments), OUT/firn/channels.h (message
classes and channel constants) and OUT/message_tables.cpp (limits, relations, channel rows, the .lcm texts, the texts of
their comments). A file
whose text stays the same is not touched; OUT/generated always is, and OUT/generated.d names the C++ headers read.
"""
import math
import re
import sys
from pathlib import Path

REAL = ("float", "double")
INTEGERS = ("int8_t", "int16_t", "int32_t", "int64_t", "byte", "boolean")
NUMBER = r"[-+0-9.e^* ]+?|-?inf"
RANGE = re.compile(rf"([\[(])\s*({NUMBER})\s*,\s*({NUMBER})\s*([\])])(\s+or NaN)?$")
WHILE = re.compile(r"\s+while\s+([\w.]+)\s*=\s*(-?\w+)(?:\s*\.\.\s*(-?\w+))?$")
ENUM = re.compile(r"(enum|bits)\s+(\w+)(?:\s*\{([^}]*)\})?(?:\s+of\s+(\S+))?$")
EVERY = re.compile(r"//\s*every\s+(\w+):\s*(.*)$")
MEMBER = re.compile(r"\s*(\w+)\s+(\w+)\s*((?:\[\w+\])*)\s*;\s*(?://\s?(.*))?$")


class Mistake(Exception):
    pass


def number(text):
    """A number of a range: 127, 1e6, 2^53, 127*4096^2, inf."""
    text = text.strip()
    if text.endswith("inf"):
        return math.copysign(math.inf, -1 if text.startswith("-") else 1)
    product = 1
    for factor in text.split("*"):
        base, _, power = factor.strip().partition("^")
        value = int(base) if re.fullmatch(r"[-+]?\d+", base) else float(base)
        product *= value ** int(power) if power else value
    return product


class Condition:
    """`while MEMBER = A` or `while MEMBER = A..B`; A and B are numbers or values of the member's enum."""

    def __init__(self, member="", low=0, high=0):
        self.member, self.low, self.high = member, low, high


class Member:
    def __init__(self, kind, name, dimensions, comment):
        self.type, self.name, self.dimensions, self.comment = kind, name, dimensions, comment
        self.ranges = []     # (sub-path, low, high, above_low, nan_ok, condition)
        self.relations = []  # (kind, b, c, condition)
        self.enum = None     # name
        self.range = ""      # the first one, as written
        self.text = ""       # the comment behind the clauses


class Enum:
    def __init__(self, name, bits, underlying):
        self.name, self.bits, self.underlying = name, bits, underlying
        self.values, self.header, self.users = None, None, []
        self.text = ""       # of the values, as written


def pieces(comment):
    """The comment cut at semicolons outside braces."""
    depth, start = 0, 0
    for at, c in enumerate(comment):
        depth += (c == "{") - (c == "}")
        if c == ";" and depth == 0:
            yield comment[start:at].strip()
            start = at + 1
    yield comment[start:].strip()


def parse_values(text, where):
    values, following = {}, 0
    for entry in re.sub(r"//[^\n]*", "", text).split(","):
        if not entry.strip():
            continue
        match = re.fullmatch(r"\s*(k\w+)\s*(?:=\s*(\d+))?\s*", entry)
        if not match:
            raise Mistake(f"{where}: '{entry.strip()}' is no enum value such as kName = 1")
        following = int(match[2]) if match[2] else following
        values[match[1]] = following
        following += 1
    return values


def values_in_header(root, header, name):
    """Of `enum class NAME` in a C++ header."""
    text = re.sub(r"//[^\n]*", "", (root / header).read_text())
    match = re.search(rf"enum class {name}\s*:[^{{]*\{{([^}}]*)\}}", text)
    if not match:
        raise Mistake(f"{header}: enum class {name} is not here")
    return parse_values(match[1], header)


class Type:
    def __init__(self, path, every):
        self.path, self.members = path, []
        text = path.read_text()
        for line in text.splitlines():
            if match := EVERY.match(line):
                every[match[1]] = match[2]
        head, _, body = text.partition("{\n")
        match = re.search(r"struct\s+(\w+)\s*$", head)
        if not match or match[1] != path.stem:
            raise Mistake(f"{path.name}: 'struct {path.stem} {{' is wanted")
        self.name = match[1]
        above = (line.strip().removeprefix("//").strip() for line in head.splitlines() if line.strip().startswith("//"))
        self.text = " ".join(filter(None, above))
        for number_, line in enumerate(body.splitlines(), head.count("\n") + 2):
            match = MEMBER.match(line)
            if match:
                self.members.append(Member(match[1], match[2], re.findall(r"\[(\w+)\]", match[3]), match[4] or ""))
            elif line.strip().startswith("//") and self.members:
                self.members[-1].comment += " " + line.strip()[2:].strip()
            elif line.strip() not in ("", "}"):
                raise Mistake(f"{path.name}:{number_}: '{line.strip()}' is no member of one line")

    def member(self, path):
        for m in self.members:
            if m.name == path:
                return m
        return None


class Words:
    def __init__(self, root, files):
        self.root, self.every, self.enums = root, {}, {}
        self.types = {}
        for file in files:
            t = Type(Path(file), self.every)
            self.types[t.name] = t
        for t in self.types.values():
            for m in t.members:
                self.read_clauses(t, m)
        for e in self.enums.values():
            if e.values is None:
                raise Mistake(f"{e.users[0]}: enum {e.name} has no values anywhere")
            values = sorted(e.values.values())
            if not e.bits and values != list(range(values[0], values[0] + len(values))):
                raise Mistake(f"{e.users[0]}: the values of enum {e.name} leave a gap")
            if e.header and e.values != values_in_header(root, e.header, e.name):
                raise Mistake(f"{e.users[0]}: the values of enum {e.name} are not those of {e.header}")
        for t in self.types.values():
            for m in t.members:
                self.finish(t, m)

    def read_clauses(self, t, m):
        where = f"{t.path.name}: {m.name}"
        texts = list(pieces(m.comment))
        for at, text in enumerate(texts):
            if self.clause(where, m, text):
                m.range = m.range or (text if re.match(r"[\[(].*,", text) else "")
                continue
            m.text = "; ".join(texts[at:])
            if re.match(r"[\[(=<.]|(enum|bits)\b", text):
                raise Mistake(f"{where}: '{text}' is neither range, relation nor enum")
            break

    def clause(self, where, m, text):
        condition = Condition()
        whole = text
        if match := WHILE.search(text):
            condition, text = Condition(match[1], match[2], match[3] or match[2]), text[:match.start()]
        sub, match = "", re.match(r"\.(\w+)\s+(.*)", text)
        if match:
            sub, text = "." + match[1], match[2]
        if match := RANGE.match(text):
            low, high = number(match[2]), number(match[3])
            if match[4] == ")" and high != math.inf:
                raise Mistake(f"{where}: the upper end of '{whole}' is part of the range")
            m.ranges.append((sub, low, high, match[1] == "(" and low != -math.inf, bool(match[5]), condition))
        elif match := ENUM.match(whole):
            self.enum_clause(where, m, match)
        elif match := re.match(r"= ([\w.]+) \* ([\w.]+)( or 0)?$", text):
            m.relations.append(("kCellsOrNone" if match[3] else "kCells", match[1], match[2], condition))
        elif match := re.match(r"(<=?) ([\w.]+)$", text):
            m.relations.append(("kLess" if match[1] == "<" else "kNotAbove", match[2], "", condition))
        else:
            return False
        return True

    def enum_clause(self, where, m, match):
        bits, name, values, header = match[1] == "bits", match[2], match[3], match[4]
        e = self.enums.setdefault(name, Enum(name, bits, m.type))
        e.users.append(where.replace("_t.lcm: ", "_t."))
        if values:
            if e.values is not None:
                raise Mistake(f"{where}: enum {name} has its values at {e.users[0]}")
            e.values, e.header, e.text = parse_values(values, where), header, values
        m.enum = name

    def finish(self, t, m):
        """The range that an enum or `every` gives, and the names in conditions as numbers."""
        where = f"{t.path.name}: {m.name}"
        if m.enum and not any(not r[5].member for r in m.ranges):
            e = self.enums[m.enum]
            values = e.values.values()
            low, high = (0, sum(values)) if e.bits else (min(values), max(values))
            m.ranges.insert(0, ("", low, high, False, False, Condition()))
        elif not m.ranges and m.name in self.every:
            self.clause(where, m, self.every[m.name])
        if m.type in REAL + INTEGERS and not any(not r[0] and not r[5].member for r in m.ranges):
            raise Mistake(f"{where} has no range; one is wanted, such as // [0, 127]")
        for condition in [r[5] for r in m.ranges] + [r[3] for r in m.relations]:
            if not condition.member:
                continue
            if not (tested := t.member(condition.member)):
                raise Mistake(f"{where}: no member {condition.member}")
            condition.low = self.value(where, tested, condition.low)
            condition.high = self.value(where, tested, condition.high)

    def value(self, where, member, text):
        if not isinstance(text, str):
            return text
        if re.fullmatch(r"-?\d+", text):
            return int(text)
        if not member.enum or text not in self.enums[member.enum].values:
            raise Mistake(f"{where}: {text} is no value of {member.name}")
        return self.enums[member.enum].values[text]

    def field(self, t, path):
        """The number at a dotted path."""
        head, _, rest = path.partition(".")
        m = t.member(head)
        if m and rest:
            return self.field(self.types[m.type], rest) if m.type in self.types else None
        return m

    def limits(self):
        """(type, path, low, high, above_low, nan_ok, condition); a range of the outer type comes first and wins."""
        for t in self.types.values():
            for m in t.members:
                for sub, *range_, condition in m.ranges:
                    if not self.field(t, m.name + sub):
                        raise Mistake(f"{t.path.name}: {m.name} has no member {sub}")
                    yield t.name, m.name + sub, *range_, condition
                if m.type not in self.types or m.dimensions:
                    continue
                given = {r[0] for r in m.ranges if not r[5].member}
                for inner in self.types[m.type].members:
                    for sub, *range_, condition in inner.ranges:
                        if "." + inner.name + sub not in given and not condition.member:
                            yield t.name, f"{m.name}.{inner.name}{sub}", *range_, condition

    def relations(self):
        for t in self.types.values():
            for m in t.members:
                for kind, b, c, condition in m.relations:
                    for path in filter(None, (b, c)):
                        if not self.field(t, path):
                            raise Mistake(f"{t.path.name}: {m.name}: no member {path}")
                    if kind == "kNotAbove" and m.dimensions and not self.field(t, b).dimensions:
                        kind = "kAllNotAbove"
                    yield t.name, kind, m.name, b, c, condition


class Channels:
    """channels.table: one row a node, one a channel; * in a name stands for the node, in capitals."""
    KINDS = ("node", "driver", "process")
    COLUMNS = ("name", "type", "publisher", "delivery", "rate_hz", "queue", "logged", "read")
    CHOICES = {"delivery": ("reliable", "latest"), "logged": ("logged", "-"), "read": ("nodes", "-")}

    def __init__(self, path, types):
        self.nodes, self.rows = [], []
        for at, line in enumerate(path.read_text().splitlines(), 1):
            if not line.strip() or line.startswith("#"):
                continue
            if line.startswith("node "):
                self.add_node(f"{path.name}:{at}", line.split()[1:])
                continue
            cells = line.split(None, len(self.COLUMNS))
            if len(cells) <= len(self.COLUMNS):
                raise Mistake(f"{path.name}:{at}: a row has {len(self.COLUMNS) + 1} columns")
            row = dict(zip(self.COLUMNS + ("meaning",), cells))
            for column, choices in self.CHOICES.items():
                if row[column] not in choices:
                    raise Mistake(f"{path.name}:{at}: {column} is {row[column]}, not {' or '.join(choices)}")
            if row["type"] not in types:
                raise Mistake(f"{path.name}:{at}: there is no {row['type']}.lcm")
            self.rows.append(row)

    def add_node(self, where, cells):
        if len(cells) != 3 or cells[2] not in self.KINDS:
            raise Mistake(f"{where}: a node has a name, its longest step [s] and is one of {', '.join(self.KINDS)}")
        if self.nodes and self.nodes[-1][2] == "process" and cells[2] != "process":
            raise Mistake(f"{where}: processes that are not replayed come last")
        self.nodes.append((cells[0], float(cells[1]), cells[2]))

    def shared(self):
        return [r for r in self.rows if "*" not in r["name"]]

    def families(self):
        return [r for r in self.rows if "*" in r["name"]]


def camel(name, separator="_"):
    return "".join(part.capitalize() for part in name.lower().split(separator))


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def real(value):
    if math.isinf(value):
        return "kAny" if value > 0 else "-kAny"
    return str(int(value)) if value == int(value) and abs(value) < 2**31 else repr(float(value))


def all_types(words):
    return ("// Every message, and their list: who handles every type misses none.\n#pragma once\n\n"
            + "".join(f'#include "firn/{t}.hpp"\n' for t in words.types)
            + "\nnamespace firn {\ntemplate <class... M>\nstruct TypeList {};\nusing AllTypes = TypeList<"
            + ", ".join(words.types) + ">;\n}  // namespace firn\n")


def enums(words):
    out = "// The small numbers in messages by name, from the comments of the .lcm files.\n#pragma once\n\n#include <cstdint>\n\n"
    listed = [e for e in words.enums.values()]
    out += "".join(f'#include "{h}"\n' for h in sorted({e.header for e in listed if e.header}))
    out += "\nnamespace firn {\n"
    for e in listed:
        if e.header:
            continue
        values = ", ".join(f"{name} = {value}" for name, value in e.values.items())
        out += (f"\n/// {', '.join(e.users)}\nenum {'' if e.bits else 'class '}{e.name} : std::{e.underlying} "
                f"{{ {values} }};\n")
    return out + "\n}  // namespace firn\n"


def channel_constants(words, channels):
    out = "// Message classes, nodes and the channels that stand alone, from channels.table.\n#pragma once\n\n"
    out += '#include <cstdint>\n\n#include "lcmtypes/channel.h"\n\nnamespace firn {\n\n'
    replayed = sum(kind != "process" for _, _, kind in channels.nodes)
    out += "enum class NodeId : std::uint8_t {\n" + "".join(f"  k{camel(name)},\n" for name, _, _ in channels.nodes) + "};\n"
    out += (f"inline constexpr int kNodeCount = {len(channels.nodes)};\n"
            f"inline constexpr int kReplayedNodeCount = {replayed};  ///< the first ones\n\n")
    out += "".join(f"class {t};\n" for t in words.types) + "\nnamespace channels {\n"
    for row in channels.shared():
        out += f'inline constexpr Channel<{row["type"]}> k{camel(row["name"])}{{"{row["name"]}"}};\n'
    return out + "}  // namespace channels\n}  // namespace firn\n"


def tables(words, channels):
    out = ('#include <limits>\n\n#include "lcmtypes/channel_rows.h"\n#include "lcmtypes/limits.h"\n'
           '#include "lcmtypes/member_texts.h"\n'
           '#include "lcmtypes/schema.h"\n\nnamespace firn {\nnamespace {\n\n'
           "constexpr double kAny = std::numeric_limits<double>::max();\nusing enum Delivery;\n\n"
           "constexpr Limit kLimits[] = {\n")
    truth = ("false", "true")
    for type_, path, low, high, above, nan, c in words.limits():
        out += f"    {{{quoted(type_)}, {quoted(path)}, {real(low)}, {real(high)}, {truth[above]}, {truth[nan]}"
        out += (f", {quoted(c.member)}, {c.low}, {c.high}" if c.member else "") + "},\n"
    out += "};\n\nconstexpr Relation kRelations[] = {\n"
    for type_, kind, a, b, c, condition in words.relations():
        out += f"    {{{quoted(type_)}, Relation::Kind::{kind}, {quoted(a)}, {quoted(b)}, {quoted(c)}"
        out += (f", {quoted(condition.member)}, {condition.low}, {condition.high}" if condition.member else "") + "},\n"
    out += "};\n\n"

    def row(r, name, publisher):
        return (f"    {{{quoted(name)}, {quoted(r['type'])}, {publisher}, k{r['delivery'].capitalize()}, {r['rate_hz']}, "
                f"{r['queue']}, {truth[r['logged'] == 'logged']}, {quoted(r['meaning'])}, {truth[r['read'] == 'nodes']}}},\n")

    out += "constexpr NodeInfo kNodes[] = {\n"
    for name, longest_s, kind in channels.nodes:
        out += f"    {{NodeId::k{camel(name)}, {quoted(name)}, {longest_s}, {truth[kind == 'driver']}}},\n"
    out += "};\n\nconstexpr ChannelInfo kShared[] = {\n"
    for r in channels.shared():
        out += row(r, r["name"], f"NodeId::k{camel(r['publisher'])}")
    out += "};\n\nconstexpr ChannelFamily kFamilies[] = {\n"
    for r in channels.families():
        out += row(r, r["name"].replace("*", ""), f"ChannelFamily::k{camel(r['publisher'])}")
    out += ("};\n\n}  // namespace\n\nstd::span<const Limit> limits() { return kLimits; }\n"
            "std::span<const Relation> relations() { return kRelations; }\n"
            "std::span<const NodeInfo> nodes() { return kNodes; }\n"
            "std::span<const ChannelInfo> shared_channels() { return kShared; }\n"
            "std::span<const ChannelFamily> channel_families() { return kFamilies; }\n\n"
            "std::string_view lcm_type_texts() {\n  return ")
    out += "\n".join(f'R"lcm({t.path.read_text()})lcm"' for t in words.types.values())
    out += ";\n}\n\nnamespace {\n\nconstexpr MemberText kMemberTexts[] = {\n"
    for t in words.types.values():
        for m in t.members:
            texts = (t.name, m.name, m.text, m.range, words.enums[m.enum].text if m.enum else "")
            out += f"    {{{', '.join(map(quoted, texts))}}},\n"
    out += "};\n\nconstexpr TypeText kTypeTexts[] = {\n"
    out += "".join(f"    {{{quoted(t.name)}, {quoted(t.text)}}},\n" for t in words.types.values())
    return out + ("};\n\n}  // namespace\n\nstd::span<const MemberText> member_texts() { return kMemberTexts; }\n"
                  "std::span<const TypeText> type_texts() { return kTypeTexts; }\n\n}  // namespace firn\n")


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.is_file() or path.read_text() != text:
        path.write_text(text)


def main(root, out, *files):
    root, out = Path(root), Path(out)
    try:
        words = Words(root, files)
        channels = Channels(root / "lcmtypes/channels.table", words.types)
        write(out / "firn/all_types.h", all_types(words))
        write(out / "firn/enums.h", enums(words))
        write(out / "firn/channels.h", channel_constants(words, channels))
        write(out / "message_tables.cpp", tables(words, channels))
        headers = sorted({str(root / e.header) for e in words.enums.values() if e.header})
        write(out / "generated.d", f"{out / 'generated'}: {' '.join(headers)}\n")
        (out / "generated").touch()
    except Mistake as mistake:
        sys.exit(f"lcmtypes: {mistake}")


if __name__ == "__main__":
    main(*sys.argv[1:])
