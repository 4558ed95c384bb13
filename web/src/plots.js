import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { css, short } from "./format.js";

const LABELS = {
  kinetic_energy: "kinetic", surface_energy: "surface", elastic_energy: "elastic", potential_energy: "potential",
  contact_angle_mean: "mean", max_speed: "speed", momentum_x: "x", momentum_y: "y", momentum_z: "z",
  solve_iterations: "iterations", volume_error: "error", contact_length: "length",
};
const ENERGIES = ["kinetic_energy", "surface_energy", "elastic_energy", "potential_energy"];
const GROUPS = [
  { id: "angle", title: "Contact angle (°)", columns: ["contact_angle_mean", "mean + std", "mean − std"], band: [2, 3] },
  { id: "change", title: "Energy change since the start (J)", columns: [...ENERGIES, "sum"].map((c) => `Δ ${c}`) },
  { id: "volume", title: "Volume error (%)", columns: ["volume_error"] },
  { id: "speed", title: "Largest speed (m/s)", columns: ["max_speed"] },
  { id: "energy", title: "Energy (J)", columns: ENERGIES },
  { id: "momentum", title: "Momentum (kg m/s)", columns: ["momentum_x", "momentum_y", "momentum_z"] },
  { id: "line", title: "Contact line (m)", columns: ["contact_length"] },
  { id: "iterations", title: "Solver iterations", columns: ["solve_iterations"] },
  { id: "dt", title: "Time step (s)", columns: ["dt"] },
  { id: "divergence", title: "Largest divergence (1/s)", columns: ["divergence_max"] },
  { id: "wall", title: "Wall time per step (s)", columns: ["wall_seconds"] },
];
/** Those shown from the start. */
const FIRST = new Set(["angle", "change", "volume", "speed"]);
const HEIGHT = 148;

/** Columns of the force on a solid, `NAME_force_y` or `force_NAME_y`: the solid's name and the axis. */
const FORCE = /^(?:(.+)_force|force_(.+))_([xyz])$/;

/** One group for each solid whose force is among the columns. */
function forces(names) {
  const groups = new Map();
  for (const name of names) {
    const found = FORCE.exec(name);
    if (!found) continue;
    const solid = found[1] ?? found[2], id = `force ${solid}`;
    if (!groups.has(id)) groups.set(id, { id, title: `Force on ${solid} (N)`, columns: [] });
    groups.get(id).columns.push(name);
  }
  return [...groups.values()];
}

/** The columns by name, with the volume error worked out. */
function columnsOf(series) {
  const columns = new Map(series.names.map((name, i) => [name, series.columns[i]]));
  const volume = columns.get("liquid_volume");
  const first = volume?.find((v) => v);
  if (first) columns.set("volume_error", volume.map((v) => (v === null ? null : 100 * (v / first - 1))));
  const [mean, std] = [columns.get("contact_angle_mean"), columns.get("contact_angle_std")];
  if (mean && std?.some((v) => v)) {
    for (const [name, sign] of [["mean + std", 1], ["mean − std", -1]]) {
      columns.set(name, mean.map((v, i) => (v === null || std[i] === null ? null : v + sign * std[i])));
    }
  }
  const energies = ENERGIES.map((name) => columns.get(name)).filter(Boolean);
  if (energies.length) {
    const sum = energies[0].map((_, i) => energies.reduce((s, c) => s + (c[i] ?? 0), 0));
    for (const [name, column] of [...ENERGIES.map((n) => [n, columns.get(n)]), ["sum", sum]]) {
      if (column) columns.set(`Δ ${name}`, column.map((v) => (v === null ? null : v - column[0])));
    }
  }
  return columns;
}

const label = (name) => LABELS[name.replace("Δ ", "")] ?? FORCE.exec(name)?.[3] ?? name.replace("Δ ", "").replaceAll("_", " ");

const useful = (column) => column && column.some((v) => v !== null && v !== 0);

/** The place in ascending `times` nearest to `t`. */
function nearest(times, t) {
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] > t) high = middle;
    else low = middle;
  }
  return t - times[low] < times[high] - t ? low : high;
}

export class Plots {
  /** `pick` is called with a time when a plot is clicked. */
  constructor(series, pick) {
    this.columns = columnsOf(series);
    this.times = this.columns.get("time") ?? [];
    this.pick = pick;
    this.now = null;
    this.shown = new Map();
    this.box = document.getElementById("plots");
    if (this.times.length < 2) {
      this.box.innerHTML = "<p class='quiet'>There is no time series in this folder.</p>";
      return;
    }
    const all = [GROUPS[0], ...forces(this.columns.keys()), ...GROUPS.slice(1)];
    this.groups = all.map((g) => ({ ...g, columns: g.columns.filter((c) => useful(this.columns.get(c))) }))
      .filter((g) => g.columns.length > 0);
    const known = new Set([...all.flatMap((g) => g.columns), "contact_angle_std", "time", "step"]);
    this.groups.forEach((g) => this.chip(g, FIRST.has(g.id) || g.id.startsWith("force ")));
    const others = [...this.columns.keys()].filter((name) => !known.has(name) && useful(this.columns.get(name)));
    if (others.length) this.menu(others);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.rebuild());
    new ResizeObserver(() => this.resize()).observe(this.box);
  }

  chip(group, on) {
    const chip = document.createElement("button");
    chip.textContent = group.title.replace(/ \(.*/, "");
    chip.setAttribute("aria-pressed", on);
    chip.onclick = () => {
      const show = !this.shown.has(group.id);
      chip.setAttribute("aria-pressed", show);
      if (show) this.show(group);
      else this.hide(group);
    };
    document.getElementById("chips").append(chip);
    if (on) this.show(group);
  }

  /** A menu of the columns that have no place in any group. */
  menu(names) {
    const menu = document.createElement("select");
    menu.setAttribute("aria-label", "More columns");
    menu.append(new Option("more…", ""), ...names.map((name) => new Option(name.replaceAll("_", " "), name)));
    menu.onchange = () => {
      const name = menu.value, group = { id: name, title: label(name), columns: [name] };
      menu.querySelector(`option[value="${CSS.escape(name)}"]`).remove();
      menu.value = "";
      this.groups.push(group);
      this.chip(group, true);
      document.getElementById("chips").append(menu);
    };
    document.getElementById("chips").append(menu);
  }

  width() {
    return Math.max(220, this.box.clientWidth);
  }

  show(group) {
    const box = document.createElement("div");
    box.className = "plot";
    const order = this.groups.indexOf(group);
    box.style.order = order;
    box.innerHTML = `<h3>${group.title}</h3>`;
    this.box.append(box);
    const colors = ["--a", "--b", "--c", "--d", "--ink"].map(css);
    const grid = { stroke: css("--grid"), width: 1 };
    const axis = { stroke: css("--quiet"), grid, ticks: grid, font: "11px system-ui, sans-serif" };
    // The edges of a band take the colour of its middle, thin.
    const inBand = (i) => group.band?.includes(i + 1);
    const series = group.columns.map((name, i) => ({
      label: label(name), stroke: inBand(i) ? `${colors[0]}66` : colors[i % 5], width: inBand(i) ? 0.6 : 1.6,
      spanGaps: !group.band, points: { show: false }, value: (_, v) => short(v),
    }));
    const bands = group.band?.[1] === series.length ? [{ series: group.band, fill: `${colors[0]}26` }] : [];
    const options = {
      width: this.width(), height: HEIGHT,
      scales: { x: { time: false } },
      cursor: { sync: { key: "meniscus" }, drag: { x: false, y: false }, points: { size: 6 } },
      legend: { show: true },
      bands,
      series: [{ label: "t", value: (_, v) => (v === null ? "–" : `${short(v)} s`) }, ...series],
      axes: [
        { ...axis, values: (_, ticks) => ticks.map((t) => short(t)), size: 26, gap: 3 },
        { ...axis, values: (_, ticks) => ticks.map((t) => short(t)), size: 58, gap: 3, space: 24 },
      ],
      hooks: { draw: [(u) => this.mark(u)] },
    };
    const data = [this.times, ...group.columns.map((name) => this.columns.get(name))];
    const plot = new uPlot(options, data, box);
    plot.over.addEventListener("click", (e) => this.pick(plot.posToVal(e.offsetX, "x")));
    plot.over.addEventListener("mouseleave", () => this.shown.forEach((s) => this.legend(s.plot)));
    this.legend(plot);
    this.shown.set(group.id, { plot, box, group });
  }

  /** Shows the values at the viewer's time, once the plot has done its own. */
  legend(plot) {
    setTimeout(() => { if (plot.root.isConnected) plot.setLegend({ idx: this.row ?? 0 }, false); }, 0);
  }

  hide(group) {
    const { plot, box } = this.shown.get(group.id);
    plot.destroy();
    box.remove();
    this.shown.delete(group.id);
  }

  rebuild() {
    const groups = [...this.shown.values()].map((s) => s.group);
    groups.forEach((g) => { this.hide(g); this.show(g); });
  }

  resize() {
    const width = this.width();
    if (width === this.last) return;
    this.last = width;
    for (const { plot } of this.shown.values()) plot.setSize({ width, height: HEIGHT });
  }

  /** The line at the time that the viewer shows. */
  mark(u) {
    if (this.now === null) return;
    const x = Math.round(u.valToPos(this.now, "x", true));
    const { left, top, width, height } = u.bbox;
    if (x < left || x > left + width) return;
    u.ctx.save();
    u.ctx.fillStyle = css("--mark");
    u.ctx.fillRect(x - 0.75 * devicePixelRatio, top, 1.5 * devicePixelRatio, height);
    u.ctx.restore();
  }

  at(time) {
    this.now = time;
    this.row = nearest(this.times, time);
    for (const { plot } of this.shown.values()) {
      plot.redraw(false);
      this.legend(plot);
    }
  }
}
