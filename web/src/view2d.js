import { css, quantity, round } from "./format.js";
import { palette, placesOf } from "./shade.js";

/** Chains edges into one path of closed or open lines. */
function path(mesh) {
  const { positions: p, indices: e } = mesh;
  const next = new Map();
  for (let i = 0; i < e.length; i += 2) next.set(e[i], e[i + 1]);
  const shape = new Path2D(), done = new Set(), ends = new Set(next.values());
  const starts = [...next.keys()].filter((v) => !ends.has(v)).concat([...next.keys()]);
  for (const start of starts) {
    if (done.has(start)) continue;
    shape.moveTo(p[3 * start], p[3 * start + 1]);
    let v = start;
    while (next.has(v) && !done.has(v)) {
      done.add(v);
      v = next.get(v);
      shape.lineTo(p[3 * v], p[3 * v + 1]);
    }
    if (v === start) shape.closePath();
  }
  return shape;
}

/** How far wetted vertices may be off a solid, and how far below its surface they are put, in cells. */
const OFF = 1, SUNK = 0.3;

/** The point of some solids' outlines closest to a point, with the outward normal of its edge; none beyond `reach`. */
function closest(solids, x, y, reach) {
  let best = null, least = reach * reach;
  for (const { positions: p, indices: e } of solids) {
    for (let i = 0; i < e.length; i += 2) {
      const [a, b] = [3 * e[i], 3 * e[i + 1]];
      const [dx, dy] = [p[b] - p[a], p[b + 1] - p[a + 1]], square = dx * dx + dy * dy;
      if (!square) continue;
      const t = Math.max(0, Math.min(1, ((x - p[a]) * dx + (y - p[a + 1]) * dy) / square));
      const at = [p[a] + t * dx, p[a + 1] + t * dy];
      const far = (x - at[0]) ** 2 + (y - at[1]) ** 2;
      if (far >= least) continue;
      least = far;
      const length = Math.sqrt(square);
      best = { at, normal: [dy / length, -dx / length] };
    }
  }
  return best;
}

/** The liquid with its wetted vertices put below the surface of the solid that they are on, which is drawn over them: the two
 * outlines are made apart and fit to a part of a cell. */
function seat(liquid, solids, dx) {
  if (!liquid.kinds || !dx || !solids.length) return liquid;
  const positions = liquid.positions.slice();
  liquid.kinds.forEach((kind, v) => {
    const on = kind > 0 && closest(solids, positions[3 * v], positions[3 * v + 1], OFF * dx);
    if (on) for (let a = 0; a < 2; a++) positions[3 * v + a] = on.at[a] - SUNK * dx * on.normal[a];
  });
  return { ...liquid, positions };
}

/** The window leaves the whole domain where that shows the liquid more than this many times larger. */
const CLOSER = 1.7;

/** Flat pictures on a canvas: drag to move, wheel to zoom. */
export class View2D {
  constructor(box, data, extent) {
    this.box = box;
    this.data = data;
    this.extent = extent;
    this.show = { line: true, solids: true };
    this.colorable = true;
    this.shade = null;
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0;
    box.prepend(this.canvas);
    this.home();
    new ResizeObserver(() => this.draw()).observe(box);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    this.listen();
  }

  /** Takes the picture off the page. */
  remove() {
    this.canvas.remove();
  }

  /** Shows the domain, or what is to be seen where that makes it much larger. */
  home() {
    const { low, high } = this.extent, domain = this.data.domain;
    const margin = 0.12 * Math.hypot(high[0] - low[0], high[1] - low[1]);
    let box = [low[0] - margin, low[1] - margin, high[0] + margin, high[1] + margin];
    if (domain && this.data.preview) box = [0, 0, domain[0], domain[1]];
    else if (domain) {
      const { clientWidth: w, clientHeight: h } = this.box;
      const scale = (width, height) => Math.min((w || 4) / width, (h || 3) / height);
      if (scale(box[2] - box[0], box[3] - box[1]) > CLOSER * scale(domain[0], domain[1])) {
        box = box.map((x, i) => (i < 2 ? Math.max(x, 0) : Math.min(x, domain[i - 2])));
      } else box = [0, 0, domain[0], domain[1]];
    }
    this.window = box;
    this.zoom = 1;
    this.move = [0, 0];
    this.draw();
  }

  listen() {
    const c = this.canvas;
    let last = null;
    c.addEventListener("pointerdown", (e) => { last = [e.clientX, e.clientY]; c.setPointerCapture(e.pointerId); });
    c.addEventListener("pointerup", () => { last = null; });
    c.addEventListener("pointermove", (e) => {
      if (!last) return;
      this.move[0] += e.clientX - last[0];
      this.move[1] += e.clientY - last[1];
      last = [e.clientX, e.clientY];
      this.draw();
    });
    c.addEventListener("wheel", (e) => {
      e.preventDefault();
      const factor = Math.exp(-0.0015 * e.deltaY), box = c.getBoundingClientRect();
      const at = [e.clientX - box.left - box.width / 2, e.clientY - box.top - box.height / 2];
      this.move = this.move.map((m, a) => at[a] + (m - at[a]) * factor);
      this.zoom *= factor;
      this.draw();
    }, { passive: false });
    c.addEventListener("dblclick", () => this.home());
  }

  /** Draws the liquid of another run over this one; null for none. */
  over(mesh) {
    this.other = mesh && path(mesh);
    this.draw();
  }

  /** The number of the point of the contact line at a place of the window; null if there is none near. */
  pick(x, y) {
    if (!this.toWindow || !this.show.line) return null;
    let best = null, least = 14 ** 2;
    for (let i = 0; i < this.points.length; i += 3) {
      const [px, py] = this.toWindow(this.points[i], this.points[i + 1]);
      const far = (px - x) ** 2 + (py - y) ** 2;
      if (far < least) [best, least] = [i / 3, far];
    }
    return best;
  }

  set(frame) {
    this.liquid = path(seat(frame.liquid, frame.solids.map((s) => s.mesh), this.data.dx));
    this.bare = path(frame.liquid);
    this.solids = frame.solids.map((s) => path(s.mesh));
    this.named = frame.solids;
    this.points = frame.line?.positions ?? [];
    this.draw();
  }

  draw() {
    if (!this.liquid) return;
    const ratio = devicePixelRatio, c = this.canvas, g = c.getContext("2d");
    const width = c.clientWidth, height = c.clientHeight;
    if (!width || !height) return;
    c.width = Math.round(width * ratio);
    c.height = Math.round(height * ratio);
    const [x0, y0, x1, y1] = this.window;
    const scale = this.zoom * Math.min((width - 48) / (x1 - x0), (height - 104) / (y1 - y0));
    g.scale(ratio, ratio);
    g.save();
    g.translate(width / 2 + this.move[0], height / 2 + this.move[1]);
    g.scale(scale, -scale);
    g.translate(-(x0 + x1) / 2, -(y0 + y1) / 2);
    this.toWindow = (x, y) => [
      width / 2 + this.move[0] + scale * (x - (x0 + x1) / 2), height / 2 + this.move[1] - scale * (y - (y0 + y1) / 2)];
    this.shapes(g, scale);
    g.restore();
    this.bar(g, scale, width, height);
  }

  shapes(g, scale) {
    g.lineJoin = "round";
    const { domain } = this.data;
    const stroke = (shape, color, width) => { g.strokeStyle = color; g.lineWidth = width / scale; g.stroke(shape); };
    if (domain) {
      const walls = new Path2D();
      walls.rect(0, 0, domain[0], domain[1]);
      g.fillStyle = css("--air");
      g.fill(walls);
      stroke(walls, css("--quiet"), 1.5);
    }
    // What is wetted lies under the solids; without them the liquid is shown as it is.
    const liquid = this.show.solids ? this.liquid : this.bare;
    g.fillStyle = css("--liquid");
    g.fill(liquid, "evenodd");
    stroke(liquid, css("--liquid-edge"), 1.6);
    for (const solid of this.show.solids ? this.solids : []) {
      g.fillStyle = css("--solid");
      g.fill(solid, "evenodd");
      stroke(solid, css("--solid-edge"), 1.2);
    }
    if (this.show.solids && this.shade) this.shaded(g, scale);
    if (this.other) {
      g.setLineDash([7 / scale, 5 / scale]);
      stroke(this.other, css("--b"), 1.8);
      g.setLineDash([]);
    }
    for (let i = 0; this.show.line && i < this.points.length; i += 3) {
      const dot = new Path2D();
      dot.arc(this.points[i], this.points[i + 1], 4.5 / scale, 0, 2 * Math.PI);
      g.fillStyle = css("--line");
      g.fill(dot);
      stroke(dot, css("--air"), 1.2);
    }
  }

  /** Draws the edges of solids in the colours of their values. */
  shaded(g, scale) {
    const colors = palette(this.shade.name);
    g.lineWidth = 4 / scale;
    g.lineCap = "round";
    for (const solid of this.named) {
      const { positions: p, indices: e } = solid.mesh, places = placesOf(solid, this.shade, this.data.summary);
      for (let i = 0; places && i < e.length; i += 2) {
        g.strokeStyle = `rgb(${colors[(places[e[i]] + places[e[i + 1]]) >> 1]})`;
        g.beginPath();
        g.moveTo(p[3 * e[i]], p[3 * e[i] + 1]);
        g.lineTo(p[3 * e[i + 1]], p[3 * e[i + 1] + 1]);
        g.stroke();
      }
    }
  }

  bar(g, scale, width, height) {
    const length = round(0.22 * width / scale), x = width - 14 - length * scale, y = height - 12;
    g.strokeStyle = g.fillStyle = css("--ink");
    g.lineWidth = 1.5;
    g.beginPath();
    g.moveTo(x, y - 4); g.lineTo(x, y); g.lineTo(width - 14, y); g.lineTo(width - 14, y - 4);
    g.stroke();
    g.font = "12px system-ui, sans-serif";
    g.textAlign = "center";
    g.fillText(quantity(length, "m"), (x + width - 14) / 2, y - 6);
  }
}
