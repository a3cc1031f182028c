"""What random claims are drawn from: instants, windows, values and limits around what a scene is made to do."""

from fractions import Fraction

import trains
from figures import INTEGERS, Limits, MS, Wanted, bounds, duration, text
from placement import LAST
from scenes import CHANNELS, COARSE, LINES, VARIABLES, toml
from trains import MISSING

BOOLS = [*LINES, "v_bool"]
NUMBERS = [*CHANNELS, *(name for name, kind in VARIABLES.items() if kind != "BOOL")]
LEDS = ("off", "on", "fast-flash", "regular-flash", "single-flash")


class Claim:
    """One entry of a plan: its verb, what it says, the signals that it looks at."""

    def __init__(self, group, verb, keys, written, names):
        self.group, self.verb, self.keys, self.names = group, verb, keys, sorted(set(names))
        self.written = written

    def text(self, name):
        body = ", ".join(f"{key} = {value}" for key, value in self.written.items())
        if self.group == "measure":
            return f'{{ name = "{name}", {body} }}'
        return f'{{ name = "{name}", {self.verb.split(" ")[0]} = {{ {body} }} }}'


class Drawing:
    """Draws what claims on a scene say. `only` are the signals that may be used, `unseen` is the time between two samples of
    a sampled recording, `filters` are the verbs that take `pulses-longer-than`."""

    def __init__(self, scene, rng, only=None, unseen=0, filters=()):
        self.scene, self.rng, self.unseen = scene, rng, unseen
        self.placement = scene.nominal()
        self.only = only
        self.filters = filters

    def pick(self, names):
        names = [name for name in names if self.only is None or name in self.only]
        moving = [name for name in names if len(self.placement.tracks[name].at) > 1]
        return self.coarse(self.rng.choice(moving if moving and self.rng.random() < 0.85 else names))

    def coarse(self, name):
        """Now and then a second name of a signal, recorded coarsely."""
        if self.scene.way == "exact" and self.rng.random() < 0.2:
            return next((second for second, (origin, _) in COARSE.items() if origin == name), name)
        return name

    # Instants and windows.

    def base(self):
        """An instant, and where it is expected."""
        rng = self.rng
        name = rng.choice(["start", *self.scene.marks, *self.scene.marks])
        if rng.random() < 0.06:
            return ("end", -rng.randrange(1, 30) * MS)
        if self.scene.awaited and rng.random() < 0.15:
            return self.awaited_base()
        distance = rng.choice((0, 0, 1, 2, 3, -1)) * MS
        if self.placement.at((name, 0))[0] + distance <= 0:
            distance = 0
        return (name, distance)

    def awaited_base(self):
        step = self.rng.choice(self.scene.awaited)[0]
        return (step, self.rng.choice((0, 1, 2)) * MS)

    def place(self, instant):
        """Where an instant is expected, from the start on."""
        base, distance = instant
        if base in self.placement.steps:
            return self.placement.steps[base][0] + distance
        _, signal, kind, since, limit = next(step for step in self.scene.awaited if step[0] == base)
        begin = self.placement.at((since, 0))
        times = self.placement.edges(signal, kind, begin, (LAST, 0))
        return (times[0] if times else begin[0] + limit) + distance

    def since(self, keys, written):
        """`from`, drawn."""
        if self.rng.random() < 0.2:
            return 0
        keys["from"] = self.base()
        written["from"] = instant(keys["from"])
        return self.place(keys["from"])

    def until(self, keys, written, begin, least=MS):
        """`until`, after the beginning."""
        if self.rng.random() < 0.35:
            return
        base = keys.get("from", ("start", 0))
        room = (self.scene.end - begin) // MS - 2
        marks = [(name, 0) for name, time in self.scene.marks.items() if time > begin + least]
        if marks and base[0] in self.placement.steps and self.rng.random() < 0.4:
            keys["until"] = self.rng.choice(marks)
        elif room > least // MS:
            keys["until"] = (base[0], base[1] + self.rng.randrange(least // MS, room) * MS)
            if keys["until"][1] == 0:
                keys["until"] = (base[0], MS)
        else:
            return
        written["until"] = instant(keys["until"])

    def with_shortest(self, claim):
        """With `pulses-longer-than`, now and then."""
        if (claim.group, claim.verb) in self.filters and self.rng.random() < (0.6 if self.unseen else 0.15) and \
                not claim.keys.get("number"):
            length = self.unseen * self.rng.choice((1, 1, 2)) if self.unseen else self.rng.randrange(1, 8) * MS // 2
            claim.keys["pulses-longer-than"] = length
            train = f"{claim.verb}-of"
            if claim.group == "measure" and claim.verb in ("position", "profile"):
                # Of a pulse train it stands among its keys.
                claim.written[train] = claim.written[train][:-2] + f', pulses-longer-than = "{duration(length)}" }}'
            else:
                claim.written["pulses-longer-than"] = quoted(duration(length))
        return claim

    # Limits.

    def around(self, figure, spread, grid, least=None):
        """Limits around a figure, on a grid; now and then just on it, or beyond it."""
        rng = self.rng
        low = figure - rng.choice((0, 0, 1, 2, rng.randrange(0, 20), -1)) * spread
        high = figure + rng.choice((0, 0, 1, 2, rng.randrange(0, 20), -1)) * spread
        low, high = Fraction(round(low / grid)) * grid, Fraction(round(high / grid)) * grid
        if low > high:
            low, high = high, low
        if least is not None:
            low, high = max(low, least), max(high, least)
        shape = rng.choice(("range", "range", "tolerance", "low", "high"))
        if shape == "tolerance" and (low + high) / 2 % grid:
            shape = "range"
        if shape == "low":
            return Limits(low, None)
        if shape == "high":
            return Limits(None, high)
        return Limits(low, high, style=shape)

    def within(self, keys, written, begin, times):
        """`within`, around the first of these times."""
        if self.rng.random() < 0.12:
            return
        delay = times[0] - begin if times else self.rng.randrange(0, 30) * MS
        limits = self.around(Fraction(delay), MS, Fraction(MS if delay % MS == 0 else 1), least=Fraction(0))
        if limits.low == 0 and limits.high is None:
            return
        room = self.scene.end - begin
        if (limits.high or 0) > room or (limits.low or 0) > room:
            return
        if limits.high is not None and limits.low in (None, 0) and self.rng.random() < 0.8:
            limits = Limits(Fraction(0), limits.high, at_most=True)
        if limits.high == 0 and not limits.at_most:
            limits = Limits(Fraction(0), Fraction(MS), at_most=True)
        keys["within"] = limits
        written["within"] = f'"{limits.written(in_ms, "ms")}"'

    def wanted(self, name, keys, written):
        """A value that a claim wants of a signal, near those that the signal has."""
        rng = self.rng
        kind = self.scene.types()[name]
        if kind == "BOOL":
            value = rng.random() < 0.5
            keys["wanted"] = Wanted([value])
            written["is"] = toml(value, kind)
            return
        values = [value for value in self.placement.tracks[name].values if value is not None]
        value = rng.choice(values)
        how = rng.choice(("is", "one-of", "limits", "limits", "range", "range"))
        if how == "is":
            value += rng.choice((0, 0, 1)) if kind in INTEGERS else 0
            value = self.fitting(value, kind)
            keys["wanted"] = Wanted([value])
            written["is"] = toml(value, kind)
            return
        if how == "one-of":
            some = sorted({value, self.fitting(rng.choice(values) + rng.choice((0, 1)), kind)})
            keys["wanted"] = Wanted(some)
            written["one-of"] = f"[{', '.join(toml(one, kind) for one in some)}]"
            return
        limits = self.limits(value, kind)
        if kind in INTEGERS and every(limits, kind) is not None:
            limits = Limits(value, value)
        keys["wanted"] = Wanted(limits=limits)
        write_limits(limits, kind, written, "is" if how == "range" else "limits")

    def limits(self, value, kind):
        step = {"bar": Fraction(1, 10), "TIME": Fraction(MS), "LREAL": Fraction(1, 10), "REAL": Fraction(1, 8)}.get(kind, Fraction(1))
        limits = self.around(value, step, Fraction(1, 1000) if kind == "LREAL" else step)
        if kind in INTEGERS:
            low, high = bounds(kind)
            limits = Limits(None if limits.low is None else min(max(limits.low, low), high),
                            None if limits.high is None else min(max(limits.high, low), high))
        if kind == "TIME":
            limits = Limits(limits.low and max(limits.low, Fraction(0)), limits.high and max(limits.high, Fraction(0)), limits.style)
        return limits

    def fitting(self, value, kind):
        if kind in INTEGERS:
            low, high = bounds(kind)
            return min(max(value, low), high)
        return value

    def figure(self, found, keys, written, spread, places, unit, least=None):
        """`is`, or `min` and `max`, of a figure."""
        if found is None or found == MISSING:
            found = Fraction(self.rng.randrange(1, 50))
        found = Fraction(float(found)).limit_denominator(10 ** 12)
        # Of a large figure the first twelve digits are enough to ask for.
        grid = max(Fraction(1, 10 ** places), Fraction(10) ** (len(str(abs(int(found)))) - 12))
        limits = self.around(found, max(spread, grid), grid, least)
        keys["is"] = limits
        if self.rng.random() < 0.6:
            written["is"] = f'"{limits.written(text, unit)}"'
        else:
            for key, limit in (("min", limits.low), ("max", limits.high)):
                if limit is not None:
                    written[key] = f'"{text(limit)} {unit}"' if unit else text(limit)

    def expected(self, figure, keys):
        placement = shifted(self)
        begin, end = trains.window(keys, placement)
        return figure(keys, placement) if begin[0] < end[0] else None

    # Keys that several verbs share.

    def when(self, keys, written):
        if self.rng.random() < 0.15:
            return
        keys["when"] = self.base()
        written["when"] = instant(keys["when"])

    def cycles(self, edges=("rises", "falls"), key="signal", measure=False):
        busy = [name for name in LINES if len(self.placement.tracks[name].at) > 5]
        keys, written = {"signal": self.pick(busy if busy and self.rng.random() < 0.8 else LINES)}, {}
        written[key] = quoted(keys["signal"])
        if not measure and self.rng.random() < 0.5:
            keys["edge"] = self.rng.choice(edges)
            written["edge"] = quoted(keys["edge"])
        begin = self.since(keys, written)
        self.until(keys, written, begin, 5 * MS)
        return keys, written

    def jitter_keys(self, keys, written):
        if self.rng.random() < 0.5:
            keys["compares"] = self.rng.choice(("edges", "periods"))
            written["compares"] = quoted(keys["compares"])
        if self.rng.random() < 0.5:
            keys["take"] = self.rng.choice(("span", "rms"))
            written["take"] = quoted(keys["take"])
        if self.rng.random() < 0.4:
            found = self.expected(trains.periods, keys)
            keys["grid"] = Fraction(found[0] if found else 5 * MS)
            if keys.get("compares") == "periods" and keys.get("take", "span") == "span":
                del keys["grid"]
                return
            written["grid"] = quoted(duration(int(keys["grid"])))

    def number_window(self):
        name = self.pick(["count", "copy", "v_lint", "v_int", "v_dint"])
        keys, written = {"signal": name}, {}
        begin = self.since(keys, written)
        self.until(keys, written, begin)
        # Numbers change at whole milliseconds; which one counts at that very instant is not said.
        for key in ("from", "until"):
            if key in keys and self.rng.random() < 0.8:
                keys[key] = (keys[key][0], keys[key][1] + 300_000)
                written[key] = instant(keys[key])
        return name, keys, written

    def train_keys(self, number=True):
        """The keys that say what a pulse train is."""
        kinds = ["plain", "direction", "down", "quadrature"] + (["number"] if number and self.only is None else [])
        kind = self.rng.choice(kinds)
        if kind == "number":
            name = self.pick(["count", "copy", "v_lint", "v_int"])
            return {"signal": name, "number": True}, {"signal": quoted(name)}, [name]
        name, other = ("b0", "b1") if self.rng.random() < 0.6 else tuple(self.rng.sample(list(LINES), 2))
        keys, written = {"signal": name}, {"signal": quoted(name)}
        if kind == "plain":
            return keys, written, [name]
        keys[kind], written[kind] = other, quoted(other)
        if kind == "direction" and self.rng.random() < 0.4:
            keys["inverted"], written["inverted"] = True, "true"
        return keys, written, [name, other]

    def shape(self, keys, written, name):
        """A shape near what the train does, and its text: even, or from one frequency to another."""
        begin = self.since(keys, written)
        found = self.expected(trains.frequency, keys)
        rate = Fraction(round(float(found))) if found not in (None, MISSING) else Fraction(200)
        keys["points"] = [(0, rate)]
        times = [time - begin for time in self.placement.edges(name, "rises", (begin, 0), (LAST, 0))]
        if len(times) > 3 and self.rng.random() < 0.4:
            rates = [Fraction(round(trains.SECOND / (to - since))) for since, to in (times[:2], times[-2:])]
            keys["points"] = [(0, rates[0]), (times[-1], rates[1])]
        return begin, ", ".join(f'{{ at = "{duration(time)}", frequency = "{text(rate)} Hz" }}' for time, rate in keys["points"])


def shifted(drawing):
    """The nominal placement, with awaited steps where they are expected."""
    placement = drawing.placement
    steps = dict(placement.steps)
    for step, *_ in drawing.scene.awaited:
        steps[step] = (drawing.place((step, 0)), 4)
    return type(placement)(placement.tracks, steps)


def quoted(words):
    return f'"{words}"'


def instant(when):
    base, distance = when
    if not distance:
        return quoted(base)
    return quoted(f"{base} {'+' if distance > 0 else '-'} {duration(abs(distance))}")


def in_ms(number):
    return text(Fraction(number) / MS)


def in_unit(number, unit):
    return quoted(f"{text(number)} {unit}") if unit else toml(number, "LINT")


def limits_beyond(limits, low, high):
    return (limits.low or low) > high or (limits.low or low) <= low and (limits.high is None or limits.high >= high)


def every(limits, kind):
    """Whether all values of a type keep the limits, True, or none, False; None in between."""
    low, high = bounds(kind)
    if (limits.low is None or limits.low <= low) and (limits.high is None or limits.high >= high):
        return True
    if limits.low is not None and limits.low > high or limits.high is not None and limits.high < low:
        return False
    return None


def write_limits(limits, kind, written, how):
    """`is` with a range, or `min` and `max`."""
    if how == "is" and limits.low is not None and limits.high is not None and kind != "TIME":
        write = text
        if kind in INTEGERS:
            limits.style = "range"
        written["is"] = quoted(limits.written(write, "bar" if kind == "bar" else ""))
        return
    for key, limit in (("min", limits.low), ("max", limits.high)):
        if limit is not None:
            written[key] = toml(limit, kind)
