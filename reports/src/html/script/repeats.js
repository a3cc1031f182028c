// The figures of a repeated case, turn by turn.

// The turns of each repeated case, by the case's name.
const turns = (run) => {
  const groups = new Map((run.repeated ?? []).map((one) => [one.case, { ...one, records: [] }]));
  for (const record of run.cases) if (record.turn) groups.get(record.name.replace(/#\d+$/, ""))?.records.push(record);
  return [...groups.values()];
};

// A figure of all turns: its statistics are in the record, its values in those of the turns.
const series = (figure, records) => {
  const isClaim = figure.of === "margin";
  const unit = figure.unit ?? "";
  const value = (one) => (isClaim ? one.margin && number(one.margin.value) : one.value && (number(one.value[0]) + number(one.value[1])) / 2);
  const unitOf = (one) => (isClaim ? one.margin?.unit : one.unit) ?? "";
  const isIt = (one) => one.name === figure.name && (one.line ?? 0) === (figure.line ?? 0) && unitOf(one) === unit;
  const taken = records.map((record) => (isClaim ? record.claims : record.measurements).find(isIt));
  const found = taken.map((one) => (one && given(value(one)) ? { value: value(one), word: one.verdict } : null));
  if (isClaim) return { name: `margin of ${figure.name}`, unit, found, min: 0, max: null, limits: `≥ 0 ${unit === "ns" ? "s" : unit}`, sums: figure.statistics };
  const first = taken.find(Boolean);
  const [min, max] = first ? bounds(first) : [null, null];
  return { name: figure.name, unit, found, min, max, limits: first ? limits(first) : "", sums: figure.statistics };
};

// Every turn as a dot from left to right, between the limits.
const strip = ({ found, min, max, name }) => {
  const taken = found.map((f, turn) => f && { ...f, turn }).filter((f) => f && Number.isFinite(f.value));
  const values = [...taken.map((f) => f.value), ...[min, max].filter(given)];
  const [low, high] = [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
  const y = (value) => (high > low ? 40 - (34 * (value - low)) / (high - low) : 23);
  const x = (turn) => 4 + (252 * turn) / Math.max(found.length - 1, 1);
  const marks = [min, max].filter(given).map((value) => line("limitmark", 0, y(value), 260, y(value)));
  const allowed = given(min) || given(max) ? box("allowed", 0, given(max) ? y(max) : 2, 260, (given(min) ? y(min) : 44) - (given(max) ? y(max) : 2)) : null;
  const dots = taken.map((f) => s("circle", { class: `taken v-${f.word}`, cx: px(x(f.turn)), cy: px(y(f.value)), r: found.length > 80 ? 1.5 : 2.5 }));
  return s("svg", { class: "strip", viewBox: "0 0 260 46", width: 260, height: 46, role: "img", "aria-label": `${name}, turn by turn` }, allowed, marks, dots);
};

const repeats = (run) => {
  const groups = turns(run);
  if (!groups.length) return null;
  const sections = groups.map(({ case: name, passed, records, figures }) => {
    const rows = (figures ?? []).map((figure) => series(figure, records)).map((one) => {
      const sums = one.sums;
      const short = (value) => (one.unit === "ns" ? rounded(value, 6) : figure(Number(value.toPrecision(6)), one.unit));
      const cells = [String(sums.count), short(sums.min), short(sums.mean), short(sums.max), short(sums.spread), short(sums.drift)];
      return h("tr", {}, h("td", {}, one.name), cells.map((text) => h("td", { class: "n" }, text)), h("td", {}, one.limits), h("td", {}, strip(one)));
    });
    return h(
      "details",
      { class: "folder", open: groups.length <= 20 },
      h("summary", {}, h("b", {}, name), h("span", { class: `count v-${worst(records.map((record) => record.word))}` }, `${passed} of ${plural(records.length, "turn")} passed`)),
      rows.length > 0
        ? table("repeats", [["Figure"], ["Turns", true], ["Least", true], ["Mean", true], ["Greatest", true], ["Spread", true], ["Drift per turn", true], ["Limits"], ["Turn by turn"]], rows)
        : h("p", { class: "soft" }, "No figures to compare."),
      h("p", { class: "proofs" }, records.filter((record) => record.word !== "pass").slice(0, 20).map((record) => h("a", { class: "proof", href: link({ case: record.name }) }, h("span", { class: `mark v-${record.word}` }, SIGNS[record.word]), " ", record.name))),
    );
  });
  return h("section", {}, heading("h2", "Repeats"), h("p", { class: "lead" }, "Spread is the standard deviation of the sample; drift the slope of the line of least squares."), sections);
};
