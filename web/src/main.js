import "./style.css";
import { Frames, extent } from "./decode.js";
import { measured, quantity } from "./format.js";
import { follow, pointOfLine } from "./live.js";
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
    Object.assign(this, { wanted: 0, playing: false, last: -1 });
    this.renew(data, frames, view);
  }

  /** Plays other data, or later ones of the same run; who looks at the last frame sees the new last one. */
  renew(data, frames, view) {
    const follows = this.wanted === this.last && this.last > 0;
    Object.assign(this, { data, frames, view, last: data.frames.length - 1 });
    at("slider").max = this.last;
    if (follows || this.wanted > this.last) this.wanted = this.last;
  }

  /** The liquid of the other run at the time of a frame; null without another run. */
  async otherLiquid(i) {
    const all = this.other?.data.frames, far = (f) => Math.abs(f.time - this.data.frames[i].time);
    if (!all?.length) return null;
    return this.other.mesh(all.reduce((best, f) => (far(f) < far(best) ? f : best)).liquid);
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
        this.view.over(await this.otherLiquid(shown));
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
function offerShades(page, first) {
  const { data, view } = page, choice = at("shade");
  const shades = view.colorable ? shadesOf(data) : [], before = view.shade?.name;
  at("shade-choice").hidden = !shades.length;
  choice.replaceChildren(new Option("plain", ""), ...shades.map(({ name, label }) => new Option(label, name)));
  const wanted = first ?? before;
  choice.onchange = () => {
    view.shade = shades.find((s) => s.name === choice.value) ?? null;
    const { name, range, unit } = view.shade ?? {};
    at("legend").hidden = !view.shade;
    if (view.shade) {
      at("legend-low").textContent = measured(range.low, unit);
      at("legend-high").textContent = measured(range.high, unit);
      at("legend-name").textContent = view.shade.label;
      at("legend-bar").style.background = gradient(name);
    }
    page.player.go(page.player.wanted);
  };
  choice.value = shades.some((s) => s.name === wanted) ? wanted : "";
  choice.onchange();
}

/** Tells of the point of the contact line that is clicked; only a server knows it. */
function tellOfPoints(page) {
  let start = null;
  const box = at("stage"), told = at("point");
  box.addEventListener("pointerdown", (e) => { start = [e.clientX, e.clientY]; told.hidden = true; }, true);
  box.addEventListener("click", async (e) => {
    if (!start || Math.hypot(e.clientX - start[0], e.clientY - start[1]) > 4) return;
    const { left, top } = box.getBoundingClientRect(), [x, y] = [e.clientX - left, e.clientY - top];
    const point = page.view.pick(x, y);
    if (point === null) return;
    const { solid, angle, speed, force } = await pointOfLine(page.data.frames[page.player.wanted].number, point);
    const rows = [["angle", angle, "°"], ["speed", speed, "m/s"], ["force", force, "N/m"]];
    told.textContent = [`contact line${solid ? ` on ${solid}` : ""}`, ...rows.map(([name, v, unit]) => `${name} ${measured(v, unit)}`)].join("\n");
    told.style.left = `${Math.min(x + 12, box.clientWidth - 150)}px`;
    told.style.top = `${Math.min(y + 12, box.clientHeight - 90)}px`;
    told.hidden = false;
  });
}

function listen(page) {
  const { player } = page;
  at("slider").addEventListener("input", (e) => { player.play(false); player.go(Number(e.target.value)); });
  at("play").onclick = () => player.play();
  at("home").onclick = () => page.view.home();
  const toggle = (id, key) => at(id).addEventListener("change", (e) => { page.view.show[key] = e.target.checked; page.view.draw(); });
  toggle("show-line", "line");
  toggle("show-solids", "solids");
  const keys = {
    " ": () => player.play(), ArrowLeft: () => player.go(player.wanted - 1),
    ArrowRight: () => player.go(player.wanted + 1), Home: () => player.go(0), End: () => player.go(player.last),
    0: () => page.view.home(),
  };
  addEventListener("keydown", (e) => {
    if (!keys[e.key] || e.ctrlKey || e.metaKey || e.altKey || e.target.matches("select, summary")) return;
    if (e.key === " " && e.target.matches("button, input[type=checkbox]")) return;
    e.preventDefault();
    if (e.key.startsWith("Arrow")) player.play(false);
    keys[e.key]();
  });
}

/** The view, the player, the plots and the texts of a run, whose data may be replaced by later ones. */
class Page {
  async show(data, other = null) {
    const before = this.data;
    const isSame = before && before.dimension === data.dimension && String(before.domain) === String(data.domain);
    this.data = data;
    fillTexts(data);
    const frames = isSame ? this.player.frames : new Frames(data);
    frames.data = data;
    if (!isSame) {
      this.view?.remove();
      this.view = makeView(data, await extent(frames));
    }
    this.view.data = data;
    this.other = other && new Frames(other);
    if (this.player) this.player.renew(data, frames, this.view);
    else this.player = new Player(data, frames, this.view);
    this.player.other = this.other;
    at("line-toggle").hidden = !data.frames.some((f) => f.line !== null);
    at("solid-toggle").hidden = !data.frames.some((f) => Object.keys(f.solids).length);
    if (!this.plots?.renew(data)) {
      this.plots?.shown.clear();
      this.plots = this.player.plots = new Plots(data, (time) => { this.player.play(false); this.player.at(time); });
    }
    if (!before) listen(this);
    // Before a run the angles are what is to be seen of solids.
    offerShades(this, before || data.frames.length > 1 ? null : "young");
    await this.player.go(this.player.wanted);
    if (other) at("notes").textContent = `${data.notes.join(" ")} Dashed or orange: the liquid of ${other.folder}, at its nearest frame.`;
    if (other) at("notes").hidden = false;
    document.body.dataset.errors ??= "[]";
    document.body.dataset.ready = `frames:${data.frames.length}`;
  }
}

async function start() {
  const element = at("data"), data = JSON.parse(element.textContent);
  element.remove();
  if (typeof data !== "object" || !data) {
    at("message").hidden = false;
    at("message").textContent = "There is no run in this page: write one with `meniscus page`.";
    return;
  }
  const page = new Page(), asked = /frame=(\d+)/.exec(location.hash);
  const show = async (run, other) => {
    const first = !page.data;
    await page.show(run, other);
    if (first && asked) await page.player.go(Number(asked[1]));
  };
  if (!data.live) return show(data);
  tellOfPoints(page);
  return follow(show);
}

start();
