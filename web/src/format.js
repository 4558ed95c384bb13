/** A number as people write it: about four digits, powers of ten only where needed. */
export function short(x, digits = 4) {
  if (x === null || x === undefined) return "–";
  if (typeof x !== "number") return String(x);
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (Number.isInteger(x) && size < 1e7) return String(x);
  if (size >= 1e5 || size < 1e-3) return x.toExponential(digits - 1).replace(/\.?0+e/, "e").replace("e+", "e");
  return String(Number(x.toPrecision(digits)));
}

const PREFIXES = [[1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

/** A number with a unit and a prefix. */
export function quantity(x, unit) {
  if (!x) return `0 ${unit}`;
  const [scale, prefix] = PREFIXES.find(([s]) => Math.abs(x) >= s * 0.9995) ?? PREFIXES[3];
  return `${Number((x / scale).toPrecision(4))} ${prefix}${unit}`;
}

/** 1, 2 or 5 times a power of ten, at most x. */
export function round(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return ([5, 2, 1].find((d) => d * power <= x * (1 + 1e-9)) ?? 1) * power;
}

export const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** Units that take prefixes. */
const PREFIXED = new Set(["m", "s", "N", "N/m", "J", "J/m", "m/s", "Pa", "Pa s", "N m"]);

/** A number with its unit, if it has one. */
export function measured(x, unit) {
  if (x === null || x === undefined) return "–";
  if (unit === "deg" || unit === "°") return `${Number(x.toFixed(2))}°`;
  if (unit === "%") return `${short(x, 3)} %`;
  if (PREFIXED.has(unit)) return quantity(x, unit);
  return unit ? `${short(x)} ${unit}` : short(x);
}
