/** The colours of crates/view/src/shade.rs. */
const RISING = ["#440154", "#3b528b", "#21918c", "#5ec962", "#fde725"];
const AROUND = ["#2166ac", "#92c5de", "#f7f7f7", "#f4a582", "#b2182b"];

/** The names are those of `meniscus render --color`. */
const LABELS = {
  phi_c: "phi_c, distance to the contact line", strain: "strain, largest |stretch − 1|", displacement: "displacement",
};

const bytes = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

/** The colours of all places 0 to 255 of a shade, as bytes. */
export function palette(name) {
  const stops = (name === "phi_c" ? AROUND : RISING).map(bytes);
  return Array.from({ length: 256 }, (_, place) => {
    const at = (place / 255) * (stops.length - 1), k = Math.min(Math.floor(at), stops.length - 2);
    return stops[k].map((low, c) => Math.round(low + (at - k) * (stops[k + 1][c] - low)));
  });
}

/** The shades that a run has: place in the list, label, range. */
export const shadesOf = (data) =>
  (data.shades ?? []).map((shade, k) => ({ ...shade, k, label: LABELS[shade.name] })).filter((shade) => shade.range);

/** CSS of a bar with the colours of a shade. */
export const gradient = (name) => `linear-gradient(to right, ${(name === "phi_c" ? AROUND : RISING).join(", ")})`;
