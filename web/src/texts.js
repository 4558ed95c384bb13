import { unitOf } from "./columns.js";
import { measured, short } from "./format.js";

/** What the summary's numbers are measured in: keys, whatever they are part of. The rest are pure numbers. */
const KINDS = {
  dx: "length", domain: "length", centroid: "length", lower: "length", upper: "length", deflection: "length",
  deepest_overlap: "length", frame_interval: "time", simulated_seconds: "time", wall_seconds: "time", max_speed: "speed",
  velocity: "speed", max_divergence: "rate", volume: "volume", target_volume: "volume", lost_volume: "volume",
  net_force: "force", pressure_force: "force", line_force: "force", contact_force: "force", contact_angle: "angle",
  wall_contact_angle: "angle",
};
/** Keys with a name of their own; others are told with spaces for underscores. */
const NAMES = {
  dx: "cell width", simulated_seconds: "simulated time", wall_seconds: "time of computing", redone: "steps done again",
  volume_error: "volume error, worst of the run", momentum_error: "momentum error, worst of the run",
  max_divergence: "largest divergence", max_speed: "largest speed", least_element: "smallest element over its size at rest",
  lost_volume: "volume of drops lost", peak_memory_bytes: "most memory", net_force: "force of the liquid",
  pressure_force: "of it by pressure", line_force: "of it at the contact line", contact_force: "force of what it rests on",
  target_volume: "volume to keep", wetted: "wetted share",
};
/** Keys that the page shows elsewhere, or that are of no use to a reader. */
const ELSEWHERE = new Set(["scene", "description", "parameters", "version", "dimension", "expect", "drops", "solids", "phases", "solves"]);
/** Drops that are told of singly. */
const MOST = 6;

const name = (key) => NAMES[key] ?? key.replaceAll("_", " ");

/** A value of the summary with its unit. */
function text(key, value, dimension) {
  if (typeof value === "string") return value;
  if (key === "peak_memory_bytes") return `${short(value / 1e6, 3)} MB`;
  if (key === "wetted") return measured(100 * value, "%");
  const unit = KINDS[key] ? unitOf(KINDS[key], dimension) : "";
  if (Array.isArray(value)) return `(${value.map((x) => measured(x, unit)).join(", ")})`;
  return measured(value, unit);
}

/** Groups of rows: a title and rows of name and value. */
function groups(summary, dimension) {
  const rows = (of) => Object.entries(of).filter(([, v]) => v !== null && v !== undefined && typeof v !== "boolean")
    .filter(([, v]) => typeof v !== "object" || Array.isArray(v) && v.every((x) => typeof x === "number"))
    .map(([key, v]) => [name(key), text(key, v, dimension)]);
  const top = rows(Object.fromEntries(Object.entries(summary).filter(([key]) => !ELSEWHERE.has(key))));
  const out = [["The run", top]];
  const checks = (summary.expect ?? []).map((e) => {
    const value = e.value === null ? "not measured" : measured(e.value, e.unit);
    return [e.quantity, `${value}; bar: ${e.bar}; ${e.pass ? "met" : "MISSED"}`];
  });
  if (checks.length) out.push(["Expected at the end", checks]);
  for (const solid of summary.solids ?? []) out.push([`Solid ${solid.name} at the end`, rows({ ...solid, name: undefined })]);
  const drops = summary.drops ?? [];
  drops.slice(0, MOST).forEach((drop, i) => out.push([`Drop ${i + 1} of ${drops.length} at the end`, rows(drop)]));
  const known = new Set([...ELSEWHERE]);
  for (const [key, value] of Object.entries(summary)) {
    if (!known.has(key) && value && typeof value === "object" && !Array.isArray(value)) out.push([name(key), rows(value)]);
  }
  const solves = Object.entries(summary.solves ?? {})
    .map(([key, s]) => [`${key}: solves`, `${s.count}, of ${short(s.mean, 3)} iterations in the mean, ${s.max} at most`]);
  const phases = Object.entries(summary.phases ?? {}).sort((a, b) => b[1] - a[1]);
  out.push(["Time of computing", [...solves, ...phases.map(([key, s]) => [key, measured(s, "s")])]]);
  return out.filter(([, all]) => all.length);
}

function fill(table, title, rows) {
  const columns = Math.max(...rows.map((r) => r.length));
  if (title) {
    const row = table.insertRow();
    row.className = "group";
    const cell = row.insertCell();
    cell.colSpan = columns;
    cell.textContent = title;
  }
  for (const cells of rows) {
    const row = table.insertRow();
    cells.forEach((cell) => { row.insertCell().textContent = cell; });
  }
}

/** The scene's parameters: the liquid's, then those of each solid. */
function facts(parameters, table) {
  const things = [...new Set(parameters.map((p) => p.of ?? ""))];
  for (const thing of things) {
    const own = parameters.filter((p) => (p.of ?? "") === thing);
    fill(table, thing || "liquid", own.map((p) => [p.name, p.symbol, measured(p.value, p.unit)]));
  }
}

/** A scene's text with its angles in degrees. */
const degrees = (scene) => scene.replace(/"(-?[\d.]+(?:e-?\d+)?) rad"/g,
  (_, x) => `"${Number((Number(x) * 180 / Math.PI).toPrecision(12))} deg"`);

export function fillTexts(data) {
  const at = (id) => document.getElementById(id);
  const { summary, dimension } = data;
  document.title = `${data.name} – Meniscus`;
  at("name").textContent = data.name;
  at("description").hidden = !summary?.description;
  at("description").textContent = summary?.description ?? "";
  const cells = summary?.resolution ? `, ${summary.resolution} cells along the longest side` : "";
  const depth = dimension === 2 ? "; all values are per metre of depth" : "";
  at("about").textContent = `${dimension}D${cells}, ${data.frames.length} frames${depth}`;
  at("version").textContent = `Meniscus ${summary?.version ?? data.version}`;
  at("notes").hidden = data.notes.length === 0;
  at("notes").textContent = data.notes.join(" ");
  const parameters = summary?.parameters ?? [];
  at("facts").hidden = !parameters.length;
  for (const id of ["facts-table", "parameters"]) at(id).replaceChildren();
  facts(parameters, at("facts-table"));
  if (summary) groups(summary, dimension).forEach(([title, rows]) => fill(at("parameters"), title, rows));
  at("parameters").parentElement.hidden = Boolean(data.preview);
  at("scene-box").hidden = !data.scene;
  at("scene").textContent = degrees(data.scene);
}
