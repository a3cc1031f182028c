"""Random measurements on a scene, with limits around what it is made to do, or without."""

from fractions import Fraction

import trains
from drawing import BOOLS, NUMBERS, Claim, Drawing, in_unit, instant, quoted, write_limits
from figures import MS
from scenes import CHANNELS, LINES
from trains import MISSING


class Measurements(Drawing):
    """Makes measurements of every kind."""

    def measured(self, verb, keys, written, names, unit, spread, places, found=None, least=None):
        """A measurement with limits around what is expected, or without."""
        if self.rng.random() < 0.85:
            figure = found if found is not None else self.expected(trains.MEASURES[verb], keys)
            if figure is None or figure == MISSING or isinstance(figure, bool):
                figure = Fraction(self.rng.randrange(1, 20))
            figure = figure if isinstance(figure, Fraction) else Fraction(float(figure)) if isinstance(figure, trains.Rooted) else Fraction(figure)
            grid = Fraction(1, 10 ** places)
            if verb in ("speed", "window") and abs(figure) > 10 ** 12:
                # A large figure that is worked out is a float: twelve digits are enough to ask for.
                grid = Fraction(10) ** (len(str(abs(int(figure)))) - 12)
            limits = self.around(figure, max(spread, grid), grid, least)
            keys["limits"] = limits
            if limits.style == "tolerance" and limits.low is not None and limits.high is not None:
                middle = (limits.low + limits.high) / 2
                written["nominal"] = in_unit(middle, unit)
                written["tolerance"] = in_unit(limits.high - middle, unit)
            else:
                for key, limit in (("min", limits.low), ("max", limits.high)):
                    if limit is not None:
                        written[key] = in_unit(limit, unit)
        return Claim("measure", verb, keys, written, names)

    def measure_time(self):
        keys, written = {}, {}
        begin = self.since(keys, written)
        if self.rng.random() < 0.3:
            marks = [(name, 0) for name, time in self.scene.marks.items() if time > begin]
            if not marks or keys.get("from", ("start", 0))[0] not in self.placement.steps:
                return None
            keys["to"] = self.rng.choice(marks)
            written["to"] = instant(keys["to"])
            return self.measured("time", keys, written, [], "ns", Fraction(MS), 0, least=Fraction(0))
        keys["signal"], keys["edge"] = self.pick(BOOLS), self.rng.choice(("rises", "falls", "changes"))
        written["to"] = f'{{ signal = "{keys["signal"]}", edge = "{keys["edge"]}" }}'
        return self.measured("time", keys, written, [keys["signal"]], "ns", Fraction(MS), 0, least=Fraction(0))

    def measure_value(self):
        name = self.pick(NUMBERS)
        kind = self.scene.types()[name]
        keys, written = {"signal": name}, {"value-of": quoted(name)}
        self.when(keys, written)
        value = self.rng.choice(self.placement.tracks[name].values)
        if self.rng.random() < 0.85:
            keys["limits"] = limits = self.limits(value, kind)
            write_limits(limits, kind, written, "limits")
        return Claim("measure", "value", keys, written, [name])

    def measure_window(self):
        name = self.pick([*LINES, *CHANNELS, "v_lreal", "v_int", "count"])
        take = self.rng.choice(("min", "max", "span", "mean", "rms"))
        if name in LINES:
            take = "mean"
        keys, written = {"signal": name, "take": take}, {"value-of": quoted(name), "take": quoted(take)}
        begin = self.since(keys, written)
        self.until(keys, written, begin)
        unit = "bar" if name in CHANNELS else ""
        # Of a large number with its mean there is no decimal near enough.
        return self.measured("window", keys, written, [name], unit, Fraction(1, 10) if name not in ("count", "v_int") else Fraction(1),
                             3 if name not in ("count", "v_int") else 0)

    def measure_frequency(self):
        keys, written = self.cycles(key="frequency-of", measure=True)
        return self.measured("frequency", keys, written, [keys["signal"]], "Hz", Fraction(1), 3, least=Fraction(0))

    def measure_duty(self):
        keys, written = self.cycles(key="duty-of", measure=True)
        return self.measured("duty", keys, written, [keys["signal"]], "%", Fraction(1), 3, least=Fraction(0))

    def measure_period(self):
        keys, written = self.cycles(key="period-of", measure=True)
        if self.rng.random() < 0.7:
            keys["take"] = self.rng.choice(("mean", "min", "max", "span"))
            written["take"] = quoted(keys["take"])
        return self.measured("period", keys, written, [keys["signal"]], "ns", Fraction(MS), 0, least=Fraction(0))

    def measure_width(self):
        keys, written = self.cycles(key="width-of", measure=True)
        if self.rng.random() < 0.5:
            keys["level"] = self.rng.choice(("high", "low"))
            written["level"] = quoted(keys["level"])
        if self.rng.random() < 0.7:
            keys["take"] = self.rng.choice(("first", "mean", "min", "max", "span"))
            written["take"] = quoted(keys["take"])
        return self.measured("width", keys, written, [keys["signal"]], "ns", Fraction(MS), 0, least=Fraction(0))

    def measure_speed(self):
        name, keys, written = self.number_window()
        written = {"speed-of": quoted(name), **written}
        return self.measured("speed", keys, written, [name], "Hz", Fraction(1), 3)

    def measure_jitter(self):
        keys, written = self.cycles(key="jitter-of", measure=True)
        self.jitter_keys(keys, written)
        return self.measured("jitter", keys, written, [keys["signal"]], "ns", Fraction(1000), 0, least=Fraction(0))

    def measure_position(self):
        keys, train, names = self.train_keys()
        written = {"position-of": f"{{ {', '.join(f'{key} = {value}' for key, value in train.items())} }}"}
        begin = self.since(keys, written)
        self.until(keys, written, begin)
        return self.measured("position", keys, written, names, "", Fraction(1), 0)

    def measure_profile(self):
        name = self.pick(LINES)
        keys, written = {"signal": name}, {"profile-of": ""}
        begin, points = self.shape(keys, written, name)
        self.until(keys, written, begin, 5 * MS)
        written["profile-of"] = f'{{ signal = "{name}", points = [{points}] }}'
        return self.measured("profile", keys, written, [name], "Hz", Fraction(1), 3, found=Fraction(10))
