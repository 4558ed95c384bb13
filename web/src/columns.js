/** What the columns of the time series are called and measured in. In 2D all is per metre of depth. */

/** The unit of a physical quantity in 3D, and in 2D where that differs. */
const UNITS = {
  energy: ["J", "J/m"], force: ["N", "N/m"], momentum: ["kg m/s", "kg/s"], spin: ["kg m²/s", "kg m/s"],
  volume: ["m³", "m²"], length: ["m"], speed: ["m/s"], angle: ["°"], rate: ["1/s"], time: ["s"], percent: ["%"],
  cells: ["cells"], number: [""],
};

/** The unit of a kind of quantity in this many dimensions. */
export const unitOf = (kind, dimension) => UNITS[kind]?.[dimension === 2 ? 1 : 0] ?? UNITS[kind]?.[0] ?? "";

/** Columns: label and kind. */
const COLUMNS = {
  time: ["time", "time"], dt: ["time step", "time"], cfl: ["way of a step", "cells"],
  liquid_volume: ["volume of liquid", "volume"], volume_error: ["volume error", "percent"],
  kinetic_energy: ["kinetic", "energy"], surface_energy: ["surface", "energy"], elastic_energy: ["elastic", "energy"],
  potential_energy: ["potential", "energy"], sum: ["sum", "energy"], max_speed: ["speed", "speed"],
  momentum_x: ["x", "momentum"], momentum_y: ["y", "momentum"], momentum_z: ["z", "momentum"],
  momentum_error: ["momentum not from gravity, relative", "number"],
  contact_points: ["points of the contact line", "number"], contact_length: ["length", "length"],
  contact_angle_mean: ["mean", "angle"], "mean + std": ["mean + std", "angle"], "mean − std": ["mean − std", "angle"],
  divergence_max: ["divergence", "rate"], solve_iterations: ["iterations", "number"], wall_seconds: ["time", "time"],
  drops: ["drops", "number"], redone: ["steps done again at half the length", "number"],
  residual: ["residual of the pressure solve", "number"], line_distance: ["written contact line to that of the energy", "cells"],
  least_element: ["smallest element over its size at rest", "number"],
};
const AXES = { angular_momentum: ["angular momentum", "spin"], centroid: ["middle of the liquid", "length"],
  drop_lower: ["lower corner of the largest drop", "length"], drop_upper: ["upper corner of the largest drop", "length"] };

/** The label and the unit of a column. */
export function told(name, dimension) {
  const plain = name.replace("Δ ", "");
  const known = COLUMNS[plain];
  if (known) return { label: known[0], unit: unitOf(known[1], dimension) };
  const [, start, axis] = /^(.*)_([xyz])$/.exec(plain) ?? [];
  if (AXES[start]) return { label: `${AXES[start][0]}, ${axis}`, unit: unitOf(AXES[start][1], dimension) };
  return { label: plain.replaceAll("_", " "), unit: "" };
}

/** Quantities that every solid has columns of: title, kind, and the parts of their columns' names with labels. */
const AXIS_PARTS = { x: "x", y: "y", z: "z" };
const OF_SOLID = [
  { quantity: "force", title: "Force on", kind: "force", parts: AXIS_PARTS },
  { quantity: "angle", title: "Contact angle on", kind: "angle",
    parts: { left: "left", right: "right", mean: "mean", least: "least", largest: "largest" } },
  { quantity: "tip", title: "Tip of", kind: "length", parts: AXIS_PARTS, moved: true },
  { quantity: "deflection", title: "Largest deflection of", kind: "length", parts: { "": "deflection" } },
  { quantity: "base_radius", title: "Base radius on", kind: "length", parts: { "": "radius" } },
  { quantity: "wetted", title: "Wetted share of", kind: "percent", parts: { "": "wetted" }, scale: 100 },
];

/** The groups of columns of a solid. */
export function groupsOf(solid, names, dimension) {
  return OF_SOLID.map(({ quantity, title, kind, parts, ...rest }) => {
    const column = (part) => `${quantity}_${solid}${part && `_${part}`}`;
    const there = Object.keys(parts).filter((part) => names.has(column(part)));
    const unit = unitOf(kind, dimension);
    return {
      id: `${quantity} ${solid}`, solid, quantity, unit, ...rest,
      title: `${title} ${solid} (${unit}${rest.moved ? ", from its place at the start" : ""})`,
      columns: there.map(column), labels: there.map((part) => parts[part]),
    };
  }).filter((group) => group.columns.length);
}
