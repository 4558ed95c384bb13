/** Ranges that single spikes do not flatten, and marks where values lie beyond them. */

/** The part of the values at each end that may be cut off. */
const TAIL = 0.01;
/** The whole range is shown where it is not more than this many times that of all but the tails. */
const NARROW = 2;

/**
 * The usual range of some columns, which holds all but a hundredth of the values at each end and whatever lies within half that
 * range around it; the range of all; and how many values are beyond the usual one. `also` are values that must be seen.
 */
export function robust(columns, also = []) {
  const values = columns.flatMap((column) => column.filter((v) => v !== null)).sort((a, b) => a - b);
  const at = (part) => values[Math.round(part * (values.length - 1))];
  const all = [Math.min(at(0), ...also), Math.max(at(1), ...also)];
  let [low, high] = [at(TAIL), at(1 - TAIL)];
  const margin = 0.5 * (high - low);
  [low, high] = [Math.max(low - margin, at(0)), Math.min(high + margin, at(1))];
  const range = [Math.min(low, ...also), Math.max(high, ...also)];
  const wide = all[1] - all[0] > NARROW * (range[1] - range[0]) && range[1] > range[0];
  if (!wide) return { range: all, all, beyond: 0 };
  return { range, all, beyond: values.filter((v) => v < range[0] || v > range[1]).length };
}

/** A range with some air around it. */
export function rangeOf([low, high]) {
  const air = 0.06 * (high - low) || 0.05 * Math.abs(high) || 1;
  return [low - air, high + air];
}

/** Marks at the upper and lower edge of a plot where values are cut off. */
export function marks(u, color) {
  const { min, max } = u.scales.y, { left, top, height } = u.bbox, { ctx } = u;
  const size = 5 * devicePixelRatio;
  ctx.save();
  ctx.fillStyle = color;
  let last = [-Infinity, -Infinity];
  for (const column of u.data.slice(1)) {
    column.forEach((v, i) => {
      if (v === null || (v >= min && v <= max)) return;
      const side = v > max ? 0 : 1, x = u.valToPos(u.data[0][i], "x", true);
      if (x < left || Math.abs(x - last[side]) < size) return;
      last[side] = x;
      const edge = side ? top + height : top, tip = edge + (side ? -1 : 1) * 0.2 * size;
      const base = tip + (side ? -1 : 1) * size;
      ctx.beginPath();
      ctx.moveTo(x, tip);
      ctx.lineTo(x - 0.6 * size, base);
      ctx.lineTo(x + 0.6 * size, base);
      ctx.fill();
    });
  }
  ctx.restore();
}
