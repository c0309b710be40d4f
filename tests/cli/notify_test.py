#!/usr/bin/env python3
"""The command that is told of a print's end, with a mail server and a web server played here: tests/cli/notify_test.py FIRN ROOT"""
import email
import http.server
import json
import os
import signal
import socketserver
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

FIRN, ROOT = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
SMALL = [ROOT / "experiments/cuboid.toml", "--bus", "in-process", "--set", "part.height_mm=0.02"]
PATIENCE_S = 60
MEMBERS = ["version", "event", "text", "run", "host", "outcome", "reason", "status", "layers", "rms_um", "tolerance_um"]


class MailServer(socketserver.StreamRequestHandler):
    """Takes a mail as RFC 5321 says, without extensions."""
    mails = []

    def handle(self):
        envelope = []
        self.wfile.write(b"220 here\r\n")
        for line in self.rfile:
            word = line.split(b":")[0].strip().upper()
            if word.startswith((b"EHLO", b"HELO")):
                self.wfile.write(b"250 here\r\n")
            elif word == b"DATA":
                self.wfile.write(b"354 go on\r\n")
                lines = []
                while (text := self.rfile.readline()) != b".\r\n":
                    lines.append(text[1:] if text.startswith(b"..") else text)
                self.mails.append((envelope, email.message_from_bytes(b"".join(lines))))
                self.wfile.write(b"250 taken\r\n")
            elif word == b"QUIT":
                self.wfile.write(b"221 bye\r\n")
                return
            else:
                envelope.append(line.decode().strip())
                self.wfile.write(b"250 ok\r\n")


class WebServer(http.server.BaseHTTPRequestHandler):
    posts = []

    def do_POST(self):
        self.posts.append((self.path, self.headers["Content-Type"], json.loads(self.rfile.read(int(self.headers["Content-Length"])))))
        self.send_response(204)
        self.end_headers()

    def log_message(self, *_):
        pass


def wait_for(what):
    end = time.monotonic() + PATIENCE_S
    while not (found := what()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)
    return found


class Notify(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.place = Path(scratch.name)
        self.told = self.place / "told"
        self.environment = {**os.environ, "XDG_CONFIG_HOME": str(self.place / "config")}

    def serve(self, handler):
        server = socketserver.ThreadingTCPServer(("127.0.0.1", 0), handler)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        return server.server_address[1]

    def command(self, text):
        file = self.place / "config/firn/config.toml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"[notify]\ncommand = {json.dumps(text)}\n", encoding="utf-8")

    def say(self, *words):
        return subprocess.run([str(w) for w in (FIRN, *words)], cwd=self.place, env=self.environment, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, timeout=300, check=False)

    def event(self):
        """The newest event of a command that appends its lines to a file whole."""
        line = wait_for(lambda: self.told.is_file() and self.told.read_text(encoding="utf-8"))
        self.told.unlink()
        self.assertEqual(line.count("\n"), 1)
        event = json.loads(line)
        self.assertEqual(list(event), MEMBERS)
        return event

    def test_each_end_of_a_print_is_told_by_its_name_with_run_reason_and_figures(self):
        self.command(f"cat > {self.told}.part && mv {self.told}.part {self.told}")
        for words, name, code in ((SMALL, "finished", 0), ([*SMALL, "--tolerance", "0.1"], "out of tolerance", 4),
                                  ([*SMALL[:3], "--fault", "10 jet close"], "stopped", 3),
                                  ([*SMALL[:3], "--set", "control.max_layers=3"], "needs a person", 3)):
            with self.subTest(name):
                done = self.say("print", *words)
                self.assertEqual(done.returncode, code, done.stderr)
                event = self.event()
                self.assertEqual((event["version"], event["event"], event["status"]), (1, name, code))
                run = Path(event["run"])
                result = json.loads((run / "result.json").read_text(encoding="utf-8"))
                for member in ("outcome", "reason", "layers"):
                    self.assertEqual(event[member], result[member])
                self.assertIn(f"{run.name} on {event['host']}: {name}", event["text"])
                self.assertEqual("jet" in event["text"], name == "stopped")
                if name in ("finished", "out of tolerance"):
                    self.assertEqual(event["rms_um"] > event["tolerance_um"], name == "out of tolerance")

    def test_an_interrupted_print_and_a_resumed_one_tell_their_ends(self):
        self.command(f"cat > {self.told}.part && mv {self.told}.part {self.told}")
        print_ = subprocess.Popen([FIRN, "print", ROOT / "experiments/cylinder.toml", "--bus", "in-process"], cwd=self.place,
                                  env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_for(lambda: list(self.place.glob("runs/*/nodes/controller.wal")))
        print_.send_signal(signal.SIGINT)
        self.assertEqual(print_.wait(timeout=PATIENCE_S), 130)
        event = self.event()
        self.assertEqual((event["event"], event["status"]), ("stopped", 130))
        self.assertIn(self.say("print", "--resume", event["run"], "--bus", "in-process").returncode, (0, 4))
        self.assertIn(self.event()["event"], ("finished", "out of tolerance"))

    def test_nobody_waits_for_the_command_and_one_that_fails_changes_nothing(self):
        self.command(f"echo $$ > {self.told}; exec sleep 3600")
        done = self.say("print", *SMALL)
        pid = int(wait_for(lambda: self.told.is_file() and self.told.read_text()))
        self.addCleanup(os.kill, pid, signal.SIGKILL)
        self.assertEqual(done.returncode, 0)
        self.assertEqual(Path(f"/proc/{pid}/comm").read_text(), "sleep\n")
        self.assertNotEqual(os.getsid(pid), os.getsid(0))
        self.command("no-such-program-here; exit 7")
        done = self.say("print", *SMALL)
        self.assertEqual(done.returncode, 0)
        self.assertNotIn("no-such-program", done.stderr)

    def test_the_command_can_be_tried_and_its_output_and_exit_code_are_shown(self):
        self.command("cat; exit 7")
        done = self.say("config", "notify")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(json.loads(done.stdout)["event"], "test")
        self.assertIn("exit code 7", done.stderr)
        self.command("true")
        self.assertEqual(self.say("config", "notify").returncode, 0)
        (self.place / "config/firn/config.toml").unlink()
        done = self.say("config", "notify")
        self.assertEqual(done.returncode, 2)
        self.assertIn("names no notify.command", done.stderr)

    def test_a_mail_comes_to_all_receivers_with_the_sentence_as_its_subject(self):
        port = self.serve(MailServer)
        self.command(f"{sys.executable} -B {ROOT}/labs/notify/mail.py 127.0.0.1:{port} firn@lab.example a@lab.example b@lab.example")
        self.assertEqual(self.say("print", *SMALL[:3], "--fault", "10 jet close").returncode, 3)
        envelope, mail = wait_for(lambda: list(MailServer.mails))[0]
        self.assertIn("from:<firn@lab.example>", envelope[0].lower())
        self.assertEqual([line.lower().split("to:")[1] for line in envelope[1:]], ["<a@lab.example>", "<b@lab.example>"])
        self.assertIn("stopped", str(email.header.make_header(email.header.decode_header(mail["Subject"]))))
        self.assertIn("outcome: stopped safely", mail.get_payload(decode=True).decode())

    def test_a_web_hook_gets_the_event_or_the_sentence_under_the_name_that_a_chat_wants(self):
        port = self.serve(WebServer)
        for words in ("", " text"):
            self.command(f"{sys.executable} -B {ROOT}/labs/notify/webhook.py http://127.0.0.1:{port}/hook{words}")
            self.assertEqual(self.say("print", *SMALL).returncode, 0)
        posts = wait_for(lambda: len(WebServer.posts) == 2 and sorted(WebServer.posts, key=lambda post: len(post[2])))
        self.assertEqual([(path, kind) for path, kind, _ in posts], [("/hook", "application/json")] * 2)
        self.assertEqual(list(posts[0][2]), ["text"])
        self.assertEqual(list(posts[1][2]), MEMBERS)
        self.assertIn("finished", posts[0][2]["text"])

    def test_no_experiment_and_no_lab_can_name_a_command(self):
        done = self.say("print", *SMALL, "--set", f"notify.command=touch {self.told}")
        self.assertEqual(done.returncode, 2)
        self.assertFalse(self.told.exists())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
