"""The instruments of tests/examples/fake_lab.py, and the surface that they build and measure.

Each takes the bytes of its host and returns its reply: take(data, now), with now in s. closed(now): the host has gone.
"""
import collections
import math
import struct


class Surface:
    """The deposited heights [mm], in square cells of CELL mm by their numbers; a droplet is a bell of ink."""

    CELL, REACH, WIDTH_MM = 0.066, 5, 0.115
    DROPLET_MM3, SCATTER, GAUGE_MM = 5.0e-4, 0.03, 0.5

    def __init__(self, rng):
        self.rng = rng
        self.change("bare")

    def change(self, to):
        """bare: a new substrate lies there; gauge: with a gauge block under the third of the line of smaller x."""
        if to not in ("bare", "gauge"):
            raise ValueError(f"'{to}' is none of bare, gauge")
        self.rows = collections.defaultdict(lambda: collections.defaultdict(float))  # [j][i]
        self.block_mm = self.GAUGE_MM if to == "gauge" else 0.0

    def land(self, x_mm, y_mm):
        def bell(at_mm):
            middle = round(at_mm / self.CELL)
            near = range(middle - self.REACH, middle + self.REACH + 1)
            return [(n, math.exp(-0.5 * ((n * self.CELL - at_mm) / self.WIDTH_MM) ** 2)) for n in near]

        across, along = bell(x_mm), bell(y_mm)
        volume = self.DROPLET_MM3 * self.rng.gauss(1.0, self.SCATTER)
        peak = volume / self.CELL**2 / sum(w for _, w in across) / sum(w for _, w in along)
        for j, weight in along:
            row = self.rows[j]
            for i, w in across:
                row[i] += peak * weight * w

    def line(self, first_mm, step_mm, points, y_mm):
        row = self.rows.get(round(y_mm / self.CELL), {})
        return [row.get(round((first_mm + n * step_mm) / self.CELL), 0.0) + (self.block_mm if 3 * n < points else 0.0)
                for n in range(points)]


class Move:
    """A straight move from rest to rest with constant acceleration."""

    def __init__(self, start, end, speed, acceleration, now):
        self.start, self.begun, self.acceleration, self.length = start, now, acceleration, math.dist(start, end)
        self.direction = [(b - a) / self.length if self.length else 0.0 for a, b in zip(start, end)]
        self.peak = min(speed, math.sqrt(self.length * acceleration))
        self.ramp = self.peak / acceleration
        self.lasts = 2 * self.ramp + (self.length / self.peak - self.ramp if self.length else 0.0)

    def travelled(self, now):
        t, left = now - self.begun, self.lasts - (now - self.begun)
        if left <= 0.0:
            return self.length
        if t < self.ramp:
            return 0.5 * self.acceleration * t * t
        return self.peak * (t - 0.5 * self.ramp) - 0.5 * self.acceleration * max(0.0, self.ramp - left) ** 2

    def at(self, mm):
        return [a + d * mm for a, d in zip(self.start, self.direction)]


class PulseOutput:
    """Position-synchronised output of one axis: a pulse after each increment of its way since ARM [counts]."""

    def __init__(self):
        self.armed, self.increments, self.fixed, self.array = False, [], None, False
        self.pulses = self.next = 0
        self.travel_mm = 0.0  # since ARM, up to the start of the move

    def ahead(self):
        """The increment to the next pulse; None: there is none."""
        if not self.armed:
            return None
        if not self.array:
            return self.fixed
        return self.increments[self.pulses] if self.pulses < len(self.increments) else None


class Stage:
    """Aerotech Ensemble: docs/devices/stage.md. Its moves are computed when somebody asks."""

    COUNTS_PER_MM, HOME_MM_S, INTEGERS = 10000.0, 20.0, 4096
    LOW, HIGH = (-50.0, -50.0, -10.0), (150.0, 150.0, 50.0)

    def __init__(self, jet, profiler):
        self.jet, self.profiler = jet, profiler
        self.place, self.move, self.homing = [3.0, 2.0, 1.0], None, None
        self.enabled, self.homed = [False] * 3, [False] * 3
        self.absolute, self.ramp = False, 1000.0
        self.integers, self.heard = {}, b""
        self.outputs = [PulseOutput() for _ in range(3)]

    def advance(self, now):
        """Puts out the pulses that are due, and ends the move."""
        if not self.move:
            return
        mm = self.move.travelled(now)
        for axis, out in enumerate(self.outputs):
            share = abs(self.move.direction[axis])
            while share > 1e-9 and (counts := out.ahead()) is not None:
                at_mm = ((out.next + counts) / self.COUNTS_PER_MM - out.travel_mm) / share
                if at_mm > mm + 1e-7:  # a tenth of a nanometre is rounding
                    break
                out.next += counts
                out.pulses += 1
                place = self.move.at(at_mm)
                if axis == 0:
                    self.jet.trigger(place)
                if axis == 1:
                    self.profiler.trigger(place, round(place[1] * self.COUNTS_PER_MM))
        if now >= self.move.begun + self.move.lasts:
            self.rest_at(mm)
            if self.homing is not None:
                self.homed[self.homing], self.homing = True, None

    def rest_at(self, mm):
        for axis, out in enumerate(self.outputs):
            out.travel_mm += abs(self.move.direction[axis]) * mm
        self.place, self.move = self.move.at(mm), None

    def go(self, target, speed, now):
        self.move = Move(self.place, target, speed, self.ramp, now)

    def abort(self, now):
        """It stops where it is: its brakes are good."""
        if self.move:
            self.rest_at(self.move.travelled(now))
            self.homing = None

    def closed(self, now):
        """The link is gone: it stops by itself."""
        self.heard = b""
        for out in self.outputs:
            out.armed = False
        self.abort(now)

    def take(self, data, now):
        *lines, self.heard = (self.heard + data).split(b"\n")
        return b"".join(self.answer(line.decode("latin-1"), now).encode() + b"\n" for line in lines)

    def answer(self, line, now):
        for sign in "(),=":
            line = line.replace(sign, " ")
        try:
            return self.obey(line.split(), now)
        except (ValueError, LookupError, TypeError, ArithmeticError, StopIteration):
            return "!"  # not understood

    def obey(self, words, now):
        verb, axis = words[0], None
        if len(words) > 1 and words[1][0] == "@":
            axis = int(words[1][1:])
        if verb == "LINEAR":
            return self.linear(words[1:], now)
        if verb == "IGLOBAL":
            number = int(words[1])
            if len(words) == 2:
                return f"%{self.integers.get(number, 0)}"
            self.integers[number] = int(words[2])
        elif verb.startswith("PSO"):
            return self.pulse_output(verb[3:], self.outputs[axis], words[2:], axis, now)
        elif verb == "AXISSTATUS":
            moves = bool(self.move and self.move.direction[axis])
            homes = self.homing == axis
            bits = (self.enabled[axis], self.homed[axis], not moves, moves)
            return f"%{sum(bit << n for n, bit in enumerate(bits)) | homes << 14}"
        elif verb == "AXISFAULT":
            return "%0"
        elif verb == "VERSION":
            return "%4.07.001"
        elif verb == "PFBKPROG":
            return f"%{(self.move.at(self.move.travelled(now)) if self.move else self.place)[axis]:.6f}"
        elif verb == "PLANESTATUS":
            return f"%{int(self.move is not None)}"
        elif verb == "TASKSTATE":
            return f"%{3 if self.homing is not None else 1}"
        elif verb == "GETPARM":
            held = {2: self.COUNTS_PER_MM, 37: self.LOW[axis], 38: self.HIGH[axis], 124: self.INTEGERS, 210: 1}
            return f"%{held[int(words[2])]}"
        elif verb == "ENABLE":
            self.enabled[axis] = True
        elif verb == "ABORT":
            self.abort(now)
        elif verb in ("ABS", "INC"):
            self.absolute = verb == "ABS"
        elif words[:2] == ["RAMP", "RATE"]:
            self.ramp = float(words[2])
        elif words[:2] == ["PROGRAM", "RUN"] and words[-1] == '"HomeAsync.bcx"':
            self.homing = self.integers[33]
            self.homed[self.homing] = False
            self.go([0.0 if a == self.homing else p for a, p in enumerate(self.place)], self.HOME_MM_S, now)
        elif verb not in ("WAIT", "FAULTACK", "SCURVE", "RAMP", "PROGRAM", "DISABLE"):
            return "!"
        return "%"

    def linear(self, words, now):
        speed = next(float(word[1:]) for word in words if word[0] == "F")
        target = list(self.place)
        axes = {int(axis[1:]): float(value) for axis, value in zip(words, words[1:]) if axis[0] == "@"}
        for axis, mm in axes.items():
            target[axis] = mm + (0.0 if self.absolute else self.place[axis])
        inside = all(low <= mm <= high for low, mm, high in zip(self.LOW, target, self.HIGH))
        if self.move or not inside or not all(self.enabled[axis] for axis in axes):
            return "#"  # it cannot
        self.go(target, speed, now)
        return "%"

    def pulse_output(self, verb, out, words, axis, now):
        if verb == "COUNT":
            return f"%{out.pulses}"
        if verb == "ARRAY":
            first, count = int(words[0]), int(words[1])
            out.increments = [self.integers[first + n] for n in range(count)]
        elif verb == "DISTANCE":
            out.array = words[0] == "ARRAY"
            out.fixed = None if out.array else round(float(words[1]) * self.COUNTS_PER_MM)
        elif verb == "CONTROL" and words[0] == "ARM":
            out.armed, out.pulses, out.next, out.travel_mm = True, 0, 0, 0.0
            if self.move:
                out.travel_mm = -abs(self.move.direction[axis]) * self.move.travelled(now)
        elif verb == "CONTROL" and words[0] == "OFF":
            out.armed = False
        elif verb == "CONTROL" and words[0] == "RESET":
            self.outputs[axis] = PulseOutput()
        elif verb not in ("OUTPUT", "PULSE", "TRACK"):
            return "!"
        return "%"


class Jet:
    """MicroFab JetDrive III: docs/devices/jet.md. A letter Q and X2000 start its firmware, then it takes frames."""

    DATA_BYTES = {0x01: 0, 0x02: 0, 0x03: 2, 0x04: 1, 0x06: 19, 0x07: 1, 0x08: 1, 0x09: 0, 0x10: 1, 0x12: 2, 0x13: 3,
                  0xF0: 0}
    VERSION = 128  # from here on POLL tells the trigger source

    def __init__(self, surface):
        self.surface, self.heard, self.greeting = surface, b"", b""
        self.runs = self.external = self.waveform = False
        self.droplets = 1  # of one trigger

    def trigger(self, place):
        if self.external and self.waveform:
            for _ in range(self.droplets):
                self.surface.land(place[0], place[1])

    def closed(self, now):
        self.heard = self.greeting = b""  # it stays as it was set

    def take(self, data, now):
        said = b""
        for byte in data:
            said += self.letter(bytes([byte]))
        return said

    def letter(self, byte):
        if not self.heard and not (self.runs and byte == b"S"):
            if byte == b"Q":
                self.greeting = b""
                return b">"
            self.greeting += byte
            if not b"X2000".startswith(self.greeting):
                self.greeting = b""
                return b""
            self.runs = self.runs or self.greeting == b"X2000"
            return byte
        self.heard += byte
        if len(self.heard) == 2 and self.heard[1] < 2:
            self.heard = b""  # no frame is so short
        if len(self.heard) < 2 or len(self.heard) < self.heard[1] + 2:
            return b""
        frame, self.heard, self.greeting = self.heard, b"", b""
        return self.obey(frame[2], frame[3:-1], sum(frame[1:-1]) & 255 == frame[-1])

    def obey(self, command, data, sound):
        if not sound or self.DATA_BYTES.get(command) != len(data):
            return bytes([0x15, command, 1, command + 1 & 255])
        status = 0
        if command == 0x01:
            self.external = self.waveform = False
        elif command == 0x02:
            status = self.external << 2
        elif command == 0x03:
            self.droplets = int.from_bytes(data, "big")
        elif command == 0x06:
            self.waveform = True
        elif command == 0x08:
            self.external = data[0] == 1
        elif command == 0xF0:
            return bytes([0x06, command, 0, self.VERSION, command + self.VERSION & 255])
        return bytes([0x06, command, status, command + status & 255])


class Profiler:
    """Keyence LJ-V7000: docs/devices/laser_profiler.md. Its head hangs over the nozzle, and its line lies along x."""

    POINTS, STEP_MM, NOISE_MM, UNIT_MM, MEMORY = 800, 0.02, 0.001, 1e-4, 4096
    LEAST, MOST = 20, 4096  # bytes of a request

    def __init__(self, surface, rng):
        self.surface, self.rng, self.heard, self.program = surface, rng, b"", 0
        self.triggers, self.profiles = 0, collections.deque(maxlen=self.MEMORY)  # (number, encoder, points)

    def trigger(self, place, encoder):
        self.triggers += 1
        first_mm = place[0] - 0.5 * (self.POINTS - 1) * self.STEP_MM
        heights = self.surface.line(first_mm, self.STEP_MM, self.POINTS, place[1])
        self.profiles.append((self.triggers, encoder, self.packed(heights)))

    def closed(self, now):
        self.heard = b""

    def take(self, data, now):
        self.heard += data
        said = b""
        while len(self.heard) >= 4:
            size = 4 + struct.unpack_from("<I", self.heard)[0]
            if not self.LEAST <= size <= self.MOST:
                self.heard = b""  # another protocol: no frame begins here
            if len(self.heard) < size:
                break
            said += self.answer(self.heard[:size])
            self.heard = self.heard[size:]
        return said

    def answer(self, request):
        command, error, body = request[16], 0, b""
        if command == 0x39 and len(request) == 24:
            self.program = request[20]
        elif command == 0x42 and len(request) == 36:
            body = self.read(*struct.unpack_from("<xBxxIBB", request, 24))
        elif command == 0x04:
            body = bytes(4)  # no error
        else:
            error = 1
        head = struct.pack("<IIIIBB6xI", 24 + len(body), 0x00F00001, 0, 12 + len(body), command, error, self.program)
        return head + body

    def read(self, position, number, most, erase):
        held = list(self.profiles)
        oldest = held[0][0] if held else self.triggers
        if position == 0:
            chosen = held[-1:]
        else:
            chosen = [p for p in held if position == 1 or p[0] >= number][:most]
        first = chosen[0][0] if chosen else self.triggers
        body = struct.pack("<IIIB7xI", self.triggers, oldest, first, len(chosen), bool(chosen))
        if not chosen:
            return body
        first_mm = -0.5 * (self.POINTS - 1) * self.STEP_MM
        body += struct.pack("<HHii", self.POINTS, round(self.UNIT_MM * 1e5), round(first_mm * 1e5),
                            round(self.STEP_MM * 1e5))
        for trigger, encoder, points in chosen:
            body += struct.pack("<4xIi12x", trigger, encoder) + points + bytes(-len(points) % 4 + 4)
        while erase and self.profiles and self.profiles[0][0] < chosen[-1][0]:
            self.profiles.popleft()
        return body

    def packed(self, heights):
        """Points of 20 bits, the lowest bit first: two of them in five bytes."""
        units = [round((z + self.rng.gauss(0.0, self.NOISE_MM)) / self.UNIT_MM) & 0xFFFFF for z in heights]
        return b"".join((a | b << 20).to_bytes(5, "little") for a, b in zip(units[::2], units[1::2]))


class Lamp:
    """Excelitas OmniCure S2000: docs/devices/lamp.md."""

    BURNS, OPEN, WARM = 2, 4, 16  # bits of GUS
    TOLD = {"VEB": "105", "GSN": "20158", "GLH": "340"}

    def __init__(self):
        self.heard, self.talks, self.tenths, self.open_until = b"", False, 0, 0.0

    def closed(self, now):
        self.heard = b""  # an open shutter stays open: nothing says that it closes

    @staticmethod
    def sealed(text):
        crc = 0
        for byte in text.encode():
            crc ^= byte
            for _ in range(8):
                crc = crc >> 1 ^ (0x8C if crc & 1 else 0)
        return f"{text}{crc:02X}\r".encode()

    def take(self, data, now):
        *lines, self.heard = (self.heard + data).split(b"\r")
        said = b""
        for line in lines:
            text = line[:-2].decode("latin-1")
            said += self.sealed(self.obey(text, now) if self.sealed(text)[:-1] == line else "Err")
        return said

    def obey(self, text, now):
        if text == "CONN":
            self.talks = True
            return "READY"
        if not self.talks:
            return "Err"
        if text == "DCON":
            self.talks = False
            return "CLOSED"
        if text in self.TOLD:
            return self.TOLD[text]
        if text == "GUS":
            return str(self.BURNS | self.WARM | (self.OPEN if now < self.open_until else 0))
        if text == "GTM":
            return str(self.tenths)
        if text.startswith("STM"):
            self.tenths = int(text[3:])
        elif text in ("RUN", "OPN"):
            self.open_until = now + (0.1 * self.tenths if text == "RUN" else math.inf)
        elif text == "CLS":
            self.open_until = 0.0
        elif not text.startswith("SIL") and text not in ("TON", "TOF"):
            return "Err"
        return "Received"
