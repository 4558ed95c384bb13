// Undoes the packing of crates/view/src/page/packed_mesh.rs.

async function unzip(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function positions(bytes, n, box) {
  const out = new Float32Array(3 * n);
  for (let a = 0; a < 3; a++) {
    const low = box[a], step = (box[3 + a] - box[a]) / 65535, at = 40 + 2 * a * n;
    let value = 0;
    for (let v = 0; v < n; v++) {
      value = (value + bytes[at + v] + 256 * bytes[at + n + v]) & 65535;
      out[3 * v + a] = low + step * value;
    }
  }
  return out;
}

/** A mesh from its text: positions, indices, corners per element, kinds (or null), and places of values in their ranges. */
export async function decode(text) {
  const bytes = await unzip(text);
  const view = new DataView(bytes.buffer);
  if (view.getUint32(0, false) !== 0x4d455348) throw new Error("a mesh of this page cannot be read");
  const n = view.getUint32(4, true), elements = view.getUint32(8, true), flags = view.getUint32(12, true);
  const corners = flags & 255;
  const box = Array.from({ length: 6 }, (_, i) => view.getFloat32(16 + 4 * i, true));
  const indices = new Uint32Array(elements * corners);
  let at = 40 + 6 * n, last = 0;
  for (let i = 0; i < indices.length; i++) {
    let z = 0, scale = 1, byte;
    do {
      byte = bytes[at++];
      z += (byte & 127) * scale;
      scale *= 128;
    } while (byte > 127);
    last += z % 2 ? -(z + 1) / 2 : z / 2;
    indices[i] = last;
  }
  const take = (bit) => (flags & bit ? bytes.subarray(at, at += n) : null);
  const kinds = take(256), shades = [512, 1024, 2048, 4096].map(take);
  return { positions: positions(bytes, n, box), indices, corners, kinds, shades, box };
}

/** A text of the server. */
async function ask(address) {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${address}: ${answer.status} ${await answer.text()}`);
  return answer.text();
}

/** Frames on demand, the most recent ones kept. A mesh is a place in the data's list, or an address of the server. */
export class Frames {
  constructor(data, keep = 48) {
    this.data = data;
    this.keep = keep;
    this.meshes = new Map();
  }

  mesh(place) {
    if (place === null || place === undefined) return Promise.resolve(null);
    let mesh = this.meshes.get(place);
    if (mesh) this.meshes.delete(place);
    else mesh = typeof place === "string" ? ask(place).then(decode) : decode(this.data.meshes[place]);
    this.meshes.set(place, mesh);
    if (this.meshes.size > this.keep) this.meshes.delete(this.meshes.keys().next().value);
    return mesh;
  }

  async frame(i) {
    const f = this.data.frames[i];
    const names = Object.keys(f.solids);
    const [liquid, line, ...solids] = await Promise.all(
      [this.mesh(f.liquid), this.mesh(f.line), ...names.map((name) => this.mesh(f.solids[name]))]);
    return { liquid, line, solids: names.map((name, k) => ({ name, mesh: solids[k] })) };
  }
}

/** A solid larger than this many times the liquid is shown near the liquid only. */
const LARGE = 1.5;

const size = ({ low, high }) => Math.hypot(...high.map((h, a) => h - low[a]));

/** A box grown so that it holds another. */
const join = (box, low, high) => {
  box.low = box.low.map((l, a) => Math.min(l, low[a]));
  box.high = box.high.map((h, a) => Math.max(h, high[a]));
};

/**
 * The box about the liquid over all frames (a few of them), about solids of its size, and about what is near it of
 * larger ones: as the pictures of `meniscus render` frame it.
 */
export async function extent(frames) {
  const n = frames.data.frames.length, empty = () => ({ low: [1e30, 1e30, 1e30], high: [-1e30, -1e30, -1e30] });
  const liquid = empty(), solids = new Map();
  for (let k = 0; k < Math.min(n, 12); k++) {
    const frame = await frames.frame(Math.round(k * (n - 1) / Math.max(1, Math.min(n, 12) - 1)));
    if (frame.liquid.positions.length) join(liquid, frame.liquid.box.slice(0, 3), frame.liquid.box.slice(3));
    for (const { name, mesh: { box } } of frame.solids.filter((s) => s.mesh?.positions.length)) {
      const way = solids.get(name) ?? { ...empty(), size: 0 };
      join(way, box.slice(0, 3), box.slice(3));
      way.size = Math.max(way.size, size({ low: box.slice(0, 3), high: box.slice(3) }));
      solids.set(name, way);
    }
  }
  if (liquid.low[0] > liquid.high[0]) return { low: [0, 0, 0], high: frames.data.domain ?? [1, 1, 1] };
  const all = { ...liquid }, margin = 0.25 * size(liquid);
  for (const way of solids.values()) {
    const whole = way.size <= LARGE * size(liquid);
    const low = whole ? way.low : way.low.map((l, a) => Math.max(l, liquid.low[a] - margin));
    const high = whole ? way.high : way.high.map((h, a) => Math.min(h, liquid.high[a] + margin));
    if (low.every((l, a) => l <= high[a])) join(all, low, high);
  }
  return all;
}
