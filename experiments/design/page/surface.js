/* The surface in three dimensions, cut exactly where the cameras that see it change. */
import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Mesh, MeshLambertMaterial,
  PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from "./three.module.min.js";
import { OrbitControls } from "./OrbitControls.js";
import { element, patch, svg } from "./parts.js";

const RECONSTRUCTED = 2 ** 30, COUNTED = 2 ** 31;

/* What the server packs: see packed_surface there. */
function unpacked(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let at = 4 + length;
  const take = (kind, count) => {
    const part = new kind(buffer, at, count);
    at += part.byteLength;
    return part;
  };
  return {
    head, vertices: take(Float32Array, 3 * head.vertices), corners: take(Uint32Array, 3 * head.triangles),
    seen: take(Uint32Array, head.triangles), errors: take(Float32Array, head.triangles),
  };
}

export class Surface {
  constructor(place, legend, choice) {
    this.place = place;
    this.legend = legend;
    this.choice = choice;
    this.data = null;
    this.name(0);
    choice.addEventListener("change", () => this.paint());
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(35, 1, 0.1, 10000);
    this.light = new DirectionalLight(0xffffff, 1.1);
    this.scene.add(new AmbientLight(0xffffff, 2.2), this.camera);
    this.camera.add(this.light);
    this.light.position.set(-0.4, 0.5, 1);
    this.material = new MeshLambertMaterial({ vertexColors: true, side: DoubleSide, flatShading: true });
    this.mesh = new Mesh(new BufferGeometry(), this.material);
    this.mesh.frustumCulled = false;
    this.scene.add(this.mesh);
    try {
      this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    } catch (fault) {
      place.textContent = `The surface cannot be drawn by this browser: ${fault.message}. All else works.`;
      return;
    }
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    place.append(this.renderer.domElement);
    new ResizeObserver(() => this.resize()).observe(place);
  }

  /* The colourings there are, for so many cameras. */
  name(n) {
    if (this.named === n) return;
    this.named = n;
    const before = this.choice.value || "views";
    const choices = [["views", "by number of views"], ["error", "by predicted error"]];
    for (let i = 0; i < n; i += 1) choices.push([String(i), `what camera ${i + 1} sees`]);
    this.choice.replaceChildren(...choices.map(([value, words]) => element("option", { value }, words)));
    this.choice.value = choices.some(([value]) => value === before) ? before : "views";
  }

  show(buffer) {
    const before = this.data && JSON.stringify(this.data.head.frame);
    this.data = unpacked(buffer);
    /* The ring may have been put elsewhere. */
    const isFirst = before === null, isMoved = before !== JSON.stringify(this.data.head.frame);
    const { corners, vertices } = this.data, places = new Float32Array(3 * corners.length);
    for (let i = 0; i < corners.length; i += 1) {
      for (let k = 0; k < 3; k += 1) places[3 * i + k] = vertices[3 * corners[i] + k];
    }
    this.mesh.geometry.dispose();
    this.mesh.geometry = new BufferGeometry();
    this.mesh.geometry.setAttribute("position", new BufferAttribute(places, 3));
    this.paint();
    if (isFirst && this.renderer) {
      this.controls = new OrbitControls(this.camera, this.renderer.domElement);
      this.controls.addEventListener("change", () => this.draw());
    }
    if (isMoved) this.fromAbove();
  }

  fromAbove() {
    if (!this.data || !this.controls) return;
    const { head, seen, corners, vertices } = this.data;
    const [, ahead, axis] = head.frame.map((one) => new Vector3(...one));
    const low = new Vector3(Infinity, Infinity, Infinity), high = low.clone().negate(), point = new Vector3();
    const isSeen = seen.some((one) => (one & (RECONSTRUCTED - 1)) !== 0);
    seen.forEach((one, i) => {
      if (isSeen && (one & (RECONSTRUCTED - 1)) === 0) return;
      for (let k = 0; k < 3; k += 1) {
        point.fromArray(vertices, 3 * corners[3 * i + k]);
        low.min(point);
        high.max(point);
      }
    });
    const middle = low.clone().add(high).multiplyScalar(0.5), size = high.distanceTo(low);
    this.camera.up.copy(axis);
    this.camera.position.copy(middle).addScaledVector(ahead, -0.35 * size).addScaledVector(axis, 1.35 * size);
    this.camera.near = size / 100;
    this.camera.far = 20 * size;
    this.controls.target.copy(middle);
    this.controls.update();
    this.resize();
  }

  colours() {
    const { head, seen, errors } = this.data, linear = (text) => new Color(text);
    const shades = head.shades.map(([, colour]) => linear(colour)), most = head.most, all = RECONSTRUCTED - 1;
    const [near, uncounted, sees, misses] = shades.slice(most + 1), chosen = this.choice.value;
    const used = new Set();
    const pick = (index) => { used.add(index); return shades[index]; };
    if (chosen === "error") {
      const ramp = head.ramp.map(linear), finite = errors.filter((one) => Number.isFinite(one)).sort();
      const least = finite[Math.floor(0.02 * finite.length)] ?? 0, greatest = finite[Math.floor(0.98 * finite.length)] ?? 1;
      this.span = [least, greatest];
      const scale = (ramp.length - 1) / Math.max(greatest - least, 1e-12);
      return [(i) => {
        if (seen[i] < COUNTED) return pick(most + 2);
        if (!Number.isFinite(errors[i])) return pick(most + 4);
        return ramp[Math.min(ramp.length - 1, Math.max(0, Math.round((errors[i] - least) * scale)))];
      }, used];
    }
    if (chosen !== "views") {
      const bit = 1 << Number(chosen);
      return [(i) => (seen[i] < COUNTED ? pick(most + 2) : seen[i] & bit ? pick(most + 3) : pick(most + 4)), used];
    }
    return [(i) => {
      if (seen[i] < COUNTED) return pick(most + 2);
      let count = 0;
      for (let bits = seen[i] & all; bits; bits &= bits - 1) count += 1;
      if (count >= head.threshold && (seen[i] & RECONSTRUCTED) === 0) return pick(most + 1);
      return pick(Math.min(count, most));
    }, used];
  }

  paint() {
    if (!this.data) return;
    const [colourOf, used] = this.colours(), n = this.data.head.triangles, colours = new Float32Array(9 * n);
    for (let i = 0; i < n; i += 1) {
      const colour = colourOf(i);
      for (let k = 0; k < 3; k += 1) colour.toArray(colours, 9 * i + 3 * k);
    }
    this.mesh.geometry.setAttribute("color", new BufferAttribute(colours, 3));
    const { head } = this.data, isError = this.choice.value === "error";
    const items = [...used].sort((a, b) => a - b).map((index) => {
      const [words, colour] = head.shades[index];
      return element("li", {}, patch(colour), isError && index === head.most + 4 ? "not reconstructed" : words);
    });
    if (isError) items.unshift(this.ramp(head));
    this.legend.replaceChildren(...items);
    this.place.dataset.triangles = String(n);
    this.draw();
  }

  ramp(head) {
    const width = 100 / head.ramp.length;
    const bar = svg("svg", { viewBox: "0 0 100 10", preserveAspectRatio: "none", "aria-hidden": "true" });
    head.ramp.forEach((colour, i) => bar.append(svg("rect", { x: i * width, width: width + 0.1, height: 10, fill: colour })));
    const item = element("li", { className: "ramp" }, `predicted ${head.of} error: ${this.span[0].toFixed(4)} mm`, bar, `${this.span[1].toFixed(4)} mm`);
    return item;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (!this.renderer || !width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    if (!this.renderer || this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.renderer.render(this.scene, this.camera);
    });
  }
}
