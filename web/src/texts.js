import { short } from "./format.js";

function text(value) {
  if (Array.isArray(value)) return `[${value.map((v) => (typeof v === "object" ? "…" : short(v, 5))).join(", ")}]`;
  return short(value, 6);
}

/** Rows [name, value] of nested values. */
function rows(value, prefix = "") {
  return Object.entries(value ?? {}).flatMap(([key, v]) => {
    const name = prefix + key;
    if (v === null || v === undefined) return [];
    if (Array.isArray(v) && v.some((x) => typeof x === "object" && x)) {
      return v.slice(0, 12).flatMap((x, i) => rows(x, `${name} ${x?.name ?? i + 1} › `));
    }
    if (typeof v === "object" && !Array.isArray(v)) return rows(v, `${name} › `);
    return [[name.replaceAll("_", " "), text(v)]];
  });
}

export function fillTexts(data) {
  const at = (id) => document.getElementById(id);
  document.title = `${data.name} – Meniscus`;
  at("name").textContent = data.name;
  const cells = data.summary?.resolution ? `, resolution ${text(data.summary.resolution)}` : "";
  at("about").textContent = `${data.dimension}D${cells}, ${data.frames.length} frames`;
  at("version").textContent = `Meniscus ${data.summary?.version ?? data.version}`;
  at("notes").hidden = data.notes.length === 0;
  at("notes").textContent = data.notes.join(" ");
  for (const [name, value] of rows(data.summary)) {
    const row = at("parameters").insertRow();
    row.insertCell().textContent = name;
    row.insertCell().textContent = value;
  }
  at("scene-box").hidden = !data.scene;
  at("scene").textContent = data.scene;
}
