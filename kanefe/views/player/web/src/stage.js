// Light, camera, ground: what the scene stands in.

import {
  BufferGeometry, DirectionalLight, Float32BufferAttribute, HemisphereLight, LineBasicMaterial, LineSegments,
  PerspectiveCamera, Quaternion, Scene, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

export class Stage {
  constructor(canvas, told, onChange) {
    this.told = told;
    this.up = new Vector3(...told.up);
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(32, 1, 0.001 * told.size, Math.max(50 * told.size, 5 * told.reach));
    this.camera.up.copy(this.up);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", onChange);
    this.controls.zoomToCursor = true;
    const sun = new DirectionalLight(0xffffff, 1.7);
    sun.position.set(-0.5, 0.8, 1);
    this.camera.add(sun);
    const sky = new HemisphereLight(0xffffff, 0xb9c0ca, 1.9);
    sky.position.copy(this.up);
    this.scene.add(this.camera, sky);
    this.go(Boolean(told.travel));
  }

  // Look at what travels, from now on, or at the whole.
  go(travels) {
    this.travels = travels;
    this.box = travels ? this.told.travel : this.told;
    if (this.grid) this.scene.remove(this.grid);
    this.grid = this.ground();
    this.scene.add(this.grid);
  }

  // A grid of round steps below everything.
  ground() {
    const rough = (1.6 * (this.travels ? this.told.size : this.told.reach)) / 20;
    const power = 10 ** Math.floor(Math.log10(rough));
    this.step = power * [1, 2, 5, 10].find((n) => n * power >= rough);
    const level = this.level();
    const grid = lattice(this.travels ? 60 : 20, this.step, level === null ? 0xd3dae2 : 0xadb6c1);
    grid.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 1, 0), this.up));
    const low = new Vector3(...this.told.low).dot(this.up) > new Vector3(...this.told.high).dot(this.up) ? "high" : "low";
    const below = new Vector3(...this.told[low]).dot(this.up) - 0.002 * this.told.size;
    this.floor = this.up.clone().multiplyScalar(level === null ? below : level + 0.001 * this.told.size);
    grid.position.copy(this.floor);
    return grid;
  }

  // Height of a level plane without end, on which the grid lies; null: there is none.
  level() {
    for (const part of this.told.bodies.flatMap((body) => (body.kind === "ground" ? body.parts : []))) {
      const heights = [0, 3, 6, 9].map((i) => new Vector3().fromArray(part.points, i).dot(this.up));
      if (part.is_endless && Math.max(...heights) - Math.min(...heights) < 1e-4 * this.told.size) return heights[0];
    }
    return null;
  }

  // Keep the grid below the place that is looked at: its lines stay where they are.
  keepGrid() {
    if (!this.travels) return;
    const at = this.controls.target.clone().divideScalar(this.step).round().multiplyScalar(this.step);
    this.grid.position.copy(at.addScaledVector(this.up, -at.dot(this.up)).add(this.floor));
  }

  // Look at everything, or at what travels and is at a place, from a direction: "all", or along an axis.
  look(name, place = new Vector3()) {
    const axis = Math.abs(this.up.y) > 0.5 ? new Vector3(0.35, 0.3, 1) : new Vector3(0.75, -1.2, 0.65);
    const from = { x: new Vector3(1, 0, 0), y: new Vector3(0, -1, 0), z: new Vector3(0, 0, 1) }[name] ?? axis;
    const back = from.clone().normalize();
    // an eye right above would not know which way is up
    if (Math.abs(back.dot(this.up)) > 0.999) back.addScaledVector(new Vector3(0, -1, 0), 1e-3).normalize();
    const right = new Vector3().crossVectors(this.up, back).normalize();
    const top = new Vector3().crossVectors(back, right);
    const half = Math.tan((0.5 * this.camera.fov * Math.PI) / 180) * 0.88;
    const tall = half * this.free.tall;
    const wide = half * this.camera.aspect * this.free.wide;
    let distance = 0;
    const { low, high } = this.box;
    const middle = new Vector3(...low).add(new Vector3(...high)).multiplyScalar(0.5);
    for (let i = 0; i < 8; i++) {
      const corner = new Vector3(...[0, 1, 2].map((c) => ((i >> c) & 1 ? high[c] : low[c]))).sub(middle);
      const reach = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(top)) / tall);
      distance = Math.max(distance, reach + corner.dot(back));
    }
    this.controls.target.copy(middle).add(place);
    this.camera.position.copy(back).multiplyScalar(Math.max(distance, 0.1 * this.told.size)).add(this.controls.target);
    this.controls.update();
  }

  // Move eye and target with something that is followed.
  shift(by) {
    this.camera.position.add(by);
    this.controls.target.add(by);
    this.controls.update();
  }

  // Fill the canvas; the middle of the view is that of what is free of controls: `side` at the right, `foot` below.
  fit(side, foot) {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.free = { wide: Math.max(1 - side / width, 0.4), tall: Math.max(1 - foot / height, 0.4) };
    this.camera.setViewOffset(width, height, side / 2, foot / 2, width, height);
    this.camera.updateProjectionMatrix();
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
  }
}

// A square grid of so many cells about the origin, across y; each side of a cell is a line of its own, since lines that
// reach behind the eye are not drawn everywhere.
function lattice(count, step, colour) {
  const places = [];
  for (let i = 0; i <= count; i++) {
    for (let j = 0; j < count; j++) {
      const [fixed, from, to] = [i, j, j + 1].map((n) => (n - count / 2) * step);
      places.push(fixed, 0, from, fixed, 0, to, from, 0, fixed, to, 0, fixed);
    }
  }
  const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(places, 3));
  return new LineSegments(geometry, new LineBasicMaterial({ color: colour }));
}
