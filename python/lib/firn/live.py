"""A print while it goes on, and runs of another computer: through the page of `firn print --page` or `firn view`."""
import http.client
import json
import struct
import threading
import time
import urllib.parse

import numpy as np

from .program import FirnError
from .web_socket import WebSocket

_ANSWER_S = 15.0
_MAP_HEAD = struct.Struct("<4sHHIIIId")  # docs/api.md
_ROWS = 8  # flag: some rows alone
_DROPLETS, _FACTOR = 1, 4
_SURFACES = ("measured", "target", "error", "planned", "predicted", "truth")


def connect(url, *, token=None, run="live", timeout_s=10.0):
    """Opens a run through a page, as its terminal shows the page's address: "http://127.0.0.1:8750/#token=...".

    url: address of the page; behind '#' it may have token=... and run=...
    token: of the page or of a person (`firn people`); default: that of the address
    run: address of a run, as LivePrint.runs() and `firn runs --json` have it; "live": the print that the page is part of
    Returns a LivePrint, to be closed, or used in a `with` statement. Raises FirnError with the page's own words.
    """
    return LivePrint(url, token, run, timeout_s)


class LivePrint:
    """A run as it is now: rows of its layers and events, its maps, and orders to it.

    A thread receives what the page tells; every attribute may be read at any time from any thread. Times are in s of the print's
    clock, heights of maps in mm, errors of layers in um, as their names say.
    """

    def __init__(self, url, token, run, timeout_s):
        parts = urllib.parse.urlsplit(url if "//" in url else "//" + url, scheme="http")
        words = dict(urllib.parse.parse_qsl(parts.fragment))
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise FirnError(f"{url}: no address of a page, such as http://127.0.0.1:8750/#token=...")
        self._secure, self._host = parts.scheme == "https", parts.hostname
        self._port = parts.port or (443 if self._secure else 80)
        self._base, self._timeout_s = parts.path.rstrip("/"), timeout_s
        self._token = token or words.get("token", "")
        if run == "live":
            run = words.get("run", run)
        self._changed, self._answers, self._next_id = threading.Condition(), {}, 0
        self._hello, self._state, self._end, self._closed = None, None, None, False
        self._layers, self._events, self._acknowledged, self._trouble = {}, {}, [], None
        path = f"{self._base}/api/v1/runs/{urllib.parse.quote(run, safe='')}/events"
        try:
            self._socket = WebSocket(self._host, self._port, path, self._headers(), self._secure, timeout_s)
        except OSError as error:
            raise FirnError(f"{url}: {error}") from error
        self._thread = threading.Thread(target=self._receive, name="firn.connect", daemon=True)
        self._thread.start()
        if not self._wait(lambda: self._hello is not None, timeout_s):
            self.close()
            raise FirnError(self._trouble or f"{url}: the page has told nothing of {run} within {timeout_s:g} s")

    def _headers(self):
        return {"Authorization": f"Bearer {self._token}"} if self._token else {}

    # What the page tells.
    def _receive(self):
        while (message := self._socket.receive()) is not None:
            if isinstance(message, str):
                with self._changed:
                    self._take(json.loads(message))
                    self._changed.notify_all()
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _take(self, told):
        kind = told.get("type")
        if kind == "hello":
            self._hello, self._state, self._end = told, told["state"], told["end"]
            self._layers = {row["n"]: row for row in told["layers"]}
            self._events = {row["n"]: row for row in told["events"]}
            self._acknowledged = told["run"].get("acknowledged", [])
        elif kind == "state":
            self._state = told
        elif kind == "layer":
            self._layers[told["n"]] = told
        elif kind == "event":
            self._events[told["n"]] = told
        elif kind == "acknowledged":
            self._acknowledged = told["alarms"]
        elif kind == "end":
            self._end = told
        elif kind == "setting":
            for row in self._hello["run"]["settings"]:
                if row["key"] == told["key"]:
                    row["value"] = told["value"]
        elif kind == "answer" and told.get("id") is not None:
            self._answers[told["id"]] = told
        elif kind == "error":
            self._trouble = told["error"]

    def _wait(self, holds, timeout_s):
        """Until `holds()`; False after timeout_s, or when the connection has ended without it."""
        end = None if timeout_s is None else time.monotonic() + timeout_s
        with self._changed:
            while not holds():
                left = None if end is None else end - time.monotonic()
                if self._closed or (left is not None and left <= 0):
                    return False
                self._changed.wait(left)
            return True

    @property
    def name(self):
        """Name of the run folder, for people."""
        return self._hello["run"]["label"]

    @property
    def address(self):
        """Address of the run: its number and its place."""
        return self._hello["run"]["id"]

    @property
    def about(self):
        """What the page says of the run once: lab, scheme, seed, grid, goal, meta, host, settings; a dict."""
        return self._hello["run"]

    @property
    def is_live(self):
        """Does the print go on?"""
        return self._hello["run"]["live"] and self._end is None and not self._closed

    @property
    def state(self):
        """Where the print stands: state, words, layer, layers, eta_s, paused, temperatures; a dict."""
        return self._state

    @property
    def end(self):
        """Outcome, cause, verdict; a dict, or None while the print goes on."""
        return self._end

    @property
    def layers(self):
        """Figures of each measured layer, oldest first: n, t_s, rms_um, mean_um, droplets and others; dicts."""
        with self._changed:
            return [self._layers[n] for n in sorted(self._layers)]

    def column(self, name):
        """A figure of all layers as an array, NaN where it is not known: column("rms_um")."""
        rows = self.layers
        if rows and name not in rows[0]:
            raise KeyError(f"a layer has no {name}; it has {', '.join(k for k in rows[0] if k != 'type')}")
        return np.array([np.nan if row[name] is None else row[name] for row in rows], float)

    @property
    def events(self):
        """What happened, oldest first: n, t_s, severity, source, words, cause, alarm and others; dicts."""
        with self._changed:
            return [self._events[n] for n in sorted(self._events)]

    @property
    def settings(self):
        """Each key of the experiment with its value, as TOML writes it."""
        return {row["key"]: row["value"] for row in self._hello["run"]["settings"]}

    @property
    def alarms(self):
        """Warnings, faults and stops, oldest first: the event's dict with `acknowledged`: who and when, or None."""
        by = {one["alarm"]: one for one in self._acknowledged}
        return [event | {"acknowledged": by.get(event["alarm"])} for event in self.events if event.get("alarm")]

    def follow(self):
        """Yields each new layer and event as it comes, with "type"; ends when the print does or the connection."""
        seen_layers, seen_events = set(self._layers), set(self._events)
        while True:
            with self._changed:
                layers = [row | {"type": "layer"} for n, row in sorted(self._layers.items()) if n not in seen_layers]
                events = [row | {"type": "event"} for n, row in sorted(self._events.items()) if n not in seen_events]
                if not layers and not events:
                    if not self.is_live:
                        return
                    self._changed.wait(1.0)
                    continue
            seen_layers.update(row["n"] for row in layers)
            seen_events.update(row["n"] for row in events)
            yield from sorted(layers + events, key=lambda row: row["t_s"])

    def wait_layer(self, n, timeout_s=None):
        """Waits until layer n is measured. True: it is; False: the print has ended before, or timeout_s is over."""
        self._wait(lambda: any(k >= n for k in self._layers) or not self.is_live, timeout_s)
        return any(k >= n for k in self._layers)

    def wait_end(self, timeout_s=None):
        """Waits for the end of the print. Returns `end`, or None after timeout_s."""
        self._wait(lambda: self._end is not None, timeout_s)
        return self._end

    # What is asked of the page.
    def _ask(self, path, method="GET", body=None):
        kind = http.client.HTTPSConnection if self._secure else http.client.HTTPConnection
        line = kind(self._host, self._port, timeout=max(60.0, self._timeout_s))
        try:
            headers = self._headers() | ({"Content-Type": "application/json"} if body is not None else {})
            line.request(method, self._base + path, body=None if body is None else json.dumps(body), headers=headers)
            answer = line.getresponse()
            data = answer.read()
        except OSError as error:
            raise FirnError(f"{self._host}:{self._port}: {error}") from error
        finally:
            line.close()
        if answer.status >= 400:
            try:
                why = json.loads(data)["error"]
            except (ValueError, KeyError, TypeError):
                why = data[:200].decode("utf-8", "replace")
            raise FirnError(f"{answer.status} {answer.reason}: {why}")
        return data

    def _of_run(self, path):
        return f"/api/v1/runs/{urllib.parse.quote(self.address, safe='')}/{path}"

    def runs(self):
        """All runs that the page lists, newest first; dicts with `id`, label, outcome, rms_um, meta and others."""
        return json.loads(self._ask("/api/v1/runs"))["runs"]

    def map(self, surface="measured", layer=None):
        """A map on the grid as an array (ny, nx), row j along x, NaN where nothing is known; None: there is none.

        surface: "measured", "target", "error", "planned", "predicted" or "truth" (of simulated prints)
        layer: number of layers deposited; default: the last one that was measured
        Heights and errors are in mm, planned droplets in droplets.
        """
        if surface not in _SURFACES:
            raise FirnError(f"surface {surface!r}: is one of {', '.join(_SURFACES)}")
        layer = max(self._layers, default=0) if layer is None else int(layer)
        data = self._ask(self._of_run(f"layers/{layer}/{surface}"))
        if not data:
            return None
        magic, version, _, _, nx, ny, flags, _ = _MAP_HEAD.unpack_from(data)
        if magic != b"FMAP" or version != 1 or flags & _ROWS or len(data) != _MAP_HEAD.size + 4 * nx * ny:
            raise FirnError(f"the page sent a map that this version does not know: {magic!r} {version}")
        values = np.frombuffer(data, "<f4", offset=_MAP_HEAD.size).reshape(ny, nx).astype(float)
        return values if flags & (_DROPLETS | _FACTOR) else values * 1e-3

    @property
    def grid(self):
        """Positions of the cells' centres in mm, (x, y); None before the first map."""
        told = self._hello["run"]["grid"]
        if told is None:
            told = json.loads(self._ask(f"/api/v1/runs/{urllib.parse.quote(self.address, safe='')}"))["run"]["grid"]
            self._hello["run"]["grid"] = told
        if told is None:
            return None
        return (told["x0_mm"] + told["pitch_mm"] * np.arange(told["nx"]), told["y0_mm"] + told["pitch_y_mm"] * np.arange(told["ny"]))

    # Orders.
    def _order(self, command, **more):
        with self._changed:
            self._next_id += 1
            number = self._next_id
        frame = {"type": "command", "id": number, "command": command, **more}
        try:
            self._socket.send(json.dumps(frame))
        except OSError as error:
            raise FirnError(f"{command}: the connection has ended: {error}") from error
        if not self._wait(lambda: number in self._answers, _ANSWER_S):
            raise FirnError(f"{command}: no answer within {_ANSWER_S:g} s: it may not have been obeyed")
        answer = self._answers.pop(number)
        if not answer["ok"]:
            raise FirnError(f"{command}: {answer['error']}")
        return answer["words"]

    def pause(self):
        """Lets the print wait before its next pass, path or scan, where nothing is armed or wet."""
        return self._order("pause")

    def go_on(self):
        """Ends a pause."""
        return self._order("continue")

    def set(self, key, value):
        """Changes a key that may change between layers, from the next decision on."""
        text = str(value).lower() if isinstance(value, bool) else value if isinstance(value, str) else repr(value)
        return self._order("set", key=key, value=text)

    def finish_layer(self):
        """Ends the print after this layer."""
        return self._order("stop_after_layer")

    def stop(self):
        """Makes the lab safe at once and ends the print, which can be resumed. No substitute for an emergency stop."""
        return self._order("safe_stop")

    def accept_doubt(self):
        """Goes on in spite of droplets in doubt."""
        return self._order("accept_doubt")

    def acknowledge(self, alarm, author=""):
        """Records that somebody has seen an alarm of `alarms`: author, unless the token is a person's own."""
        name = alarm if isinstance(alarm, str) else alarm["alarm"]
        self._acknowledged = json.loads(self._ask(self._of_run("acknowledge"), "POST", {"alarm": name, "author": author}))["alarms"]

    def close(self):
        """Ends the connection; the print goes on."""
        self._socket.close()
        if threading.current_thread() is not self._thread:
            self._thread.join(5.0)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __repr__(self):
        return f"<firn.LivePrint {self.name}: {'live' if self.is_live else 'over'}, {len(self._layers)} layers>"
