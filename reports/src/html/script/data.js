// The record of the run, as it is embedded: JSON, deflated, in base64. Fields have the names of the record; what is
// empty there is missing here, and the points of a lane are one list of numbers.
const unpack = async (text) => {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return JSON.parse(await new Response(plain).text());
};

const LISTS = ["claims", "measurements", "steps", "tasks", "log", "lanes", "proves", "parameters", "tags"];

// Three numbers for each change: distance of its earliest instant from that of the change before, width of its
// interval, value.
const points = (flat) => {
  const out = [];
  let at = 0;
  for (let i = 0; i + 2 < flat.length; i += 3) {
    at += flat[i];
    out.push({ at: [at, at + flat[i + 1]], value: flat[i + 2] });
  }
  return out;
};

// The last instant that a lane shows; nothing when it shows all to the end of the case.
const known = (lane) => {
  const cut = lane.truncated && lane.points.length ? [lane.points.at(-1).at[1]] : [];
  const ends = given(lane.until_ns) ? [...cut, lane.until_ns] : cut;
  return ends.length ? Math.min(...ends) : null;
};

const folder = (name) => {
  // Only what stands before the first `[` counts: the name of a row may hold slashes.
  const plan = name.split("[")[0];
  const at = plan.lastIndexOf("/");
  return at < 0 ? "" : name.slice(0, at);
};

const prepare = (run) => {
  run.cases ??= [];
  run.cases.forEach((record, place) => {
    for (const list of LISTS) record[list] ??= [];
    record.name ??= "";
    record.title ??= "";
    for (const check of [...record.claims, ...record.measurements]) check.name ??= "";
    for (const step of record.steps) step.id ??= "";
    record.place = place;
    record.folder = folder(record.name);
    record.word = record.status.is === "judged" ? record.verdict : record.status.is;
    record.why = (record.status.is === "judged" ? record.reason : record.status.reason) ?? "";
    record.checks = [...record.claims, ...record.measurements];
    record.words = [record.name, record.title, record.plan, record.why, ...record.proves, ...record.tags, ...record.parameters.map((p) => `${p.name} = ${p.value}`)].join("\n").toLowerCase();
  });
  return run;
};

// Lanes are unpacked when a case is looked at.
const lanes = (record) => {
  for (const lane of record.lanes) {
    if (!lane.points) {
      lane.points = points(lane.changes ?? []);
      lane.labels ??= [];
      lane.signal ??= "";
      lane.unit ??= "";
    }
  }
  return record.lanes;
};

// How near a check came to its limits: its margin as a part of the room that the limits leave, 1 in the middle of
// them; nothing where there is no margin or no room to compare it with.
const nearness = (check) => {
  const margin = check.margin;
  if (!margin) return null;
  if (check.window && margin.unit === "ns") {
    const { limit_from_ns: from, limit_until_ns: until } = check.window;
    if (!given(until)) return null;
    const room = until - (given(from) ? from : check.window.from_ns[0]);
    return room > 0 ? (2 * number(margin.value)) / room : null;
  }
  const [min, max] = "value" in check ? bounds(check) : [null, null];
  if (given(min) && given(max) && max > min) return (2 * number(margin.value)) / (max - min);
  return given(max) && !given(min) && max > 0 ? number(margin.value) / max : null;
};
