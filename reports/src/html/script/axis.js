// The time axis: which stretches of time are drawn, and where.
//
// A diagram first shows the instants that the claims speak of. Where they lie in groups far apart (a step, and 100 ms
// later an edge that has to fall into 0.3 ms) the axis is broken between the groups, so that the small distances can
// be seen. Zooming goes on with a single stretch.
const BREAK = 34; // width of a break, in pixels
const LEGIBLE = 18; // distances narrower than this ask for a break elsewhere
const FAR = 4; // a gap is broken when it is this many times all others together
const BREAKS = 2; // the most breaks of one axis

class Axis {
  // Stretches from left to right, each { t0, t1, x0, x1 }.
  constructor(pieces) {
    this.pieces = pieces;
    this.first = pieces[0];
    this.last = pieces.at(-1);
  }

  static linear(t0, t1, left, right) {
    return new Axis([{ t0, t1: Math.max(t1, t0 + 1), x0: left, x1: right }]);
  }

  // Where an instant is drawn: in a break somewhere within the break, outside at the nearest end.
  x(t) {
    let before = null;
    for (const piece of this.pieces) {
      if (t < piece.t0) return before ? place(t, before.t1, before.x1, piece.t0, piece.x0) : piece.x0;
      if (t <= piece.t1) return place(t, piece.t0, piece.x0, piece.t1, piece.x1);
      before = piece;
    }
    return this.last.x1;
  }

  // The instant at a place; the end of the nearest stretch inside a break.
  t(x) {
    const piece = this.pieces.find((p) => x <= p.x1) ?? this.last;
    const part = (Math.max(x, piece.x0) - piece.x0) / (piece.x1 - piece.x0);
    return piece.t0 + Math.round((piece.t1 - piece.t0) * Math.min(part, 1));
  }

  // Nanoseconds of a pixel at a place.
  scale(x) {
    const piece = this.pieces.find((p) => x <= p.x1) ?? this.last;
    return (piece.t1 - piece.t0) / (piece.x1 - piece.x0);
  }

  shows(t) {
    return this.pieces.some((p) => p.t0 <= t && t <= p.t1);
  }

  overlaps(from, until) {
    return from <= this.last.t1 && until >= this.first.t0;
  }
}

const place = (t, t0, x0, t1, x1) => x0 + (x1 - x0) * Math.min(Math.max((t - t0) / Math.max(t1 - t0, 1), 0), 1);

// From the first to the last instant that a case knows of.
const extent = (record) => {
  let low = Math.min(record.start_ns, 0);
  let high = Math.max(record.end_ns, record.duration_ns);
  for (const lane of record.lanes) {
    if (!lane.points.length) continue;
    low = Math.min(low, lane.points[0].at[0]);
    high = Math.max(high, lane.points.at(-1).at[1]);
  }
  // No further than the excerpts show, where they end early.
  const ends = record.lanes.map((lane) => lane.until_ns).filter(given);
  if (ends.length) high = Math.min(high, ...ends);
  return [low, Math.max(high, low + 1)];
};

const claimed = (claim) => {
  const window = claim.window;
  return [
    ...(claim.deciding_ns ? [middle(claim.deciding_ns)] : []),
    ...(window ? [window.limit_from_ns, window.limit_until_ns, middle(window.from_ns), middle(window.until_ns)].filter(given) : []),
  ];
};
const taken = (m) => [m.from_ns, m.to_ns].filter(given).map(middle);

// The instants that the claims and measurements speak of; of those without a pass where there are any, so that a
// failure is what the diagram shows; of one claim alone where one is chosen.
const instants = (record, chosen) => {
  const trouble = record.checks.some((check) => bad(check.verdict));
  const wanted = (check) => (chosen ? check === chosen : !trouble || bad(check.verdict));
  // The ends of the case are where windows end that say nothing of a particular instant.
  const inside = (t) => t > record.start_ns && t < record.end_ns;
  const out = [...record.claims.filter(wanted).flatMap(claimed), ...record.measurements.filter(wanted).flatMap(taken)].filter(inside);
  const steps = record.steps.filter((step) => step.at_ns).map((step) => middle(step.at_ns)).filter(inside);
  if (chosen || trouble) {
    // The step that led there.
    const first = Math.min(...out);
    const led = steps.filter((t) => t <= first);
    if (out.length && led.length) out.push(Math.max(...led));
  } else out.push(...steps);
  if (!out.length) out.push(record.start_ns, record.end_ns);
  return [...new Set(out)].sort((a, b) => a - b);
};

const groups = (list, width) => {
  const out = [list];
  for (let n = 0; n < BREAKS; n += 1) {
    const gaps = out.flatMap((group, where) => group.slice(1).map((t, at) => ({ gap: t - group[at], where, at: at + 1 })));
    if (!gaps.length) break;
    const largest = gaps.reduce((a, b) => (b.gap >= a.gap ? b : a));
    const sum = gaps.reduce((total, { gap }) => total + gap, 0);
    const least = Math.min(...gaps.map(({ gap }) => gap));
    const rest = sum - largest.gap;
    if (rest === 0 || least * width >= LEGIBLE * sum || largest.gap / FAR < rest) break;
    out.splice(largest.where + 1, 0, out[largest.where].splice(largest.at));
  }
  return out;
};

// Each group with room around it and around the intervals of its instants; groups that touch become one.
const stretches = (list, intervals, [low, high]) => {
  const widest = Math.max(...list.map((group) => group.at(-1) - group[0]));
  const alone = widest > 0 ? Math.floor(widest / 3) : Math.max((high - low) / 20, 1_000);
  const out = [];
  for (const group of list) {
    let [first, last] = [group[0], group.at(-1)];
    for (const interval of intervals.filter((i) => group.includes(middle(i)))) {
      [first, last] = [Math.min(first, interval[0]), Math.max(last, interval[1])];
    }
    const room = Math.round(last > first ? Math.max((last - first) / 7, 1) : Math.max(alone, 1));
    const t0 = Math.max(first - room, Math.min(low, first));
    const t1 = Math.max(Math.min(last + room, Math.max(high, last)), t0 + 1);
    const before = out.at(-1);
    if (before && t0 <= before.t1 + room) {
      before.t1 = Math.max(before.t1, t1);
      before.n += group.length;
    } else out.push({ t0, t1, n: group.length });
  }
  return out;
};

// The axis that a case begins with.
const claimsAxis = (record, chosen, left, right) => {
  const intervals = record.checks.flatMap((check) => [check.deciding_ns, check.from_ns, check.to_ns]).filter((at) => at && at[0] < at[1]);
  const parts = stretches(groups(instants(record, chosen), right - left), intervals, extent(record));
  const weight = (part) => 1 + Math.min(part.n, 4);
  const total = parts.reduce((sum, part) => sum + weight(part), 0);
  const room = right - left - BREAK * (parts.length - 1);
  let x = left;
  return new Axis(
    parts.map((part) => {
      const piece = { t0: part.t0, t1: part.t1, x0: x, x1: x + (room * weight(part)) / total };
      x = piece.x1 + BREAK;
      return piece;
    }),
  );
};

// The unit of tick labels: small enough for short decimals, large enough for few digits.
const tickUnit = (step, size) => {
  if (size < 1e3) return [1, "ns"];
  if (step >= 1e8 || size >= 1e10) return [1e9, "s"];
  if (step >= 1e4 || size >= 1e8) return [1e6, "ms"];
  if (step >= 10 || size >= 1e5) return [1e3, "us"];
  return [1, "ns"];
};

// Ticks of a stretch at round distances from the origin.
const ticks = (piece, origin) => {
  const wanted = Math.max((piece.x1 - piece.x0) / 110, 1);
  let step = 1;
  while (step * wanted < piece.t1 - piece.t0) step = String(step)[0] === "2" ? (step / 2) * 5 : step * 2;
  const [low, high] = [piece.t0 - origin, piece.t1 - origin];
  const [scale, unit] = tickUnit(step, Math.max(Math.abs(low), Math.abs(high)));
  let decimals = 0;
  while (decimals < 9 && (step * 10 ** decimals) % scale !== 0) decimals += 1;
  const out = [];
  for (let at = Math.ceil(low / step) * step; at <= high && out.length < 40; at += step) {
    out.push({ x: place(at + origin, piece.t0, piece.x0, piece.t1, piece.x1), label: `${(at / scale).toFixed(decimals)} ${unit}` });
  }
  return out;
};
