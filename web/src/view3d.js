import {
  ACESFilmicToneMapping, AdditiveBlending, BackSide, BoxGeometry, BufferAttribute, BufferGeometry, CanvasTexture,
  Color, DirectionalLight, EdgesGeometry, Group, HemisphereLight, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, MeshPhysicalMaterial, MeshStandardMaterial, PCFShadowMap, PerspectiveCamera, PlaneGeometry,
  PMREMGenerator, RepeatWrapping, Scene, ShadowMaterial, SRGBColorSpace, SphereGeometry, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { toCreasedNormals } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { css, round } from "./format.js";
import { palette, placesOf } from "./shade.js";

const SOLIDS = ["#b08d72", "#8a9aa8", "#92a57f", "#bda06a", "#a58aa5"];

/** A studio with a few lamps, as light for reflections. */
function studio(renderer) {
  const scene = new Scene();
  const dome = new Mesh(new SphereGeometry(10, 32, 16), new MeshBasicMaterial({ side: BackSide, vertexColors: true }));
  const p = dome.geometry.attributes.position, colors = new Float32Array(3 * p.count);
  for (let i = 0; i < p.count; i++) {
    const up = p.getZ(i) / 10, glow = Math.exp(-6 * up * up), c = new Color();
    c.setRGB(0.18 + 0.62 * glow, 0.21 + 0.64 * glow, 0.26 + 0.66 * glow);
    if (up < -0.2) c.multiplyScalar(0.75);
    c.toArray(colors, 3 * i);
  }
  dome.geometry.setAttribute("color", new BufferAttribute(colors, 3));
  scene.add(dome);
  const lamp = (x, y, z, w, h, strength) => {
    const material = new MeshBasicMaterial({ color: new Color(strength, strength, strength), blending: AdditiveBlending });
    const mesh = new Mesh(new BoxGeometry(w, h, 0.1), material);
    mesh.position.set(x, y, z);
    mesh.lookAt(0, 0, 0);
    scene.add(mesh);
  };
  lamp(-4, -3, 6, 3.4, 3.4, 14);
  lamp(6, 2, 3, 1.2, 5, 8);
  lamp(-2, 7, 4, 4, 1.4, 6);
  const maker = new PMREMGenerator(renderer);
  const texture = maker.fromScene(scene, 0.02).texture;
  maker.dispose();
  return texture;
}

/** A tile of two by two squares. */
function tile() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 128;
  const g = canvas.getContext("2d");
  g.fillStyle = css("--ground-a");
  g.fillRect(0, 0, 128, 128);
  g.fillStyle = css("--ground-b");
  g.fillRect(0, 0, 64, 64);
  g.fillRect(64, 64, 64, 64);
  const texture = new CanvasTexture(canvas);
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.colorSpace = SRGBColorSpace;
  texture.anisotropy = 8;
  return texture;
}

/** A round fade, opaque in the middle. */
function fade() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 256;
  const g = canvas.getContext("2d"), shade = g.createRadialGradient(128, 128, 20, 128, 128, 128);
  shade.addColorStop(0, "#fff");
  shade.addColorStop(1, "#000");
  g.fillStyle = shade;
  g.fillRect(0, 0, 256, 256);
  return new CanvasTexture(canvas);
}

export class View3D {
  constructor(box, data, extent) {
    this.renderer = new WebGLRenderer({ antialias: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.toneMapping = ACESFilmicToneMapping;
    this.renderer.toneMappingExposure = 1.05;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.box = box;
    this.data = data;
    this.show = { line: true, solids: true };
    this.colorable = true;
    this.shade = null;
    box.prepend(this.renderer.domElement);
    this.scene = new Scene();
    this.scene.environment = studio(this.renderer);
    this.camera = new PerspectiveCamera(30, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.measure(data, extent);
    this.world = new Group();
    this.world.scale.setScalar(1 / this.unit);
    this.world.position.set(-this.middle[0] / this.unit, -this.middle[1] / this.unit, -this.floor / this.unit);
    this.scene.add(this.world);
    this.surroundings(data);
    this.contents();
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = true;
    this.controls.addEventListener("change", () => this.ask());
    this.home();
    new ResizeObserver(() => this.resize()).observe(box);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.colors(); this.ask(); });
  }

  measure(data, { low, high }) {
    const size = Math.hypot(...high.map((h, a) => h - low[a])) || 1;
    this.floor = data.domain ? Math.min(0, low[2]) : low[2];
    this.bottom = low[2] - this.floor < 0.35 * size ? this.floor : low[2];
    this.unit = size;
    this.middle = low.map((l, a) => (l + high[a]) / 2);
    this.target = new Vector3(0, 0, ((this.bottom + high[2]) / 2 - this.floor) / size);
    this.radius = 0.5 * Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - this.bottom) / size;
    this.grid = round(0.22 * size);
  }

  surroundings(data) {
    this.ground = new Mesh(new PlaneGeometry(16, 16),
      new MeshBasicMaterial({ map: tile(), alphaMap: fade(), transparent: false, alphaHash: false, toneMapped: false }));
    this.ground.material.onBeforeCompile = (shader) => {
      shader.uniforms.far = { value: this.scene.background };
      shader.fragmentShader = shader.fragmentShader
        .replace("#include <common>", "#include <common>\nuniform vec3 far;")
        .replace("#include <alphamap_fragment>",
          "diffuseColor.rgb = mix(far, diffuseColor.rgb, pow(texture2D(alphaMap, vAlphaMapUv).g, 1.6));");
    };
    this.ground.material.map.repeat.setScalar(8 * this.unit / this.grid);
    this.ground.position.z = -1e-3;
    this.scene.add(this.ground);
    const shadow = new Mesh(new PlaneGeometry(16, 16), new ShadowMaterial({ opacity: 0.2 }));
    shadow.position.z = -5e-4;
    shadow.receiveShadow = true;
    shadow.renderOrder = 1;
    this.scene.add(shadow);
    const sun = new DirectionalLight("#fff6ea", 1.6);
    sun.position.set(-1.1, -0.4, 2.4).add(this.target);
    sun.target.position.copy(this.target);
    sun.castShadow = true;
    sun.shadow.mapSize.set(1024, 1024);
    sun.shadow.radius = 9;
    sun.shadow.bias = -5e-4;
    sun.shadow.normalBias = 0.01;
    Object.assign(sun.shadow.camera, { left: -1.6, right: 1.6, top: 1.6, bottom: -1.6, near: 0.1, far: 8 });
    this.scene.add(sun, sun.target, new HemisphereLight("#ffffff", "#8a8f96", 0.35));
    if (data.domain) {
      const edges = new LineSegments(new EdgesGeometry(new BoxGeometry(...data.domain)), new LineBasicMaterial({ transparent: true }));
      edges.position.set(...data.domain.map((d) => d / 2));
      this.edges = edges;
      this.world.add(edges);
    }
    this.scene.background = new Color();
    this.colors();
  }

  colors() {
    this.scene.background.set(css("--backdrop"));
    this.ground.material.map.dispose();
    const repeat = this.ground.material.map.repeat.x;
    this.ground.material.map = tile();
    this.ground.material.map.repeat.setScalar(repeat);
    if (this.edges) {
      this.edges.material.color.set(css("--quiet"));
      this.edges.material.opacity = 0.45;
    }
  }

  contents() {
    const liquid = new MeshPhysicalMaterial({
      color: "#ffffff", transmission: 1, roughness: 0.02, ior: 1.33, thickness: 0.35 * this.unit, specularIntensity: 1,
      attenuationColor: new Color("#5fb7e6"), attenuationDistance: 0.55, envMapIntensity: 1.1,
    });
    this.liquid = new Mesh(new BufferGeometry(), liquid);
    this.liquid.castShadow = true;
    this.world.add(this.liquid);
    this.solids = new Map();
    this.line = new LineSegments2(new LineSegmentsGeometry(), new LineMaterial({ color: css("--line"), linewidth: 3 }));
    // A little nearer than it is, so that the drop's own surface does not hide half of it.
    Object.assign(this.line.material, { polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -4000 });
    this.line.frustumCulled = false;
    this.world.add(this.line);
    const other = new MeshBasicMaterial({ color: css("--b"), transparent: true, opacity: 0.35, depthWrite: false });
    this.other = new Mesh(new BufferGeometry(), other);
    this.world.add(this.other);
  }

  /** Draws the liquid of another run over this one; null for none. */
  over(mesh) {
    this.other.geometry.dispose();
    this.other.geometry = mesh?.corners === 3 ? this.geometry(mesh, false) : new BufferGeometry();
    this.ask();
  }

  /** The number of the point of the contact line at a place of the window; null if there is none near. */
  pick(x, y) {
    if (!this.points || !this.show.line) return null;
    const { clientWidth: width, clientHeight: height } = this.box, p = new Vector3();
    this.world.updateMatrixWorld();
    let best = null, least = 14 ** 2;
    for (let i = 0; i < this.points.length; i += 3) {
      p.fromArray(this.points, i).applyMatrix4(this.world.matrixWorld).project(this.camera);
      const far = ((p.x + 1) * width / 2 - x) ** 2 + ((1 - p.y) * height / 2 - y) ** 2;
      if (p.z < 1 && far < least) [best, least] = [i / 3, far];
    }
    return best;
  }

  /** A mesh's geometry; `crease` keeps edges sharp, `colors` are those of its vertices. */
  geometry(mesh, crease, colors) {
    const g = new BufferGeometry();
    g.setAttribute("position", new BufferAttribute(mesh.positions, 3));
    if (colors) g.setAttribute("color", new BufferAttribute(colors, 3));
    g.setIndex(new BufferAttribute(mesh.indices, 1));
    if (crease) return toCreasedNormals(g, 0.6);
    g.computeVertexNormals();
    return g;
  }

  set(frame) {
    this.liquid.geometry.dispose();
    this.liquid.geometry = frame.liquid.corners === 3 ? this.geometry(frame.liquid, false) : new BufferGeometry();
    const names = new Set(frame.solids.map((s) => s.name));
    for (const [name, gone] of [...this.solids].filter(([name]) => !names.has(name))) {
      this.world.remove(gone);
      this.solids.delete(name);
    }
    for (const { name, mesh } of frame.solids) this.solid(name, mesh);
    const line = frame.line;
    this.hasLine = Boolean(line?.indices.length);
    this.points = line?.positions;
    if (this.hasLine) {
      const points = new Float32Array(3 * line.indices.length);
      line.indices.forEach((v, k) => points.set(line.positions.subarray(3 * v, 3 * v + 3), 3 * k));
      this.line.geometry.dispose();
      this.line.geometry = new LineSegmentsGeometry().setPositions(points);
    }
    this.draw();
  }

  solid(name, mesh) {
    let solid = this.solids.get(name);
    if (!solid) {
      const color = SOLIDS[this.solids.size % SOLIDS.length];
      solid = new Mesh(new BufferGeometry(), new MeshStandardMaterial({ color, roughness: 0.85, side: 2, envMapIntensity: 0.7 }));
      solid.userData.color = color;
      solid.castShadow = solid.receiveShadow = true;
      this.solids.set(name, solid);
      this.world.add(solid);
    }
    if ((solid.userData.mesh === mesh && solid.userData.shade === this.shade) || mesh.corners !== 3) return;
    Object.assign(solid.userData, { mesh, shade: this.shade });
    const colors = this.vertexColors(name, mesh);
    solid.material.vertexColors = Boolean(colors);
    solid.material.color.set(colors ? "#ffffff" : solid.userData.color);
    solid.material.needsUpdate = true;
    solid.geometry.dispose();
    solid.geometry = this.geometry(mesh, true, colors);
  }

  /** The colours of a solid's vertices, linear; null where it has its own colour. */
  vertexColors(name, mesh) {
    const places = placesOf({ name, mesh }, this.shade, this.data.summary);
    if (!places) return null;
    const all = palette(this.shade.name).map((rgb) => new Color().setRGB(...rgb.map((x) => x / 255), "srgb"));
    const out = new Float32Array(3 * places.length);
    places.forEach((place, v) => all[place].toArray(out, 3 * v));
    return out;
  }

  /** Takes the picture off the page. */
  remove() {
    this.renderer.domElement.remove();
    this.renderer.dispose();
  }

  home() {
    const distance = 1.25 * this.radius / Math.sin(15 * Math.PI / 180);
    const [az, el] = [25, 18].map((d) => d * Math.PI / 180);
    const back = new Vector3(Math.sin(az) * Math.cos(el), -Math.cos(az) * Math.cos(el), Math.sin(el));
    this.controls.target.copy(this.target);
    this.camera.position.copy(this.target).addScaledVector(back, distance);
    this.controls.update();
    this.ask();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.fov = width < height ? 30 * Math.min(1.8, height / width) : 30;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** Draws before the next repaint. */
  ask() {
    if (this.asked) return;
    this.asked = requestAnimationFrame(() => {
      this.asked = 0;
      this.controls.update();
      this.draw();
    });
  }

  draw() {
    this.line.visible = this.show.line && Boolean(this.hasLine);
    for (const solid of this.solids.values()) solid.visible = this.show.solids;
    this.renderer.render(this.scene, this.camera);
  }
}

