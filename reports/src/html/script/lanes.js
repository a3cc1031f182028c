// Signals over time: levels, named states, numbers.
const DENSE = 1.6; // changes closer together than this are drawn as one block, in pixels
const UNCERTAIN = 1.5; // intervals narrower than this are drawn as instants, in pixels
const HEIGHT = { digital: 22, state: 22, analog: 62 };

const isNumber = (value) => typeof value === "number";
// A whole number beyond 53 bits is a text of its digits.
const isDigits = (value) => typeof value === "string" && /^-?\d+$/.test(value);

// What a value is called: a label of a state, or the number.
const named = (lane, value) => {
  if (value === "z") return "high impedance";
  if (!isNumber(value)) return isDigits(value) ? value : "unknown";
  if (lane.kind === "digital") return value === 0 ? "FALSE" : "TRUE";
  const label = lane.labels.find(([n]) => n === value);
  return label ? label[1] : figure(value, lane.unit);
};

// The stretches of a lane from left to right: plain ones of a value, with both ends of the interval in which they
// begin; and dense ones, of many changes too close together to be told apart.
const parts = (axis, lane) => {
  const [left, right] = [axis.first.x0, axis.last.x1];
  const out = [];
  let value;
  let from = [left, left];
  const close = (until, last) => {
    const narrow = until - from[0] < DENSE && !last;
    const before = out.at(-1);
    if (narrow && before?.dense) before.until = until;
    else if (narrow && until > from[0]) out.push({ dense: true, from, until });
    else if (until > from[0]) out.push({ from, until, value });
  };
  for (const { at, value: next } of lane.points) {
    if (at[1] < axis.first.t0) {
      value = next;
      continue;
    }
    if (at[0] > axis.last.t1) break;
    if (next === value) continue;
    const where = at.map((t) => Math.max(axis.x(t), from[0]));
    close(where[0], false);
    [from, value] = [where, next];
  }
  const ends = known(lane);
  const end = given(ends) && ends < axis.last.t1 ? Math.max(axis.x(ends), from[0]) : right;
  close(end, true);
  if (end < right) {
    // Nothing is said of what comes after the excerpt.
    from = [end, end];
    value = undefined;
    close(right, true);
  }
  return out;
};

const box = (kind, x, y, width, height) => s("rect", { class: kind, x: px(x), y: px(y), width: px(Math.max(width, 0)), height: px(Math.max(height, 0)) });
const line = (kind, x1, y1, x2, y2) => s("line", { class: kind, x1: px(x1), y1: px(y1), x2: px(x2), y2: px(y2) });
const label = (kind, x, y, text) => s("text", { class: kind, x: px(x), y: px(y) }, text);

// How wide a text is in the small font of the drawings, roughly, and as much of it as fits.
const textWidth = (text) => 6.4 * [...String(text)].length;
const fit = (text, width) => {
  // A width that was made for the text may come out short of it by rounding.
  const room = Math.max(Math.floor(width / 6.4 + 1e-6), 0);
  const characters = [...String(text)];
  return characters.length <= room ? text : characters.slice(0, Math.max(room - 1, 0)).join("") + "…";
};

// The hatched part of an edge whose instant is known to within an interval only.
const uncertain = (part, y, height) => {
  const end = Math.min(part.from[1], part.until);
  return end - part.from[0] >= UNCERTAIN ? box("uncertain", part.from[0], y, end - part.from[0], height) : null;
};

const drawDigital = (axis, lane, y) => {
  const [high, low, mid] = [y + 2, y + 20, y + 11];
  const out = [];
  let [wire, floating, pen] = ["", "", null];
  for (const part of parts(axis, lane)) {
    const begin = Math.min(part.dense ? part.from[0] : part.from[1], part.until);
    if (part.dense) {
      out.push(box("dense", begin, high, part.until - begin, 18));
      pen = null;
      continue;
    }
    out.push(uncertain(part, high, 18));
    if (part.value === "z") {
      floating += `M${px(begin)} ${mid}H${px(part.until)}`;
      pen = mid;
    } else if (!isNumber(part.value)) {
      out.push(box("unknown", begin, high, part.until - begin, 18));
      pen = null;
    } else {
      const level = part.value === 0 ? low : high;
      if (level === high) out.push(box("on", begin, high, part.until - begin, 18));
      wire += pen === null ? `M${px(begin)} ${level}H${px(part.until)}` : `M${px(part.from[0])} ${pen}L${px(begin)} ${level}H${px(part.until)}`;
      pen = level;
    }
  }
  if (floating) out.push(s("path", { class: "floating", d: floating }));
  if (wire) out.push(s("path", { class: "wire", d: wire }));
  return out;
};

const drawState = (axis, lane, y) => {
  const [top, bottom, mid] = [y + 2, y + 20, y + 11];
  const out = [];
  for (const part of parts(axis, lane)) {
    const begin = Math.min(part.dense ? part.from[0] : part.from[1], part.until);
    const width = part.until - begin;
    if (part.dense) {
      out.push(box("dense", begin, top, width, 18));
      continue;
    }
    out.push(uncertain(part, top, 18));
    if (!isNumber(part.value) && !isDigits(part.value) && part.value !== "z") {
      out.push(box("unknown", begin, top, width, 18));
      continue;
    }
    const slant = Math.min(Math.max(width / 2, 0), 3);
    const [x0, x1, x2, x3] = [begin, begin + slant, part.until - slant, part.until].map(px);
    const text = named(lane, part.value);
    out.push(s("path", { class: "box", d: `M${x0} ${mid}L${x1} ${top}H${x2}L${x3} ${mid}L${x2} ${bottom}H${x1}Z` }, s("title", {}, text)));
    if (width - 8 >= Math.min(textWidth(text), 28)) out.push(label("label mid", begin + width / 2, mid + 4, fit(text, width - 8)));
  }
  return out;
};

const drawAnalog = (axis, lane, y, band) => {
  const [top, bottom, left, right] = [y + 6, y + 56, axis.first.x0, axis.last.x1];
  const inside = lane.points.filter((p) => p.at[1] >= axis.first.t0 && p.at[0] <= axis.last.t1);
  const before = lane.points.findLast((p) => p.at[1] < axis.first.t0);
  const numbers = [before, ...inside].filter((p) => p && isNumber(p.value)).map((p) => p.value);
  if (!numbers.length) return [box("unknown", left, top, right - left, bottom - top)];
  const edges = band.flatMap((b) => [b.min, b.max]).filter(given).map(number).filter(Number.isFinite);
  const low = numbers.concat(edges).reduce((a, b) => Math.min(a, b));
  const high = numbers.concat(edges).reduce((a, b) => Math.max(a, b));
  const scale = (n) => (high > low ? bottom - ((bottom - top) * (n - low)) / (high - low) : (top + bottom) / 2);
  const out = [line("grid", left, top, right, top), line("grid", left, bottom, right, bottom)];
  if (high > low) {
    out.push(label("small end", left - 6, top + 6, figure(high, lane.unit)), label("small end", left - 6, bottom + 2, figure(low, lane.unit)));
  } else out.push(label("small end", left - 6, (top + bottom) / 2 + 4, figure(low, lane.unit)));
  for (const { min, max, from, until, word } of band) {
    // The allowed values of a claim, over the time in which it looks.
    if (!axis.overlaps(from, until)) continue;
    const [x0, x1] = [axis.x(from), axis.x(until)];
    const [y0, y1] = [given(max) ? scale(number(max)) : top - 4, given(min) ? scale(number(min)) : bottom + 4];
    out.push(box(`limit v-${word}`, x0, y0, x1 - x0, Math.max(y1 - y0, 1)));
    if (given(max)) out.push(line(`bound v-${word}`, x0, y0, x1, y0));
    if (given(min)) out.push(line(`bound v-${word}`, x0, y1, x1, y1));
  }
  // Recorded values hold until the next one: steps, not slopes.
  let path = "";
  let pen = before && isNumber(before.value) ? [left, scale(before.value)] : null;
  if (pen) path = `M${px(left)} ${px(pen[1])}`;
  for (const point of inside) {
    const x = axis.x(middle(point.at));
    const wide = axis.x(point.at[1]) - axis.x(point.at[0]);
    if (wide >= UNCERTAIN) out.push(box("uncertain", axis.x(point.at[0]), top, wide, bottom - top));
    if (isNumber(point.value)) {
      const to = scale(point.value);
      if (!pen) path += `M${px(x)} ${px(to)}`;
      else if (x - pen[0] >= 0.2 || Math.abs(to - pen[1]) >= 0.2) path += `H${px(x)}V${px(to)}`;
      else continue;
      pen = [x, to];
    } else if (pen) {
      path += `H${px(x)}`;
      pen = null;
    }
  }
  const ends = known(lane);
  const end = given(ends) && ends < axis.last.t1 ? axis.x(ends) : right;
  if (pen && pen[0] < end) path += `H${px(end)}`;
  out.push(s("path", { class: "curve", d: path }));
  if (end < right) out.push(box("unknown", end, top, right - end, bottom - top));
  return out;
};

const drawLane = (axis, lane, y, band) =>
  (lane.kind === "analog" ? drawAnalog : lane.kind === "state" ? drawState : drawDigital)(axis, lane, y, band);

// What a signal is at an instant: nothing before its first change and after its excerpt, "…" while it may be changing.
const valueAt = (lane, t) => {
  const ends = known(lane);
  if (given(ends) && t > ends) return "";
  const next = lane.points.findIndex((p) => p.at[1] > t);
  const point = lane.points.at(next < 0 ? -1 : next);
  if (next >= 0 && point.at[0] <= t) return "…";
  const current = next < 0 ? point : lane.points[next - 1];
  return current && next !== 0 ? named(lane, current.value) : "";
};
