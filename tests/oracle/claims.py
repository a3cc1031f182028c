"""Random claims on a scene, written as a plan has them and as verbs.py and trains.py take them.

Limits are drawn around what the scene is made to do, on it now and then, so that most claims are decided by little.
"""

from fractions import Fraction

import trains
from drawing import BOOLS, LEDS, NUMBERS, Claim, shifted, in_ms, instant, limits_beyond, quoted, write_limits
from figures import INTEGERS, Limits, MS, Wanted, duration, rounded, text
from placement import LAST
from measurements import Measurements
from scenes import CHANNELS, LINES, STATES, toml
from trains import MISSING


class Maker(Measurements):
    """Makes claims and measurements of every verb."""

    def make(self, group, verb):
        """A claim of this verb; None where this scene has none."""
        claim = getattr(self, f"{group}_{verb.replace('-', '_')}")()
        return claim and self.with_shortest(claim)

    def first(self, verb, names):
        keys, written = {"signal": self.pick(names)}, {}
        written["signal"] = f'"{keys["signal"]}"'
        begin = self.since(keys, written)
        self.within(keys, written, begin, self.placement.edges(keys["signal"], verb, (begin, 0), (LAST, 0)))
        return Claim("expect", verb, keys, written, [keys["signal"]])

    def expect_rises(self):
        return self.first("rises", BOOLS)

    def expect_falls(self):
        return self.first("falls", BOOLS)

    def expect_changes(self):
        return self.first("changes", BOOLS + NUMBERS)

    def expect_becomes(self):
        keys, written = {"signal": self.pick(BOOLS + NUMBERS)}, {}
        written["signal"] = f'"{keys["signal"]}"'
        self.wanted(keys["signal"], keys, written)
        begin = self.since(keys, written)
        entered = [time for time, before, after in self.placement.tracks[keys["signal"]].changes((begin, 0), (LAST, 0))
                   if keys["wanted"].has(after) and not keys["wanted"].has(before)]
        self.within(keys, written, begin, entered)
        return Claim("expect", "becomes", keys, written, [keys["signal"]])

    def all_along(self, verb):
        keys, written = {"signal": self.pick(BOOLS + NUMBERS)}, {}
        written["signal"] = f'"{keys["signal"]}"'
        self.wanted(keys["signal"], keys, written)
        begin = self.since(keys, written)
        self.until(keys, written, begin)
        return Claim("expect", verb, keys, written, [keys["signal"]])

    def expect_stays(self):
        return self.all_along("stays")

    def expect_never(self):
        if self.rng.random() < 0.5:
            return self.all_along("never")
        names = self.rng.sample([name for name in BOOLS if self.only is None or name in self.only], self.rng.randrange(2, 4))
        keys, written = {"signals": names, "how": self.rng.choice(("all", "any-two"))}, {}
        written[keys["how"]] = f"[{', '.join(quoted(name) for name in names)}]"
        begin = self.since(keys, written)
        self.until(keys, written, begin)
        return Claim("expect", "never", keys, written, names)

    def expect_edges(self):
        keys, written = {"signal": self.pick(BOOLS)}, {}
        written["signal"] = f'"{keys["signal"]}"'
        begin = self.since(keys, written)
        self.until(keys, written, begin)
        placement = shifted(self)
        found = len(placement.edges(keys["signal"], "rises", *trains.window(keys, placement)))
        which = self.rng.choice((("rising",), ("falling",), ("rising", "falling")))
        for key in which:
            low = max(found - self.rng.choice((0, 0, 1)), 0)
            high = low + self.rng.choice((0, 0, 1, 2))
            shape = self.rng.choice(("one", "range", "least"))
            if shape == "least" and low > 0:
                keys[key], written[key] = Limits(low, None), f'"{low} .."'
            elif shape == "range" and high > low:
                keys[key], written[key] = Limits(low, high), f'"{low} .. {high}"'
            else:
                keys[key], written[key] = Limits(low, low), str(low)
        return Claim("expect", "edges", keys, written, [keys["signal"]])

    def expect_settles(self):
        name = self.pick([*CHANNELS, "v_lreal", "v_int"])
        keys, written = {"signal": name}, {"signal": quoted(name)}
        kind = self.scene.types()[name]
        values = self.placement.tracks[name].values
        value = values[-1]
        step = Fraction(1, 10) if kind in ("bar", "LREAL") else Fraction(1)
        width = self.rng.randrange(0, 10) * step
        middle = value + self.rng.choice((0, 0, 1, -1)) * step
        low, high = middle - width, middle + width
        if kind in INTEGERS:
            low, high = self.fitting(low, kind), self.fitting(high, kind)
        limits = Limits(low, high, self.rng.choice(("range", "tolerance")))
        keys["wanted"] = Wanted(limits=limits)
        write_limits(limits, kind, written, "is" if self.rng.random() < 0.5 else "limits")
        begin = self.since(keys, written)
        times = [time for time, _ in self.placement.tracks[name].at if time >= begin]
        settle = max((self.rng.choice(times) - begin if times else 0) + self.rng.choice((0, 0, 1, -1, 5)) * MS, MS)
        settle = min(settle, self.scene.end - begin - 2 * MS)
        if settle <= 0:
            return None
        keys["settle"] = settle
        written["within"] = quoted(duration(settle))
        if self.rng.random() < 0.3:
            base = keys.get("from", ("start", 0))
            end = settle + self.rng.randrange(1, 10) * MS
            if begin + end < self.scene.end:
                keys["until"] = (base[0], base[1] + end)
                written["until"] = instant(keys["until"])
        if self.rng.random() < 0.4:
            if self.rng.random() < 0.5:
                share = self.rng.randrange(0, 40) * 5
                keys["overshoot"], written["overshoot"] = (Fraction(share, 100), True), f'"{share} %"'
            else:
                amount = self.rng.randrange(0, 30) * step
                keys["overshoot"] = (amount, False)
                written["overshoot"] = toml(amount, kind)
        return Claim("expect", "settles", keys, written, [name])

    def pair(self):
        """Two signals of a kind."""
        pairs = [(name, other) for name, other in (("p", "q"), ("q", "p"), ("count", "copy"), ("copy", "count"), ("v_lint", "count"),
                 ("b0", "b1"), ("b2", "b3"), ("v_int", "v_dint")) if self.only is None or {name, other} <= set(self.only)]
        return self.rng.choice(pairs)

    def tolerance(self, one, other, keys, written, chance=0.6):
        kind = self.scene.types()[one]
        if kind == "BOOL" or self.rng.random() > chance:
            return
        if kind == "bar":
            keys["tolerance"] = Fraction(self.rng.randrange(0, 30), 10)
        else:
            keys["tolerance"] = Fraction(self.rng.randrange(0, 4))
            gaps = [abs(a - b) for a in self.placement.tracks[one].values for b in self.placement.tracks[other].values]
            if gaps and self.rng.random() < 0.4:
                keys["tolerance"] = min(self.rng.choice(gaps), Fraction((1 << 62)))
        written["tolerance"] = toml(keys["tolerance"], kind)

    def expect_follows(self):
        one, other = self.pair()
        keys, written = {"signal": one, "leader": other}, {"signal": quoted(one), "leader": quoted(other)}
        self.tolerance(one, other, keys, written)
        begin = self.since(keys, written)
        self.until(keys, written, begin)
        if self.rng.random() < 0.6:
            keys["longest"] = self.rng.randrange(1, 10) * MS
            written["within"] = quoted(duration(keys["longest"]))
        return Claim("expect", "follows", keys, written, [one, other])

    def expect_value(self):
        if self.rng.random() < 0.2:
            return self.near_another()
        name = self.pick(BOOLS + NUMBERS)
        keys, written = {"of": name}, {"of": quoted(name)}
        kind = self.scene.types()[name]
        if kind != "BOOL" and self.rng.random() < 0.3:
            near = self.rng.choice(self.placement.tracks[name].values)
            near = self.fitting(near + self.rng.choice((0, 1)), kind) if kind != "TIME" else near
            keys["near"] = near
            written["near"] = toml(near, kind)
            if kind in INTEGERS or kind == "TIME":
                keys["tolerance"] = self.rng.randrange(0, 3) * Fraction(MS if kind == "TIME" else 1)
                written["tolerance"] = toml(keys["tolerance"], kind)
            elif self.rng.random() < 0.5:
                share = self.rng.randrange(1, 30)
                keys["tolerance"] = abs(near) * Fraction(share, 100)
                written["tolerance"] = f'"{share} %"'
            else:
                keys["tolerance"] = Fraction(self.rng.randrange(0, 20), 10)
                written["tolerance"] = toml(keys["tolerance"], kind)
        else:
            self.wanted(name, keys, written)
        self.when(keys, written)
        return Claim("expect", "value", keys, written, [name])

    def near_another(self):
        """A value near that of another signal, at an instant of its own."""
        one, other = self.rng.choice([pair for pair in (("p", "q"), ("p", "p"), ("count", "copy"), ("v_int", "v_int"))
                                      if self.only is None or set(pair) <= set(self.only)])
        keys = {"of": one, "near": other, "near-at": self.base(), "tolerance": Fraction(0)}
        written = {"of": quoted(one), "near": quoted(f"{other} @ {instant(keys['near-at'])[1:-1]}")}
        self.tolerance(one, other, keys, written)
        self.when(keys, written)
        return Claim("expect", "value", keys, written, [one, other])

    def expect_equal(self):
        one, other = self.pair()
        if self.rng.random() < 0.3:
            other = one
        keys, written = {"left": one, "right": other}, {"left": one, "right": other}
        for side in ("left", "right"):
            if self.rng.random() < 0.4 or one == other:
                keys[side + "-at"] = self.base()
                written[side] += f" @ {instant(keys[side + '-at'])[1:-1]}"
            written[side] = quoted(written[side])
        self.tolerance(one, other, keys, written)
        if "left-at" not in keys or "right-at" not in keys:
            self.when(keys, written)
        return Claim("expect", "equal", keys, written, [one, other])

    def expect_order(self):
        names = [name for name in BOOLS if self.only is None or name in self.only]
        some = [(self.rng.choice(names), self.rng.choice(("rises", "falls", "rises", "changes"))) for _ in range(self.rng.randrange(2, 4))]
        if len(set(some)) < len(some):
            return None
        keys = {}
        written = {"edges": f"[{', '.join(quoted(f'{name} {kind}') for name, kind in some)}]"}
        begin = self.since(keys, written)
        if self.rng.random() < 0.6:
            def first(edge):
                times = self.placement.edges(edge[0], edge[1], (begin, 0), (LAST, 0))
                return times[0] if times else LAST
            some.sort(key=first)
            written["edges"] = f"[{', '.join(quoted(f'{name} {kind}') for name, kind in some)}]"
        keys["edges"] = some
        return Claim("expect", "order", keys, written, [name for name, _ in some])

    def expect_happens(self):
        if not self.scene.awaited:
            return None
        step = self.rng.choice(self.scene.awaited)[0]
        keys, written = {"step": step}, {"step": quoted(step)}
        since = self.rng.choice([None, "start", *(mark for mark, time in self.scene.marks.items() if time <= self.place((step, 0)))])
        begin = 0
        if since:
            keys["from"] = (since, 0)
            written["from"] = quoted(since)
            begin = self.place(keys["from"])
        self.within(keys, written, begin, [self.place((step, 0))])
        return Claim("expect", "happens", keys, written, [])

    # The controller itself.

    def of_states(self, verb, signal, value, code, more):
        """`is`, `becomes` or `stays` of something that has named values."""
        how = self.rng.choice(("is", "becomes", "stays"))
        keys, written = {"signal": signal, "how": how, "wanted": Wanted([code])}, dict(more)
        written[how] = quoted(value)
        if how == "is":
            self.when(keys, written)
        else:
            begin = self.since(keys, written)
            if how == "stays":
                self.until(keys, written, begin)
            else:
                self.within(keys, written, begin, [time for time, _ in self.scene.commands if time >= begin])
        return Claim("expect", verb, keys, written, [signal])

    def expect_state(self):
        if self.scene.way != "exact":
            return None
        value = self.rng.choice(("RUNNING", "STOPPED", "RUNNING", "HALT"))
        codes = {"OFF": 32, "BOOTING": 16, "RUNNING": 2, "STOPPED": 1, "HALT": 4}
        assert set(codes) <= set(STATES)
        return self.of_states("state", "state", value, Fraction(codes[value]), {})

    def expect_led(self):
        if self.scene.way != "exact":
            return None
        value = self.rng.choice(("on", "on", "regular-flash", "off", "single-flash"))
        return self.of_states("led", "led", value, Fraction(LEDS.index(value)), {"name": '"RUN"'})

    def expect_log(self):
        if self.scene.way != "exact":
            return None
        how = self.rng.choice(("contains", "never"))
        keys, written = {"signal": "log", "how": how}, {how: '"RUNNING"'}
        begin = self.since(keys, written)
        if how == "never":
            self.until(keys, written, begin)
        else:
            self.within(keys, written, begin, [time for time, _ in self.scene.commands if time >= begin])
        return Claim("expect", "log", keys, written, ["log"])

    def expect_task(self):
        if self.scene.way != "exact":
            return None
        keys, written = {"signal": "cycles"}, {"name": '"MAST"', "figure": '"cycles"'}
        low = Fraction(self.rng.randrange(1, 4))
        limits = Limits(low, low + self.rng.randrange(0, 3)) if self.rng.random() < 0.7 else Limits(low, None)
        keys["wanted"] = Wanted(limits=limits)
        write_limits(limits, "INT", written, "limits")
        if self.rng.random() < 0.5:
            self.when(keys, written)
            keys.setdefault("when", ("end", 0))
        else:
            keys["from"] = (self.rng.choice([*self.scene.marks]), 0)
            written["from"] = instant(keys["from"])
            self.until(keys, written, self.place(keys["from"]))
        return Claim("expect", "task", keys, written, ["cycles"])

    def expect_frames(self):
        if self.scene.way != "exact":
            return None
        keys, written = {"signal": "beat"}, {"frame": '"beat"'}
        begin = self.since(keys, written)
        self.until(keys, written, begin)
        sent = self.scene.sends[0] if self.scene.sends else (0, 3 * MS, 0)
        which = self.rng.sample(("count", "cycle", "gap"), self.rng.randrange(1, 4))
        if "count" in which:
            low = max(sent[2] - self.rng.randrange(0, 3), 0)
            keys["count"] = Limits(low, low + self.rng.randrange(0, 2))
            written["count"] = str(low) if keys["count"].high == low else f'"{low} .. {keys["count"].high}"'
        if "cycle" in which:
            keys["cycle"] = self.around(Fraction(sent[1]), Fraction(MS, 10), Fraction(1000), least=Fraction(1000))
            written["cycle"] = quoted(keys["cycle"].written(in_ms, "ms"))
        if "gap" in which:
            keys["gap"] = self.rng.randrange(1, 40) * MS
            written["max-gap"] = quoted(duration(keys["gap"]))
        return Claim("expect", "frames", keys, written, ["beat"])

    # Pulses and motion.

    def expect_pulse(self):
        keys, written = {"signal": self.pick(LINES)}, {}
        written["signal"] = quoted(keys["signal"])
        begin = self.since(keys, written)
        if self.rng.random() < 0.4:
            self.until(keys, written, begin)
        for key, some in (("level", ("high", "low")), ("which", ("first", "every"))):
            if self.rng.random() < 0.6:
                keys[key] = self.rng.choice(some)
                written[key] = quoted(keys[key])
        found = [to - since for since, to in trains.pulses(keys, shifted(self)) if to is not None]
        length = self.rng.choice(found) if found else self.rng.randrange(1, 20) * MS
        keys["width"] = self.around(Fraction(length), MS, Fraction(MS if length % MS == 0 else 1), least=Fraction(1000))
        written["width"] = quoted(keys["width"].written(in_ms, "ms"))
        return Claim("expect", "pulse", keys, written, [keys["signal"]])

    def expect_period(self):
        keys, written = self.cycles(("rises", "falls", "changes"))
        found = self.expected(trains.periods, keys)
        length = self.rng.choice(found) if found else self.rng.randrange(1, 20) * MS
        if self.rng.random() < 0.3:
            off = self.rng.choice((0, 1, 2, 10)) * MS // 10
            keys["is"] = Limits(Fraction(length - off), Fraction(length + off))
            written["is"], written["tolerance"] = quoted(duration(length)), quoted(duration(off))
        else:
            keys["is"] = self.around(Fraction(length), MS, Fraction(MS if length % MS == 0 else 1), least=Fraction(1000))
            written["is"] = quoted(keys["is"].written(in_ms, "ms"))
        return Claim("expect", "period", keys, written, [keys["signal"]])

    def expect_frequency(self):
        keys, written = self.cycles()
        found = self.expected(trains.frequency, keys)
        self.figure(found, keys, written, Fraction(self.rng.choice((1, 10, 100)), 10), self.rng.choice((0, 1, 4)), "Hz", Fraction(1, 10))
        return Claim("expect", "frequency", keys, written, [keys["signal"]])

    def expect_duty(self):
        keys, written = self.cycles()
        found = self.expected(trains.duty, keys)
        self.figure(found, keys, written, Fraction(self.rng.choice((1, 10, 100)), 10), self.rng.choice((0, 1, 4)), "%", Fraction(1, 10))
        if limits_beyond(keys["is"], 0, 100):
            return None
        return Claim("expect", "duty", keys, written, [keys["signal"]])

    def expect_jitter(self):
        keys, written = self.cycles(("rises", "falls", "changes"))
        self.jitter_keys(keys, written)
        found = self.expected(trains.jitter, keys)
        if found is None or found == MISSING:
            found = Fraction(self.rng.randrange(1, 5) * MS)
        figure = Fraction(round(float(found)))
        limits = self.around(figure, Fraction(self.rng.choice((1, 1000, MS))), Fraction(1), Fraction(0))
        limits.style = "range"
        if limits.low == 0:
            limits.low = None
        if limits.high is None and limits.low is None:
            limits.low = Fraction(1000)
        if limits.high == 0:
            limits.high = Fraction(1)
        keys["is"] = limits
        for key, limit in (("min", limits.low), ("max", limits.high)):
            if limit is not None:
                written[key] = quoted(f"{text(limit)} ns")
        return Claim("expect", "jitter", keys, written, [keys["signal"]])

    def expect_speed(self):
        name, keys, written = self.number_window()
        written = {"signal": quoted(name), **written}
        found = self.expected(trains.speed, keys)
        self.figure(found, keys, written, Fraction(self.rng.choice((1, 10, 100))), 3, "Hz")
        return Claim("expect", "speed", keys, written, [name])

    def expect_phase(self):
        of, reference = self.rng.sample(list(LINES), 2) if self.rng.random() < 0.2 else self.rng.choice((("b1", "b0"), ("b3", "b2")))
        keys, written = {"of": of, "reference": reference}, {"of": quoted(of), "reference": quoted(reference)}
        begin = self.since(keys, written)
        self.until(keys, written, begin, 5 * MS)
        middle = Fraction(self.rng.choice((90, 0, 45, 180, -90)))
        cycles = self.placement.edges(reference, "rises", (begin, 0), (LAST, 0))
        others = [time for time in self.placement.edges(of, "rises", (begin, 0), (LAST, 0)) if cycles and time >= cycles[0]]
        if len(cycles) > 1 and others and self.rng.random() < 0.8:
            turn = cycles[1] - cycles[0]
            middle = min(rounded(Fraction((others[0] - cycles[0]) % turn * 360, turn), 1), Fraction(270))
        width = Fraction(self.rng.choice((0, 5, 10, 45, 90)))
        keys["is"] = Limits(middle - width, middle + width, self.rng.choice(("range", "tolerance")))
        written["is"] = quoted(keys["is"].written(text, "deg"))
        if self.rng.random() < 0.3:
            keys["edge"] = self.rng.choice(("rises", "falls"))
            written["edge"] = quoted(keys["edge"])
        return Claim("expect", "phase", keys, written, [of, reference])

    def expect_position(self):
        keys, written, names = self.train_keys()
        begin = self.since(keys, written)
        self.until(keys, written, begin)
        found = self.expected(trains.position, keys)
        found = Fraction(found) if found is not None else Fraction(2)
        limits = self.around(found, Fraction(1), Fraction(1))
        keys["is"] = limits
        if limits.low is not None and limits.low == limits.high:
            written["is"] = f'"{text(limits.low)} .. {text(limits.high)}"'
        else:
            for key, limit in (("min", limits.low), ("max", limits.high)):
                if limit is not None:
                    written[key] = toml(limit, "LINT")
        return Claim("expect", "position", keys, written, names)

    def expect_profile(self):
        name = self.pick(LINES)
        keys, written = {"signal": name}, {"signal": quoted(name)}
        begin, points = self.shape(keys, written, name)
        self.until(keys, written, begin, 5 * MS)
        written["points"] = f"[{points}]"
        share = self.rng.choice((1, 5, 20, 50))
        if self.rng.random() < 0.5:
            keys["tolerance"] = max(rate for _, rate in keys["points"]) * Fraction(share, 100)
            written["tolerance"] = f'"{share} %"'
        else:
            keys["tolerance"] = Fraction(share)
            written["tolerance"] = f'"{share} Hz"'
        if self.rng.random() < 0.3:
            if self.rng.random() < 0.5:
                keys["over"], written["over"] = 10 * MS, '"10 ms"'
            else:
                keys["shape-within"], written["within"] = MS, '"1 ms"'
        return Claim("expect", "profile", keys, written, [name])
