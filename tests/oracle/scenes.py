"""Random scenes: what lines, channels, variables, frames and the controller do in a case, and the plan that makes them do it.

Times are nanoseconds from `start`. Most lie on whole milliseconds, so that changes, steps and limits often fall together.
"""

from fractions import Fraction

from figures import INTEGERS, MS, bounds, duration, rounded, text
from placement import Placement, Track

LINES = {"b0": "%IX0.0", "b1": "%IX0.1", "b2": "%IX0.2", "b3": "%IX0.3"}
CHANNELS = ("p", "q")
VARIABLES = {f"v_{kind.lower()}": kind for kind in INTEGERS} | {
    "v_bool": "BOOL", "v_time": "TIME", "v_lreal": "LREAL", "v_real": "REAL", "count": "LINT", "copy": "LINT"}
# Second names of signals that are recorded coarsely, with what is said of them.
COARSE = {"p_band": ("p", 'channel = "p", deadband = "0.3 bar"'),
          "b3_slow": ("b3", 'address = "%IX0.3", at-most-every = "4 ms"'),
          "count_slow": ("count", 'path = "MAIN.count", at-most-every = "6 ms"'),
          "v_int_band": ("v_int", 'path = "MAIN.v_int", deadband = 2')}
# Those that have at most one value in this time, in nanoseconds.
EVERY = {"b3_slow": 4_000_000, "count_slow": 6_000_000}
STATES = ("OFF", "BOOTING", "INVALID_OS", "EMPTY", "STOPPED", "RUNNING", "HALT", "BREAKPOINT")
BOARD = """format = 1
title = "Lines, two pressures and a bus"
[board]
kind = "simulated"
[channels]
p = {{ kind = "analog", unit = "bar" }}
q = {{ kind = "analog", unit = "bar" }}
{more}
"""
EXACT = BOARD.format(more='[buses]\nmachine = { kind = "can", bitrate = 1_000_000 }')
LATE = BOARD.format(more='[faults]\nlate = { chance = 1.0, by = "3 ms" }')


class Scene:
    """One case: what happens in it."""

    def __init__(self, rng, way):
        self.way = way
        self.end = rng.choice((60, 80)) * MS
        # Now and then something happens right up to the end.
        self.busy = self.end - rng.choice((20, 20, 0)) * MS
        self.flipped = set()
        self.changes = {}
        self.writes = {}
        self.commands = []
        self.sends = []
        self.awaited = []
        self.lost = []
        self.marks = {f"m{index}": time for index, time in enumerate(sorted(rng.sample(range(1, self.busy // MS), 3)))}
        self.marks = {name: time * MS for name, time in self.marks.items()}
        self.make_lines(rng)
        self.make_values(rng)
        if way == "exact":
            self.make_events(rng)
        self.make_awaited(rng)

    def instant(self, rng, fine):
        """Where something changes."""
        time = rng.randrange(1, self.busy // MS) * MS
        return time + rng.choice((0, 0, 0, 500_000, rng.randrange(MS))) if fine else time

    def make_lines(self, rng):
        fine = rng.random() < 0.4
        for name in LINES:
            kind = rng.choice(("none", "few", "few", "many", "train", "train"))
            if kind == "none":
                times = []
            elif kind == "train":
                times = train(rng, self.busy)
            else:
                times = sorted({self.instant(rng, fine) for _ in range(rng.randrange(1, 4 if kind == "few" else 10))})
            if self.busy == self.end and rng.random() < 0.5:
                times = sorted({*times, self.end - rng.randrange(1, 3_000_000)})
            self.changes[name] = [(time, index % 2 == 0) for index, time in enumerate(times)]
        if rng.random() < 0.4:
            a, b = quadrature(rng, self.busy)
            self.changes["b0"], self.changes["b1"] = toggles(a), toggles(b)
        if rng.random() < 0.3:
            # One train comes after the other by an angle.
            first = train(rng, self.busy - 8 * MS)
            shift = rng.randrange(0, 32) * MS // 4
            self.changes["b2"], self.changes["b3"] = toggles(first), toggles([time + shift for time in first])

    def make_values(self, rng):
        fine = rng.random() < 0.4
        for name in CHANNELS:
            times = sorted({self.instant(rng, fine) for _ in range(rng.randrange(0, 7))})
            shape = rng.choice(("any", "any", "towards"))
            values, goal = [], Fraction(rng.randrange(10, 40), 10)
            for index, _ in enumerate(times):
                if shape == "any":
                    values.append(Fraction(rng.randrange(0, 60), rng.choice((10, 20, 100))))
                else:
                    values.append(goal + rounded(Fraction(rng.randrange(-9, 10), 10 * (index + 1) ** 2), 2))
            self.changes[name] = changing(zip(times, values), Fraction(0))
        if rng.random() < 0.3 and self.changes["p"]:
            shift = rng.choice((0, MS, 2 * MS))
            self.changes["q"] = [(time + shift, value) for time, value in self.changes["p"] if time + shift < self.busy]
        for name, kind in VARIABLES.items():
            times = {self.instant(rng, False) for _ in range(rng.randrange(0, 4))}
            if name in ("count", "copy"):
                times = {self.instant(rng, False) for _ in range(rng.randrange(2, 7))}
            base = Fraction(rng.choice((1 << 60, 1 << 53, (1 << 63) - 100, -(1 << 62), 1000)))
            values, last = [], initial(kind)
            for index, time in enumerate(sorted(times)):
                values.append((time, base + index if name in ("count", "copy") else any_value(rng, kind)))
            self.writes[name] = changing(values, last)
        if rng.random() < 0.5:
            self.writes["copy"] = [(time, value) for time, value in self.writes["count"]]
            if rng.random() < 0.5 and self.writes["copy"]:
                time, value = self.writes["copy"][-1]
                self.writes["copy"][-1] = (time, value + rng.choice((-1, 1)))
                self.writes["copy"] = changing(self.writes["copy"], Fraction(0))

    def make_events(self, rng):
        if rng.random() < 0.5:
            times = sorted(rng.sample(range(self.end // MS - 28, self.end // MS - 12), 2))
            self.commands = [(time * MS, verb) for time, verb in zip(times, ("stop", "run"))][:rng.choice((1, 2))]
        if rng.random() < 0.4:
            self.sends = [(rng.randrange(1, 10) * MS, rng.randrange(2, 8) * MS, rng.randrange(1, 6))]
        if rng.random() < 0.4:
            since = rng.randrange(1, self.busy // MS - 12)
            self.lost = [(rng.choice(("b2", "q")), since * MS + 200_000, rng.randrange(1, 10) * MS)]

    def make_awaited(self, rng):
        for index in range(rng.choice((0, 1, 2))):
            signal = rng.choice(("b0", "b1", "b3"))
            since = rng.choice(["start", *self.marks])
            limit = rng.randrange(1, 30) * MS
            kind = rng.choice(("rises", "falls", "changes"))
            times = [time for time, value in self.changes[signal] if time >= self.marks.get(since, 0)
                     and (kind == "changes" or value == (kind == "rises"))]
            if times and rng.random() < 0.5:
                limit = max(times[0] - self.marks.get(since, 0), MS) + rng.choice((0, 0, 1))
            self.awaited.append((f"w{index}", signal, kind, since, limit))

    def types(self):
        """What every signal is: `BOOL`, `REAL` of a number with a unit, or the type of a variable."""
        kinds = {name: "BOOL" for name in LINES} | {name: "bar" for name in CHANNELS} | dict(VARIABLES)
        return kinds | {name: kinds[origin] for name, (origin, _) in COARSE.items()}

    def nominal(self):
        """The placement that is asked for."""
        tracks = {}
        for name in LINES:
            over = name in self.flipped
            tracks[name] = Track([(-MS, 1, over)] + [(time, 5, value != over) for time, value in self.changes[name]])
        for name in CHANNELS:
            tracks[name] = Track([(-MS, 1, Fraction(0))] + [(time, 5, value) for time, value in self.changes[name]])
        for name, kind in VARIABLES.items():
            tracks[name] = Track([(-MS, 1, initial(kind))] + [(time, 5, value) for time, value in self.writes[name]])
        tracks |= {name: tracks[origin] for name, (origin, _) in COARSE.items()}
        steps = {"start": (0, 2), "end": (self.end, 9)} | {name: (time, 3) for name, time in self.marks.items()}
        return Placement(tracks, steps)

    def rows(self):
        """The sequence of the board's lines and channels."""
        names = [name for name in (*LINES, *CHANNELS) if self.changes[name]]
        times = sorted({time for name in names for time, _ in self.changes[name]})
        lines = ["time [ns]," + ",".join(f"{name} [bar]" if name in CHANNELS else name for name in names)]
        values = {name: dict(self.changes[name]) for name in names}
        for time in times:
            fields = [literal(values[name][time]) if time in values[name] else "" for name in names]
            lines.append(f"{time}," + ",".join(fields).upper())
        return "\n".join(lines) + "\n"

    def plan(self, name, entries):
        """The text of the plan, and the number of the line at which each entry stands. An entry is the list that it belongs
        to and its text."""
        variables = " ".join(f"{variable} : {kind};" for variable, kind in VARIABLES.items())
        signals = [f'{line} = "{address}"' for line, address in LINES.items()]
        signals += [f'{channel} = {{ channel = "{channel}", record = true }}' for channel in CHANNELS]
        signals += [f'{variable} = {{ path = "MAIN.{variable}", record = true }}' for variable in VARIABLES]
        head = ["format = 1", f'title = "{name}"', f'board = "{self.way}.toml"', 'needs = ["memory-access"]',
                f'program-text = "PROGRAM MAIN VAR {variables} END_VAR END_PROGRAM"', f'ends = "start + {duration(self.end)}"']
        steps = [f'{{ id = "{mark}", at = "start + {duration(time)}", mark = {{}} }},' for mark, time in self.marks.items()]
        if any(self.changes.values()):
            steps.insert(0, f'{{ id = "drive", at = "start", sequence = {{ file = "{name}.csv" }} }},')
        for variable, writes in self.writes.items():
            steps += [f'{{ id = "{variable}_{index}", at = "start + {duration(time)}", write = {{ of = "{variable}", '
                      f'value = {written(value, VARIABLES[variable])} }} }},' for index, (time, value) in enumerate(writes)]
        steps += [f'{{ id = "lost", at = "start + {duration(time)}", fault = {{ signal = "{signal}", kind = "lost", '
                  f'duration = "{duration(length)}" }} }},' for signal, time, length in self.lost]
        steps += [f'{{ id = "{command}", at = "start + {duration(time)}", command = "{command}" }},' for time, command in self.commands]
        steps += [f'{{ id = "beats", at = "start + {duration(time)}", send = {{ frame = "beat", period = "{duration(period)}", '
                  f'count = {count} }} }},' for time, period, count in self.sends]
        steps += [f'{{ id = "{step}", when = {{ signal = "{signal}", edge = "{kind}", from = "{since}", within = "{duration(limit)}" }} }},'
                  for step, signal, kind, since, limit in self.awaited]
        more = []
        if self.way == "exact":
            signals += ['led = { path = "LED.RUN", record = true }', 'log = { log = "RUNNING", record = true }',
                        'cycles = { task = "MAST", figure = "cycles", record = true }']
            signals += [f"{name} = {{ {words}, record = true }}" for name, (_, words) in COARSE.items()]
            more = ["[frames]", 'beat = { bus = "machine", id = 0x701, data = "05", record = true }']
        lines = head + [f"signals = {{ {', '.join(signals)} }}", "steps = [", *steps, "]"]
        places = []
        for group in ("expect", "measure"):
            mine = [(index, entry) for index, (kind, entry) in enumerate(entries) if kind == group]
            if mine:
                lines.append(f"{group} = [")
                for index, entry in mine:
                    lines.append(entry + ",")
                    places.append((len(lines), index))
                lines.append("]")
        return "\n".join(lines + more) + "\n", dict(places)


def toggles(times):
    return [(time, index % 2 == 0) for index, time in enumerate(times)]


def train(rng, busy):
    """Changes of an even train, now and then one that is a little off."""
    period = rng.randrange(4, 16) * MS // 2
    high = max(period * rng.randrange(1, 8) // 8 // 250_000 * 250_000, 250_000)
    high = min(high, period - 250_000)
    time, times = rng.randrange(1, 8) * MS, []
    off = rng.choice((0, 0, 1000, 100_000))
    # Some go faster and faster, or slower.
    change = rng.choice((0, 0, 0, 1, -1)) * rng.choice((50_000, 200_000))
    while time + period + MS < busy and len(times) < 20:
        shift = rng.randrange(-off, off + 1) if off else 0
        times += [time + shift, time + shift + high]
        time += period
        period = min(max(period + change, high + 250_000), 10 * MS)
    return times


def quadrature(rng, busy):
    """Changes of two phases that go forwards and back."""
    step = rng.randrange(1, 5) * MS // 2
    time, place, way, tracks = 2 * MS, 0, 1, ([], [])
    for _ in range(rng.randrange(4, 20)):
        if time + step >= busy:
            break
        if rng.random() < 0.15:
            way = -way
        place += way
        # Forwards A changes on the odd places and B on the even ones, backwards the other way round.
        tracks[0 if (place if way > 0 else place + 1) % 2 else 1].append(time)
        time += step
    return tracks


def changing(pairs, last):
    """Without values that are what was there before."""
    kept = []
    for time, value in pairs:
        if value != last:
            kept.append((time, value))
        last = value
    return kept


def initial(kind):
    return False if kind == "BOOL" else Fraction(0)


def any_value(rng, kind):
    """A value of a type, often near one of its ends or beyond what a real number holds exactly."""
    if kind == "BOOL":
        return rng.random() < 0.5
    if kind == "TIME":
        return Fraction(rng.randrange(0, 5000) * MS)
    if kind == "LREAL":
        return Fraction(rng.randrange(-1000, 1000), rng.choice((10, 100, 1000)))
    if kind == "REAL":
        return Fraction(rng.randrange(-1000, 1000), 8)
    low, high = bounds(kind)
    near = rng.choice((low, high, 0, (1 << 53) if high > 1 << 53 else 0, (1 << 62) if high > 1 << 62 else 0, high // 2 + 1))
    return Fraction(min(max(near + rng.randrange(-3, 4), low), high))


def literal(value):
    return str(value).upper() if isinstance(value, bool) else text(value)


def written(value, kind):
    """A value as a step writes it: beyond 63 bits in a base of digits, which every build takes."""
    return f'"16#{int(value):X}"' if not isinstance(value, bool) and value >= 1 << 63 else toml(value, kind)


def toml(value, kind):
    """A value as a plan writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if kind == "TIME":
        return f'"{duration(int(value))}"'
    if kind == "bar":
        return f'"{text(value)} bar"'
    if value < -(1 << 63):
        return f'"{text(value)}"'
    if value.denominator == 1 and value >= 1 << 63:
        # TOML has no such integers: a larger one is written as a text.
        return f'"16#{int(value):X}"' if value % 2 and kind != "bar" else f'"{int(value)}"'
    return text(value)
