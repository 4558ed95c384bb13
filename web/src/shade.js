/** The colours of crates/view/src/color_map.rs. */
const RISING = ["#440154", "#3b528b", "#21918c", "#5ec962", "#fde725"];
const AROUND = ["#2166ac", "#92c5de", "#f7f7f7", "#f4a582", "#b2182b"];

/** The names are those of `meniscus render --color`. */
const LABELS = {
  phi_c: "phi_c, distance to the contact line", strain: "strain, largest |stretch − 1|", displacement: "displacement",
  young: "Young's contact angle",
};

const stopsOf = (name) => (["phi_c", "young"].includes(name) ? AROUND : RISING);

const bytes = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

/** The colours of all places 0 to 255 of a shade, as bytes. */
export function palette(name) {
  const stops = stopsOf(name).map(bytes);
  return Array.from({ length: 256 }, (_, place) => {
    const at = (place / 255) * (stops.length - 1), k = Math.min(Math.floor(at), stops.length - 2);
    return stops[k].map((low, c) => Math.round(low + (at - k) * (stops[k + 1][c] - low)));
  });
}

/** Young's angles of a run: that of a solid, or those of all. */
export function young(summary, solid) {
  const all = (summary?.parameters ?? []).filter((p) => p.symbol === "θ_Y" && (!solid || p.of === solid));
  return [...new Set(all.map((p) => Number(p.value.toFixed(3))))];
}

/** The shades that a run has: place in the list, label, range. Solids with a single angle have no values of it. */
export function shadesOf({ shades, summary }) {
  const rangeOf = ({ name, range }) => range ?? (name === "young" && young(summary).length ? { low: 0, high: 180 } : null);
  return (shades ?? []).map((shade, k) => ({ ...shade, k, label: LABELS[shade.name], range: rangeOf(shade) })).filter((s) => s.range);
}

/** The places of a solid's vertices in a shade; null where it has none. */
export function placesOf({ name, mesh }, shade, summary) {
  if (!shade) return null;
  const angle = shade.name === "young" && young(summary, name)[0];
  return mesh.shades[shade.k] ?? (typeof angle === "number" ? new Uint8Array(mesh.positions.length / 3).fill(255 * angle / 180) : null);
}

/** CSS of a bar with the colours of a shade. */
export const gradient = (name) => `linear-gradient(to right, ${stopsOf(name).join(", ")})`;
