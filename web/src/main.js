import "./style.css";
import { Frames, extent } from "./decode.js";
import { quantity } from "./format.js";
import { Plots } from "./plots.js";
import { gradient, shadesOf } from "./shade.js";
import { fillTexts } from "./texts.js";
import { View2D } from "./view2d.js";
import { View3D } from "./view3d.js";
import { ViewPlain } from "./viewplain.js";

const at = (id) => document.getElementById(id);
const RATE = 25;

function webgl() {
  if (location.hash.includes("plain")) return false;
  const context = document.createElement("canvas").getContext("webgl2");
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return Boolean(context);
}

function makeView(data, box) {
  const stage = at("stage");
  if (data.dimension === 2) return new View2D(stage, data, box);
  if (webgl()) return new View3D(stage, data, box);
  at("message").hidden = false;
  at("message").textContent = "This browser offers no WebGL: a simple drawing is shown. Plots work as usual.";
  return new ViewPlain(stage, data, box);
}

class Player {
  constructor(data, frames, view) {
    Object.assign(this, { data, frames, view, index: 0, wanted: 0, playing: false });
    this.last = data.frames.length - 1;
    at("slider").max = this.last;
  }

  /** Shows a frame; while one is on its way only the latest wish counts. */
  async go(i) {
    this.wanted = Math.max(0, Math.min(this.last, Math.round(i)));
    at("slider").value = this.wanted;
    const { number, time } = this.data.frames[this.wanted];
    at("frame").textContent = `${number}`;
    at("clock").textContent = time === null ? `frame ${number}` : `t = ${quantity(time, "s")}`;
    this.plots?.at(time);
    if (this.busy) return;
    this.busy = true;
    let shown = -1;
    try {
      while (shown !== this.wanted) {
        shown = this.wanted;
        this.view.set(await this.frames.frame(shown));
      }
    } finally {
      this.busy = false;
    }
    if (shown < this.last) this.frames.frame(shown + 1).catch((e) => console.error(e));
  }

  /** Shows the frame nearest to a time. */
  at(time) {
    const far = (f) => Math.abs((f.time ?? f.number) - time);
    const all = this.data.frames;
    this.go(all.reduce((best, f, i) => (far(f) < far(all[best]) ? i : best), 0));
  }

  play(on = !this.playing) {
    this.playing = on && this.last > 0;
    at("play").textContent = this.playing ? "❚❚" : "▶";
    at("play").setAttribute("aria-label", this.playing ? "Pause" : "Play");
    if (!this.playing) return;
    if (this.wanted === this.last) this.go(0);
    let start = performance.now(), from = this.wanted;
    const step = (now) => {
      if (!this.playing) return;
      const due = Math.floor((now - start) * RATE * Number(at("speed").value) / 1000);
      if (due > 0 && !this.busy) {
        const next = from + due;
        from = next > this.last ? 0 : next;
        start = now;
        this.go(from);
      }
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
}

/** Lets solids be coloured by what is stored of them. */
function offerShades(data, player, view) {
  const shades = view.colorable ? shadesOf(data) : [];
  if (!shades.length) return;
  at("shade-choice").hidden = false;
  for (const { name, label } of shades) at("shade").append(new Option(label, name));
  at("shade").onchange = (e) => {
    view.shade = shades.find((s) => s.name === e.target.value) ?? null;
    const { name, range, unit } = view.shade ?? {};
    at("legend").hidden = !view.shade;
    if (view.shade) {
      const text = (x) => (unit && x ? quantity(x, unit) : String(Number(x.toPrecision(3))));
      at("legend-low").textContent = text(range.low);
      at("legend-high").textContent = text(range.high);
      at("legend-name").textContent = view.shade.label;
      at("legend-bar").style.background = gradient(name);
    }
    player.go(player.wanted);
  };
}

function listen(player, view) {
  at("slider").addEventListener("input", (e) => { player.play(false); player.go(Number(e.target.value)); });
  at("play").onclick = () => player.play();
  at("home").onclick = () => view.home();
  const toggle = (id, key) => at(id).addEventListener("change", (e) => { view.show[key] = e.target.checked; view.draw(); });
  toggle("show-line", "line");
  toggle("show-solids", "solids");
  const keys = {
    " ": () => player.play(), ArrowLeft: () => player.go(player.wanted - 1),
    ArrowRight: () => player.go(player.wanted + 1), Home: () => player.go(0), End: () => player.go(player.last),
    0: () => view.home(),
  };
  addEventListener("keydown", (e) => {
    if (!keys[e.key] || e.ctrlKey || e.metaKey || e.altKey || e.target.matches("select, summary")) return;
    if (e.key === " " && e.target.matches("button, input[type=checkbox]")) return;
    e.preventDefault();
    if (e.key.startsWith("Arrow")) player.play(false);
    keys[e.key]();
  });
}

async function start() {
  const element = at("data"), data = JSON.parse(element.textContent);
  element.remove();
  if (typeof data !== "object" || !data) {
    at("message").hidden = false;
    at("message").textContent = "There is no run in this page: write one with `meniscus page`.";
    return;
  }
  fillTexts(data);
  const frames = new Frames(data);
  const view = makeView(data, await extent(frames));
  const player = new Player(data, frames, view);
  at("line-toggle").hidden = !data.frames.some((f) => f.line !== null);
  at("solid-toggle").hidden = !data.frames.some((f) => Object.keys(f.solids).length);
  player.plots = new Plots(data, (time) => { player.play(false); player.at(time); });
  listen(player, view);
  offerShades(data, player, view);
  const asked = /frame=(\d+)/.exec(location.hash);
  await player.go(asked ? Number(asked[1]) : 0);
  document.body.dataset.errors ??= "[]";
  document.body.dataset.ready = `frames:${data.frames.length}`;
}

start();
