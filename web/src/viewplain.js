// A simple 3D drawing for browsers without WebGL: shaded triangles, far ones first; drag to turn.
import { css } from "./format.js";

export class ViewPlain {
  constructor(box, data, extent) {
    this.extent = extent;
    this.show = { line: true, solids: true };
    this.canvas = document.createElement("canvas");
    box.prepend(this.canvas);
    this.home();
    new ResizeObserver(() => this.draw()).observe(box);
    let last = null;
    this.canvas.addEventListener("pointerdown", (e) => { last = e; this.canvas.setPointerCapture(e.pointerId); });
    this.canvas.addEventListener("pointerup", () => { last = null; });
    this.canvas.addEventListener("pointermove", (e) => {
      if (!last) return;
      this.turn += 0.008 * (e.clientX - last.clientX);
      this.tilt = Math.max(-1.5, Math.min(1.5, this.tilt + 0.008 * (e.clientY - last.clientY)));
      last = e;
      this.draw();
    });
  }

  over() {}

  pick() {
    return null;
  }

  /** Takes the picture off the page. */
  remove() {
    this.canvas.remove();
  }

  home() {
    this.turn = 0.45;
    this.tilt = 0.35;
    this.draw();
  }

  set(frame) {
    this.frame = frame;
    this.draw();
  }

  draw() {
    const c = this.canvas, g = c.getContext("2d");
    if (!this.frame || !c.clientWidth) return;
    const ratio = devicePixelRatio, { low, high } = this.extent;
    c.width = Math.round(c.clientWidth * ratio);
    c.height = Math.round(c.clientHeight * ratio);
    const size = Math.hypot(...high.map((h, a) => h - low[a])) || 1;
    const scale = 0.8 * Math.min(c.width, c.height) / size;
    const middle = low.map((l, a) => (l + high[a]) / 2);
    const [ct, st, ce, se] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.tilt), Math.sin(this.tilt)];
    const place = (p, i) => {
      const [x, y, z] = [0, 1, 2].map((a) => p[3 * i + a] - middle[a]);
      const ahead = y * ct - x * st;
      return [c.width / 2 + scale * (x * ct + y * st), c.height / 2 - scale * (z * ce + ahead * se),
        ahead * ce - z * se];
    };
    const all = [];
    const add = (mesh, color, nearer) => {
      const points = Array.from({ length: mesh.positions.length / 3 }, (_, i) => place(mesh.positions, i));
      for (let i = 0; i < mesh.indices.length; i += 3) {
        const [p, q, r] = [0, 1, 2].map((k) => points[mesh.indices[i + k]]);
        const turn = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        if (turn > 0) continue;
        const slope = Math.abs(turn) / (Math.abs(turn) + scale * scale * 1e-9 + Math.hypot(
          (q[1] - p[1]) * (r[2] - p[2]) - (q[2] - p[2]) * (r[1] - p[1]),
          (q[2] - p[2]) * (r[0] - p[0]) - (q[0] - p[0]) * (r[2] - p[2])) * scale);
        all.push([p[2] + q[2] + r[2] - nearer, p, q, r, color, 30 + 40 * slope]);
      }
    };
    if (this.frame.liquid.corners === 3) add(this.frame.liquid, [208, 62], 0.3 * size);
    if (this.show.solids) this.frame.solids.forEach((s) => s.mesh.corners === 3 && add(s.mesh, [28, 26], 0));
    all.sort((a, b) => b[0] - a[0]);
    for (const [, p, q, r, [hue, tint], light] of all) {
      g.fillStyle = g.strokeStyle = `hsl(${hue} ${tint}% ${light}%)`;
      g.beginPath();
      g.moveTo(p[0], p[1]); g.lineTo(q[0], q[1]); g.lineTo(r[0], r[1]); g.closePath();
      g.fill();
      g.stroke();
    }
    this.lines(g, place, ratio);
  }

  lines(g, place, ratio) {
    const line = this.show.line && this.frame.line;
    if (!line) return;
    g.strokeStyle = css("--line");
    g.lineWidth = 2 * ratio;
    g.beginPath();
    for (let i = 0; i < line.indices.length; i += 2) {
      g.moveTo(...place(line.positions, line.indices[i]).slice(0, 2));
      g.lineTo(...place(line.positions, line.indices[i + 1]).slice(0, 2));
    }
    g.stroke();
  }
}
