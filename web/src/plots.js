import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { css, short } from "./format.js";

const LABELS = {
  kinetic_energy: "kinetic", surface_energy: "surface", elastic_energy: "elastic", potential_energy: "potential",
};
const GROUPS = [
  { id: "angle", title: "Contact angle (°)", columns: ["contact_angle_mean"] },
  { id: "energy", title: "Energy (J)", columns: Object.keys(LABELS) },
  { id: "volume", title: "Volume error (%)", columns: ["volume_error"] },
  { id: "speed", title: "Largest speed (m/s)", columns: ["max_speed"] },
  { id: "momentum", title: "Momentum (kg m/s)", columns: ["momentum_x", "momentum_y", "momentum_z"] },
  { id: "line", title: "Contact line (m)", columns: ["contact_length"] },
  { id: "iterations", title: "Solver iterations", columns: ["solve_iterations"] },
  { id: "dt", title: "Time step (s)", columns: ["dt"] },
  { id: "divergence", title: "Largest divergence (1/s)", columns: ["divergence_max"] },
  { id: "wall", title: "Wall time per step (s)", columns: ["wall_seconds"] },
];
const HEIGHT = 148;

/** The columns by name, with the volume error worked out. */
function columnsOf(series) {
  const columns = new Map(series.names.map((name, i) => [name, series.columns[i]]));
  const volume = columns.get("liquid_volume");
  const first = volume?.find((v) => v);
  if (first) columns.set("volume_error", volume.map((v) => (v === null ? null : 100 * (v / first - 1))));
  return columns;
}

const useful = (column) => column && column.some((v) => v !== null && v !== 0);

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
    this.groups = GROUPS.map((g) => ({ ...g, columns: g.columns.filter((c) => useful(this.columns.get(c))) }))
      .filter((g) => g.columns.length > 0);
    const known = new Set([...GROUPS.flatMap((g) => g.columns), "time", "step"]);
    for (const name of this.columns.keys()) {
      if (known.has(name) || !useful(this.columns.get(name))) continue;
      this.groups.push({ id: name, title: name.replaceAll("_", " "), columns: [name] });
    }
    this.groups.forEach((g, i) => this.chip(g, i < 4));
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
    const colors = ["--a", "--b", "--c", "--d"].map(css);
    const grid = { stroke: css("--grid"), width: 1 };
    const axis = { stroke: css("--quiet"), grid, ticks: grid, font: "11px system-ui, sans-serif" };
    const series = group.columns.map((name, i) => ({
      label: LABELS[name] ?? name.replaceAll("_", " "), stroke: colors[i % 4], width: 1.6, spanGaps: true,
      points: { show: false }, value: (_, v) => short(v),
    }));
    const options = {
      width: this.width(), height: HEIGHT,
      scales: { x: { time: false } },
      cursor: { sync: { key: "meniscus" }, drag: { x: false, y: false }, points: { size: 6 } },
      legend: { show: true },
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
    this.shown.set(group.id, { plot, box, group });
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
    for (const { plot } of this.shown.values()) plot.redraw(false);
  }
}
