#!/usr/bin/env python3
"""docs/openapi.json is true: every request that it describes is answered so, and no other is answered below /api/v1.

    tests/page/api_test.py FIRN ROOT [Case.test]
"""
import json
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import urllib.error
import urllib.request
from pathlib import Path

import jsonschema

FIRN, ROOT = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
GOLDEN = ROOT / "tests/replay/golden"
API = json.loads((ROOT / "docs/openapi.json").read_text(encoding="utf-8"))
OPERATIONS = {(method.upper(), path): operation for path, item in API["paths"].items() for method, operation in item.items()
              if method != "parameters"}
SAMPLE = re.compile(r'^(\w+)(?:\{((?:\w+="(?:[^"\\\n]|\\.)*",?)*)\})? ([-+0-9.e]+)$')


def at(path, run):
    """A described path with the address of a run, and a layer and a surface that every run has."""
    return path.replace("{run}", run or "").replace("{layer}", "1").replace("{surface}", "measured")


class Api(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.runs = Path(scratch.name) / "runs"
        for name in ("v1.0-mpc", "v1.0-ice", "v1.0-lines"):
            shutil.copytree(GOLDEN / name, self.runs / name)
        done = subprocess.run([FIRN, "print", ROOT / "experiments/cuboid.toml", "--bus", "in-process", "--set", "part.height_mm=0.05",
                               "--fault", "10 jet close", "--runs", self.runs], capture_output=True, check=False)
        self.assertEqual(done.returncode, 3)
        self.server = subprocess.Popen([FIRN, "view", self.runs, "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(self.server.stdout.close)
        self.addCleanup(self.server.wait)
        self.addCleanup(self.server.terminate)
        told = json.loads(self.server.stdout.readline())
        self.address, self.token = told["address"].rstrip("/"), told["token"]

    def ask(self, path, method="GET", body=None, token=None, content="application/json"):
        """(status, type, body)"""
        headers = {"Authorization": f"Bearer {self.token if token is None else token}"}
        data = None
        if body is not None:
            data, headers["Content-Type"] = json.dumps(body).encode(), content
        request = urllib.request.Request(self.address + path, data=data, headers=headers, method=method)
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return answer.status, answer.headers["Content-Type"], answer.read()
        except urllib.error.HTTPError as answer:
            with answer:
                return answer.code, answer.headers["Content-Type"], answer.read()

    def listed(self):
        return json.loads(self.ask("/api/v1/runs")[2])["runs"]

    def check(self, method, path, answer):
        """The answer is one that the document has for the request."""
        status, kind, body = answer
        responses = OPERATIONS[method, path]["responses"]
        self.assertIn(str(status), responses, f"{method} {path}: {body[:300]}")
        content = responses[str(status)].get("content")
        if content is None:
            self.assertEqual(body, b"")
            return None
        (wanted, schema), = content.items()
        self.assertEqual(kind.split(";")[0], wanted)
        if wanted != "application/json":
            return body
        value = json.loads(body)
        jsonschema.Draft202012Validator({**schema["schema"], "components": API["components"]}).validate(value)
        return value

    def test_every_reading_request_is_answered_as_described_for_runs_of_each_lab(self):
        for method, path in OPERATIONS:
            if method != "GET":
                continue
            for run in self.listed() if "{run}" in path else [None]:
                with self.subTest(path=path, run=run and run["label"]):
                    answer = self.ask(at(path, run and run["id"]))
                    self.assertIn(answer[0], (426,) if path.endswith("/events") else (200, 204))
                    self.check(method, path, answer)
        kinds = {run["lab"] for run in self.listed()}
        self.assertGreaterEqual(len(kinds), 2)

    def test_every_member_that_is_described_occurs(self):
        seen = set().union(*(run.keys() for run in self.listed()))
        described = set(API["components"]["schemas"]["Run"]["properties"])
        self.assertEqual(described - seen, {"state"})  # of a live print

    def test_who_has_no_token_is_refused_everywhere_and_an_unknown_run_is_not_there(self):
        run = self.listed()[0]["id"]
        for method, path in OPERATIONS:
            with self.subTest(path=path):
                body = {"token": self.token} if method == "POST" else None
                self.assertEqual(self.ask(at(path, run), method, body, token="wrong")[0], 401)
                self.check(method, path, self.ask(at(path, run), method, body, token="wrong"))
                if "{run}" in path:
                    answer = self.ask(at(path, "no-such-run"), method, body)
                    self.assertEqual(answer[0], 404)
                    self.check(method, path, answer)

    def test_a_resume_is_refused_without_its_token_as_no_json_and_where_there_is_nothing_to_print(self):
        path = "/api/v1/runs/{run}/resume"
        over = next(run["id"] for run in self.listed() if run["label"] == "v1.0-mpc")
        place = at(path, over)
        for body, content, status in (({"token": "wrong"}, "application/json", 403), ({"token": self.token}, "text/plain", 415),
                                      ([1], "application/json", 400), ({"token": self.token}, "application/json", 409)):
            answer = self.ask(place, "POST", body, content=content)
            self.assertEqual(answer[0], status, answer)
            self.check("POST", path, answer)

    def test_an_alarm_is_acknowledged_by_name_once_and_the_record_keeps_who_and_when(self):
        path = "/api/v1/runs/{run}/acknowledge"
        run = next(r for r in self.listed() if r["outcome"] == "stopped safely")
        state = json.loads(self.ask(f"/api/v1/runs/{run['id']}")[2])
        alarms = [e["alarm"] for e in state["events"] if e["alarm"]]
        self.assertTrue(alarms)
        place = at(path, run["id"])
        for body, status in (({"alarm": alarms[0]}, 400), ({"alarm": "0.000 s, jet: nothing", "author": "Kim"}, 409), ({"author": "Kim"}, 400),
                             ({"alarm": alarms[0], "author": "Kim", "token": "wrong"}, 403)):
            answer = self.ask(place, "POST", body)
            self.assertEqual(answer[0], status, answer)
            self.check("POST", path, answer)
        self.assertEqual(self.ask(place, "POST", {"alarm": alarms[0], "author": "Kim"}, content="text/plain")[0], 415)
        for author in ("Kim", "Lee"):
            told = self.check("POST", path, self.ask(place, "POST", {"alarm": alarms[0], "author": author}))
        self.assertEqual([(a["alarm"], a["author"]) for a in told["alarms"]], [(alarms[0], "Kim")])
        folder = next(p for p in self.runs.iterdir() if p.name == run["label"])
        lines = [json.loads(line) for line in (folder / "notes.jsonl").read_text().splitlines()]
        self.assertEqual([(e["kind"], e["text"], e["author"]) for e in lines], [("ack", alarms[0], "Kim")])
        self.assertIn("Kim acknowledged: " + alarms[0], subprocess.run([FIRN, "runs", "note", folder], capture_output=True, text=True).stdout)

    def test_a_map_has_the_numbers_of_the_log(self):
        run = next(r for r in self.listed() if r["label"] == "v1.0-mpc")
        data = self.ask(f"/api/v1/runs/{run['id']}/layers/2/measured")[2]
        magic, version, surface, layer, nx, ny, flags, t_s = struct.unpack_from("<4sHHIIIId", data)
        self.assertEqual((magic, version, surface, layer, flags), (b"FMAP", 1, 0, 2, 0))
        values = struct.unpack_from(f"<{nx * ny}f", data, 32)
        log = subprocess.run([FIRN, "log", "cat", GOLDEN / "v1.0-mpc/log.lcm", "--full", "--channel", "HEIGHT_MAP"], capture_output=True,
                             text=True, check=True).stdout
        maps = [json.loads(line)["message"] for line in log.splitlines()]
        wanted = [m for m in maps if m["layer"] == 2][-1]
        self.assertEqual((nx, ny), (wanted["grid"]["nx"], wanted["grid"]["ny"]))
        for told, mm in zip(values, wanted["height_mm"]):
            self.assertAlmostEqual(told, 1e3 * mm, delta=1e-3)

    def test_the_table_of_the_program_and_the_document_have_the_same_requests(self):
        table = re.findall(r'ApiRoute\{"(\w+)", "([^"]+)"\}', (ROOT / "page/api_v1.h").read_text(encoding="utf-8"))
        self.assertEqual(sorted(table), sorted(key for key in OPERATIONS if key[1].startswith("/api/")))

    def test_what_is_not_described_is_not_answered_though_the_page_has_it(self):
        run = self.listed()[0]["id"]
        for path in ("/api/v1", "/api/v1/", "/api/v1/nothing", f"/api/v1/runs/{run}/report", f"/api/v1/runs/{run}/layers/1/nothing", f"/api/v1/runs/{run}/layers/1", "/api/v2/runs"):
            self.assertEqual(self.ask(path)[0], 404, path)
        self.assertEqual(self.ask(f"/api/v1/runs/{run}/audit", "POST", {})[0], 404)
        self.assertEqual(json.loads(self.ask("/api/runs")[2]), json.loads(self.ask("/api/v1/runs")[2]))

    def test_metrics_are_in_prometheus_s_format_and_count_the_runs(self):
        status, kind, body = self.ask("/metrics")
        self.assertEqual((status, kind), (200, "text/plain; version=0.0.4; charset=utf-8"))
        told, outcomes = set(), {}
        for line in body.decode().splitlines():
            if line.startswith("# "):
                told.add(tuple(line.split()[1:3]))
                continue
            name, labels, value = SAMPLE.fullmatch(line).groups()
            self.assertLessEqual({("HELP", name), ("TYPE", name)}, told)
            if name == "firn_runs":
                outcomes[re.fullmatch(r'outcome="(.*)"', labels)[1]] = float(value)
        wanted = {}
        for run in self.listed():
            wanted[run["outcome"]] = wanted.get(run["outcome"], 0) + 1
        self.assertEqual(outcomes, wanted)
        self.assertGreaterEqual(len(wanted), 2)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
