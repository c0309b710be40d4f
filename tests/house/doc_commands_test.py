#!/usr/bin/env python3
"""scripts/doc_commands.py finds the commands of the documents as a reader gives them, and leaves none out without a reason."""
import re
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import doc_commands  # noqa: E402

PAGE = """# A page
`./firn compare a.toml` and `firn replay` are code, `./firn` alone is none.

    ./firn plan a.csv \\
        -o b.traj                        # a remark
    firn audit RUN [--seal DIGEST] [--json]
    firn ctl RUN pause | continue | set KEY=VALUE [--id N [--json]]
                 [--more]…
    clean: 19 layers

```
cp a.toml b.toml
./firn print b.toml --set control.x=0.7  # exits with 3
firn print: refused
```
```text
./firn output
```
```toml
# lab.toml
[lab]
```
"""


class DocCommands(unittest.TestCase):
    def commands(self, text, page="docs/page.md"):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, page)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
            return doc_commands.page_commands(folder, page)

    def test_blocks_and_spans_are_read_in_their_order_and_output_is_not(self):
        found = [one.shell or f"writes {one.given}" for one in self.commands(PAGE)]
        self.assertEqual([re.sub(" +", " ", one.split("  #")[0]) for one in found], [
            "./firn compare a.toml", "./firn plan a.csv -o b.traj", "./firn audit RUN", "./firn ctl RUN pause", "cp a.toml b.toml",
            "./firn print b.toml --set control.x=0.7", "writes lab.toml"])

    def test_a_command_exits_as_its_page_says_and_a_print_may_end_out_of_tolerance(self):
        exits = {one.shell.split()[1]: one.exits for one in self.commands(PAGE) if one.shell}
        self.assertEqual(exits["print"], (3,))
        self.assertEqual(exits["audit"], (0,))
        self.assertEqual(self.commands("`./firn print a.toml`")[0].exits, (0, 4))

    def test_the_lines_are_those_of_the_page(self):
        lines = PAGE.split("\n")
        for one in self.commands(PAGE):
            self.assertIn(one.given.split()[-1].split("]")[0].lstrip("[#"), "\n".join(lines[one.line - 1:one.line + 2]), one)

    def test_every_placeholder_of_the_documents_is_known(self):
        for page, commands in doc_commands.all_commands(ROOT).items():
            for one in commands:
                left = doc_commands.CAPITALS.findall(re.sub(r"\bRUN\b", "", doc_commands.COMMENT.sub("", one.shell)))
                self.assertTrue(one.left_out or not left, f"{page}:{one.line}: {one.shell}: what is {left}?")

    def test_rows_of_the_tables_are_used(self):
        found = [(page, one) for page, commands in doc_commands.all_commands(ROOT).items() for one in commands if one.shell]
        for table in (doc_commands.BEFORE, doc_commands.EXPECTED, doc_commands.LEFT_OUT):
            for row in table:
                self.assertTrue(any(row[0] in ("", page) and re.search(row[1], one.shell) for page, one in found), row)

    def test_the_tutorials_are_whole(self):
        for page in ("docs/tutorials/operator.md", "docs/tutorials/your-lab.md"):
            text = (ROOT / page).read_text(encoding="utf-8")
            given = sum(line.startswith("./firn ") for line in text.split("\n"))
            self.assertGreaterEqual(len(doc_commands.page_commands(ROOT, page)), given)


if __name__ == "__main__":
    unittest.main()
