// How verdicts, durations and figures are written: as in every other report of the rig.
const SIGNS = { none: "·", pass: "✓", inconclusive: "?", fail: "✗", error: "!", skipped: "–", "not-applicable": "–" };
const WORDS = { "not-applicable": "not applicable", none: "no verdict" };
// From the least to the greatest, as verdicts combine.
const ORDER = ["skipped", "not-applicable", "none", "pass", "inconclusive", "fail", "error"];
const bad = (word) => ORDER.indexOf(word) > ORDER.indexOf("pass");
const worst = (words) => words.reduce((a, b) => (ORDER.indexOf(b) > ORDER.indexOf(a) ? b : a), "none");

const badge = (word, text) =>
  h("span", { class: `badge v-${word}` }, h("span", { class: "sign", "aria-hidden": "true" }, SIGNS[word]), " ", text ?? WORDS[word] ?? word);

// A duration in nanoseconds, exact.
const span = (ns) => {
  if (ns === 0) return "0 s";
  const size = Math.abs(ns);
  const [scale, digits, unit] = size < 1e3 ? [1, 0, "ns"] : size < 1e6 ? [1e3, 3, "us"] : size < 1e9 ? [1e6, 6, "ms"] : [1e9, 9, "s"];
  const whole = Math.floor(size / scale);
  const part = Math.round(size - whole * scale);
  const decimals = part ? `.${String(part).padStart(digits, "0").replace(/0+$/, "")}` : "";
  return `${ns < 0 ? "-" : ""}${whole}${decimals} ${unit}`;
};

// A duration to so many significant digits, where the exact one would pretend.
const rounded = (ns, digits = 3) => span(Math.round(Number(ns.toPrecision(digits))));

// Nine digits, but all of a whole number.
const nine = (n) => (Number.isFinite(n) ? String(Number.isInteger(n) ? n : Number(n.toPrecision(9))).replace("e+", "e") : String(n));
const number = (value) => (typeof value === "number" ? value : { inf: Infinity, "-inf": -Infinity }[value] ?? NaN);

// A number in its unit; whole nanoseconds are shown as the duration that they are.
const figure = (value, unit) => {
  const n = number(value);
  if (unit === "ns" && Number.isInteger(n)) return span(n);
  return unit ? `${nine(n)} ${unit}` : nine(n);
};
const shown = (f) => (f ? figure(f.value, f.unit) : "");

const offset = (ns) => (ns < 0 ? span(ns) : `+${span(ns)}`);
// An instant or interval from the origin on: `+1.1002 s`, `+5.1 ms .. +5.3 ms`.
const relative = ([earliest, latest], origin) =>
  earliest === latest ? offset(earliest - origin) : `${offset(earliest - origin)} .. ${offset(latest - origin)}`;
const between = ([low, high]) => (low === high ? span(low) : `${span(low)} .. ${span(high)}`);

const measured = (m) => {
  if (!m.value) return "never taken";
  const [low, high] = m.value.map((end) => figure(end, m.unit));
  return low === high ? low : `${low} .. ${high}`;
};

const given = (value) => value !== null && value !== undefined;
const limits = (m) => {
  const limits = bareLimits(m);
  return limits && m.guard_band === "none" ? `${limits}, guard none` : limits;
};
const bareLimits = (m) => {
  if (given(m.nominal) && given(m.tolerance)) return `${figure(m.nominal, m.unit)} ± ${figure(m.tolerance, m.unit)}`;
  if (given(m.min) && given(m.max)) return `${figure(m.min, m.unit)} .. ${figure(m.max, m.unit)}`;
  if (given(m.min)) return `≥ ${figure(m.min, m.unit)}`;
  return given(m.max) ? `≤ ${figure(m.max, m.unit)}` : "";
};
// The limits of a measurement as numbers, whichever way they were given; null for none. Those of a nominal value are in the record as
// they were judged; only records of early rigs lack them.
const bounds = (m) =>
  given(m.nominal) && given(m.tolerance) && !given(m.min) && !given(m.max)
    ? [number(m.nominal) - number(m.tolerance), number(m.nominal) + number(m.tolerance)]
    : [given(m.min) ? number(m.min) : null, given(m.max) ? number(m.max) : null];

const middle = ([earliest, latest]) => earliest + Math.floor((latest - earliest) / 2);
