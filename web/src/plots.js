import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { groupsOf, told, unitOf } from "./columns.js";
import { css, measured, short } from "./format.js";
import { young } from "./shade.js";
import { marks, rangeOf, robust } from "./spikes.js";

const ENERGIES = ["kinetic_energy", "surface_energy", "elastic_energy", "potential_energy"];
const GROUPS = [
  { id: "angle", title: "Contact angle, all lines", kind: "angle", columns: ["contact_angle_mean", "mean + std", "mean − std"], band: [2, 3] },
  { id: "change", title: "Energy change since the start", kind: "energy", columns: [...ENERGIES, "sum"].map((c) => `Δ ${c}`) },
  { id: "volume", title: "Volume error", kind: "percent", columns: ["volume_error"] },
  { id: "speed", title: "Largest speed", kind: "speed", columns: ["max_speed"] },
  { id: "energy", title: "Energy", kind: "energy", columns: ENERGIES },
  { id: "momentum", title: "Momentum", kind: "momentum", columns: ["momentum_x", "momentum_y", "momentum_z"] },
  { id: "line", title: "Contact line", kind: "length", columns: ["contact_length"] },
  { id: "iterations", title: "Solver iterations", kind: "number", columns: ["solve_iterations"] },
  { id: "dt", title: "Time step", kind: "time", columns: ["dt"] },
  { id: "divergence", title: "Largest divergence", kind: "rate", columns: ["divergence_max"] },
  { id: "wall", title: "Time of computing so far", kind: "time", columns: ["wall_seconds"] },
];
/** Those shown from the start: these, and these quantities of solids. */
const FIRST = new Set(["change", "volume", "speed"]);
const FIRST_OF_SOLID = new Set(["force", "angle", "tip"]);
const HEIGHT = 162;

/** The columns by name, with the volume error, the energies' changes and the solids' values worked out. */
function columnsOf(series) {
  const columns = new Map(series.names.map((name, i) => [name, series.columns[i]]));
  const volume = columns.get("liquid_volume");
  const first = volume?.find((v) => v);
  const error = columns.get("volume_error") ?? (first && volume.map((v) => (v === null ? null : v / first - 1)));
  if (error) columns.set("volume_error", error.map((v) => (v === null ? null : 100 * v)));
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
  constructor(data, pick) {
    const { summary, dimension } = data;
    Object.assign(this, { summary, dimension, pick, now: null, shown: new Map() });
    this.box = document.getElementById("plots");
    this.box.replaceChildren();
    document.getElementById("chips").replaceChildren();
    this.read(data);
    if (this.times.length < 2) {
      this.box.innerHTML = "<p class='quiet'>There is no time series yet.</p>";
      return;
    }
    const own = this.own;
    const all = [...own, ...GROUPS.map((g) => this.named(g))];
    const known = new Set([...all.flatMap((g) => g.columns), "contact_angle_std", "time", "step"]);
    this.groups = all.map((g) => this.kept(g)).filter((g) => g.columns.length > 0);
    const angles = this.groups.some((g) => g.quantity === "angle");
    const first = (g) => FIRST.has(g.id) || FIRST_OF_SOLID.has(g.quantity) || (g.id === "angle" && !angles);
    this.groups.forEach((g) => this.chip(g, first(g)));
    const others = [...this.columns.keys()].filter((name) => !known.has(name) && useful(this.columns.get(name)));
    if (others.length) this.menu(others);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.rebuild());
    new ResizeObserver(() => this.resize()).observe(this.box);
  }

  /** Reads the time series. */
  read({ series, summary, dimension }) {
    this.columns = columnsOf(series);
    this.times = this.columns.get("time") ?? [];
    const solids = (summary?.solids ?? []).map((s) => s.name).filter(Boolean);
    this.own = solids.flatMap((solid) => groupsOf(solid, this.columns, dimension));
    this.own.forEach((g) => this.prepare(g));
  }

  /** Shows later rows of the same run. False where it has other columns than before. */
  renew(data) {
    const before = [...this.columns].filter(([, column]) => useful(column)).map(([name]) => name).join();
    this.read(data);
    if (before !== [...this.columns].filter(([, column]) => useful(column)).map(([name]) => name).join()) return false;
    for (const state of this.shown.values()) {
      const columns = state.group.columns.map((name) => this.columns.get(name));
      state.usual = robust(columns, state.lines.map((l) => l.value));
      state.plot.setData([this.times, ...columns]);
    }
    return true;
  }

  /** Brings a solid's columns to what is shown: per cent, and the way from the start. */
  prepare({ columns, scale, moved }) {
    for (const name of columns.filter(() => scale || moved)) {
      const values = this.columns.get(name), first = values.find((v) => v !== null) ?? 0;
      this.columns.set(name, values.map((v) => (v === null ? null : moved ? v - first : v * scale)));
    }
  }

  named(group) {
    const unit = unitOf(group.kind, this.dimension);
    const labels = group.columns.map((c) => told(c, this.dimension).label);
    return { ...group, unit, labels, title: unit ? `${group.title} (${unit})` : group.title };
  }

  /** A group without the columns that tell nothing. */
  kept(group) {
    const keep = group.columns.map((c) => useful(this.columns.get(c)));
    const only = (list) => list.filter((_, i) => keep[i]);
    return { ...group, columns: only(group.columns), labels: only(group.labels) };
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
    const label = (name) => told(name, this.dimension).label;
    menu.append(new Option("more…", ""), ...names.map((name) => new Option(label(name), name)));
    menu.onchange = () => {
      const name = menu.value, { label, unit } = told(name, this.dimension);
      const group = { id: name, title: unit ? `${label} (${unit})` : label, unit, columns: [name], labels: [label] };
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

  /** The horizontal lines that a group is compared with. */
  lines(group) {
    if (group.id !== "angle" && group.quantity !== "angle") return [];
    return young(this.summary, group.solid).map((value) => ({ value, label: `Young ${short(value)}°` }));
  }

  show(group) {
    const box = document.createElement("div");
    box.className = "plot";
    box.style.order = this.groups.indexOf(group);
    box.innerHTML = "<h3></h3>";
    box.firstChild.textContent = group.title;
    this.box.append(box);
    const columns = group.columns.map((name) => this.columns.get(name));
    const lines = this.lines(group);
    const usual = robust(columns, lines.map((l) => l.value));
    const state = { group, box, usual, clipped: usual.beyond > 0, lines };
    if (usual.beyond) this.offerAll(state);
    state.plot = new uPlot(this.options(group, state), [this.times, ...columns], box);
    state.plot.over.addEventListener("click", (e) => this.pick(state.plot.posToVal(e.offsetX, "x")));
    state.plot.over.addEventListener("mouseleave", () => this.shown.forEach((s) => this.legend(s.plot)));
    this.legend(state.plot);
    this.shown.set(group.id, state);
  }

  /** A switch between the usual range and all values. */
  offerAll(state) {
    const button = document.createElement("button");
    const { beyond, all } = state.usual, unit = state.group.unit;
    const tell = () => {
      button.textContent = state.clipped ? `${beyond} spikes cut off: show all` : "cut spikes off";
      button.title = `All values: ${measured(all[0], unit)} to ${measured(all[1], unit)}`;
    };
    button.className = "spikes";
    button.onclick = () => {
      state.clipped = !state.clipped;
      tell();
      state.plot.redraw(true, true);
      state.plot.setScale("y", {});
    };
    tell();
    state.box.firstChild.append(button);
  }

  options(group, state) {
    const colors = ["--a", "--b", "--c", "--d", "--ink"].map(css);
    const grid = { stroke: css("--grid"), width: 1 };
    const axis = { stroke: css("--quiet"), grid, ticks: grid, font: "11px system-ui, sans-serif", labelFont: "11px system-ui, sans-serif" };
    // The edges of a band take the colour of its middle, thin.
    const inBand = (i) => group.band?.includes(i + 1);
    const series = group.columns.map((_, i) => ({
      label: group.labels[i], stroke: inBand(i) ? `${colors[0]}66` : colors[i % 5], width: inBand(i) ? 0.6 : 1.6,
      spanGaps: !group.band, points: { show: false }, value: (_, v) => measured(v, group.unit),
    }));
    const bands = group.band?.[1] === series.length ? [{ series: group.band, fill: `${colors[0]}26` }] : [];
    const ticks = (_, all) => all.map((t) => short(t));
    return {
      width: this.width(), height: HEIGHT,
      scales: { x: { time: false }, y: { range: () => rangeOf(state.clipped ? state.usual.range : state.usual.all) } },
      cursor: { sync: { key: "meniscus" }, drag: { x: false, y: false }, points: { size: 6 } },
      legend: { show: true },
      bands,
      series: [{ label: "time", value: (_, v) => measured(v, "s") }, ...series],
      axes: [
        { ...axis, values: ticks, size: 24, gap: 3, label: "time (s)", labelSize: 16, labelGap: 0 },
        { ...axis, values: ticks, size: 58, gap: 3, space: 24 },
      ],
      hooks: { draw: [(u) => this.drawLines(u, state.lines), (u) => marks(u, css("--line")), (u) => this.mark(u)] },
    };
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

  /** Dashed horizontal lines with their names. */
  drawLines(u, lines) {
    const { left, top, width, height } = u.bbox, { ctx } = u, ratio = devicePixelRatio;
    for (const { value, label } of lines) {
      const y = u.valToPos(value, "y", true);
      if (y < top || y > top + height) continue;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = css("--quiet");
      ctx.lineWidth = ratio;
      ctx.setLineDash([5 * ratio, 4 * ratio]);
      ctx.beginPath();
      ctx.moveTo(left, y);
      ctx.lineTo(left + width, y);
      ctx.stroke();
      ctx.font = `${11 * ratio}px system-ui, sans-serif`;
      ctx.textAlign = "right";
      ctx.fillText(label, left + width - 4 * ratio, y - 4 * ratio);
      ctx.restore();
    }
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
