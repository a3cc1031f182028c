// What is drawn over the lanes: windows and limits of claims, deciding instants, steps, margins, measurements.

// Rows of labels that do not run into each other.
class Rows {
  constructor() {
    this.ends = [];
  }

  // The first of at most `most` rows with room from `x` on, which is then taken for `width`; -1 without room.
  place(x, width, most) {
    let row = this.ends.findIndex((end) => end <= x);
    if (row < 0) {
      if (this.ends.length >= most) return -1;
      row = this.ends.push(0) - 1;
    }
    this.ends[row] = x + width;
    return row;
  }
}

// The steps in view, and the anchors `start` and `end`.
const stepFlags = (record, axis, rows) => {
  const anchors = [{ id: "start", at: record.start_ns }, { id: "end", at: record.end_ns }];
  const steps = record.steps.filter((step) => step.at_ns && step.id !== "start" && step.id !== "end");
  return [...anchors, ...steps.map((step) => ({ id: step.id, what: step.what, at: middle(step.at_ns) }))]
    .filter(({ at }) => axis.shows(at))
    .sort((a, b) => a.at - b.at)
    .map(({ id, what, at }) => {
      const [x, width] = [axis.x(at), textWidth(id) + 14];
      // A label at the right edge stands to the left of its line.
      const back = x + width > axis.last.x1;
      return { x, back, id, what, row: rows.place(back ? x - width : x, width, 3) };
    });
};

const drawStep = (flag, top, bottom) => {
  const y = top + 16 * Math.max(flag.row, 0);
  const out = [line("step", flag.x, y + 3, flag.x, bottom), s("path", { class: "flag", d: `M${px(flag.x)} ${px(y + 3)}l7 4l-7 4Z` })];
  if (flag.row >= 0) {
    const text = flag.back ? label("label end", flag.x - 4, y + 11, flag.id) : label("label", flag.x + 10, y + 11, flag.id);
    if (flag.what) text.append(s("title", {}, flag.what));
    out.push(text);
  }
  return out;
};

// Shades the window of a claim and the limits in it.
const drawWindow = (axis, claim, top, height) => {
  const window = claim.window;
  if (!window) return [];
  const { from_ns: from, until_ns: until, limit_from_ns: low, limit_until_ns: high } = window;
  const limited = given(low) || given(high);
  if (!axis.overlaps(from[0], until[1]) && !limited) return [];
  const word = `v-${claim.verdict}`;
  const [a, b] = [from.map((t) => axis.x(t)), until.map((t) => axis.x(t))];
  const out = [box(`window ${word}`, a[0], top, b[1] - a[0], height)];
  for (const [x0, x1] of [a, b]) if (x1 - x0 >= UNCERTAIN) out.push(box("uncertain", x0, top, x1 - x0, height));
  if (limited) {
    const [x0, x1] = [given(low) ? axis.x(low) : a[0], given(high) ? axis.x(high) : b[1]];
    out.push(box(`limit ${word}`, x0, top, Math.max(x1 - x0, 1), height));
    for (const t of [low, high]) if (given(t) && axis.shows(t)) out.push(line(`bound ${word}`, axis.x(t), top, axis.x(t), top + height));
  }
  return out;
};

// Where the number of a claim stands: at its limits, else where it was decided, else where its window begins.
const tagPlace = (axis, claim) => {
  const window = claim.window;
  const limit = window?.limit_from_ns ?? window?.limit_until_ns;
  if (given(limit) && axis.shows(limit)) return axis.x(limit);
  if (claim.deciding_ns && axis.shows(middle(claim.deciding_ns))) return axis.x(middle(claim.deciding_ns));
  return window && axis.overlaps(window.from_ns[0], window.until_ns[1]) ? axis.x(middle(window.from_ns)) : null;
};

const tagWidth = (n) => textWidth(`${n} x`) + 8;
const drawTag = (n, claim, x, y, press) =>
  s(
    "g",
    { class: `tagged v-${claim.verdict}`, click: press },
    s("rect", { class: "tag", x: px(x), y: px(y), width: px(tagWidth(n)), height: 14, rx: 3 }),
    label("tagtext mid", x + tagWidth(n) / 2, y + 10.7, `${n} ${SIGNS[claim.verdict]}`),
    s("title", {}, `${n}: ${claim.name ?? ""}`),
  );

// The instants at which claims that did not pass were decided, and that of a chosen claim.
const decidingFlags = (record, axis, rows, chosen) =>
  record.claims
    .map((claim, at) => ({ claim, n: at + 1 }))
    .filter(({ claim }) => (bad(claim.verdict) || claim === chosen) && claim.deciding_ns && axis.shows(middle(claim.deciding_ns)))
    .sort((a, b) => middle(a.claim.deciding_ns) - middle(b.claim.deciding_ns))
    .map(({ claim, n }) => {
      const text = `${n} ${SIGNS[claim.verdict]}  ${relative(claim.deciding_ns, record.start_ns)}`;
      const [x, width] = [axis.x(middle(claim.deciding_ns)), textWidth(text) + 12];
      const left = Math.max(Math.min(x - width / 2, axis.last.x1 - width), axis.first.x0);
      return { claim, text, x, left, width, row: rows.place(left, width, 4) };
    });

const drawDeciding = (axis, flag, top, lanesTop, bottom) => {
  const word = `v-${flag.claim.verdict}`;
  const out = [];
  const [a, b] = flag.claim.deciding_ns.map((t) => axis.x(t));
  if (b - a >= UNCERTAIN) out.push(box("uncertain", a, lanesTop, b - a, bottom - lanesTop));
  const y = top + 18 * Math.max(flag.row, 0);
  out.push(line(`deciding ${word}`, flag.x, y + 14, flag.x, bottom));
  if (flag.row >= 0) {
    out.push(s("rect", { class: `tag ${word}`, x: px(flag.left), y: px(y), width: px(flag.width), height: 15, rx: 3 }));
    out.push(label(`tagtext mid ${word}`, flag.left + flag.width / 2, y + 11.3, flag.text));
  }
  return out;
};

// The margin of a claim that had to happen in time: from the worse end of the instant that decided to the limit that
// is nearest to it. The second instant is the limit.
const marginOf = (claim) => {
  const { limit_from_ns: low, limit_until_ns: high } = claim.window ?? {};
  if (!claim.deciding_ns || (!given(low) && !given(high))) return null;
  const [early, late] = claim.deciding_ns;
  const room = [given(low) ? { left: early - low, from: early, to: low } : null, given(high) ? { left: high - late, from: late, to: high } : null];
  return room.filter(Boolean).reduce((a, b) => (b.left < a.left ? b : a));
};

// Distances worth a line of their own below the lanes: measurements between two instants, and margins.
const dimensions = (record, chosen) => {
  const margins = record.claims.filter((claim) => bad(claim.verdict) || claim === chosen).map((claim) => {
    const margin = marginOf(claim);
    return margin && { from: margin.from, to: margin.to, word: claim.verdict, text: `margin ${span(margin.left)}` };
  });
  const taken = record.measurements.filter((m) => m.from_ns && m.to_ns && (!chosen || m === chosen || chosen.window !== undefined)).map((m) => ({
    from: middle(m.from_ns),
    to: middle(m.to_ns),
    word: m.verdict,
    text: `${SIGNS[m.verdict]} ${m.name} = ${measured(m)}`,
  }));
  return [...margins.filter(Boolean), ...taken].filter(({ from, to }) => from !== to).slice(0, 8);
};

// Draws them from `top` down; returns what was drawn and the height used.
const drawDimensions = (list, axis, top) => {
  const out = [];
  let y = top;
  for (const { from, to, word, text } of list) {
    const [early, late] = [Math.min(from, to), Math.max(from, to)];
    if (!axis.overlaps(early, late)) continue;
    const [a, b, mid] = [axis.x(early), axis.x(late), y + 9];
    out.push(line(`dimension v-${word}`, a, mid, b, mid));
    out.push(s("path", { class: `dimension v-${word}`, d: `M${px(a)} ${px(mid - 4)}V${px(mid + 4)}M${px(b)} ${px(mid - 4)}V${px(mid + 4)}` }));
    if (b + textWidth(text) + 8 < axis.last.x1) out.push(label("label", b + 6, mid + 4, text));
    else if (a - textWidth(text) - 8 > axis.first.x0) out.push(label("label end", a - 6, mid + 4, text));
    else {
      const half = textWidth(text) / 2;
      out.push(label("label mid", Math.min(Math.max((a + b) / 2, axis.first.x0 + half), axis.last.x1 - half), mid + 15, text));
      y += 13;
    }
    y += 18;
  }
  return [out, y - top];
};

// Blank strips over the lanes where the axis is broken, with the time that is left out below the ticks.
const drawBreaks = (axis, top, bottom) => {
  const out = [];
  axis.pieces.slice(1).forEach((piece, at) => {
    const [a, b] = [axis.pieces[at].x1, piece.x0];
    out.push(box("break", a + 2, top, b - a - 4, bottom - top));
    for (const x of [a + 2, b - 2]) {
      let d = `M${px(x)} ${px(top)}`;
      for (let [y, side] = [top, 4]; y < bottom; y += 10, side = -side) {
        const step = Math.min(bottom - y, 10);
        d += `q${side} ${px(step / 2)} 0 ${px(step)}`;
      }
      out.push(s("path", { class: "wave", d }));
    }
    out.push(label("small mid", (a + b) / 2, bottom + 28, `${rounded(piece.t0 - axis.pieces[at].t1)} left out`));
  });
  return out;
};
