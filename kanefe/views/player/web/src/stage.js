// Light, camera, ground: what the scene stands in.

import {
  DirectionalLight, GridHelper, HemisphereLight, PerspectiveCamera, Quaternion, Scene, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

export class Stage {
  constructor(canvas, told, onChange) {
    this.told = told;
    this.up = new Vector3(...told.up);
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(32, 1, 0.001 * told.size, 50 * told.size);
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
    this.grid = this.ground();
    this.scene.add(this.grid);
  }

  // A grid of round steps below everything.
  ground() {
    const rough = (1.6 * this.told.size) / 20;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((n) => n * power >= rough);
    const grid = new GridHelper(20 * step, 20, 0xc2cad4, 0xdbe1e8);
    grid.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 1, 0), this.up));
    const low = new Vector3(...this.told.low).dot(this.up) > new Vector3(...this.told.high).dot(this.up) ? "high" : "low";
    grid.position.copy(this.up).multiplyScalar(new Vector3(...this.told[low]).dot(this.up) - 0.002 * this.told.size);
    return grid;
  }

  // Look at everything from a direction: "all", or along an axis.
  look(name) {
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
    const { low, high } = this.told;
    for (let i = 0; i < 8; i++) {
      const corner = new Vector3(...[0, 1, 2].map((c) => ((i >> c) & 1 ? high[c] : low[c])));
      const reach = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(top)) / tall);
      distance = Math.max(distance, reach + corner.dot(back));
    }
    this.controls.target.set(0, 0, 0);
    this.camera.position.copy(back).multiplyScalar(Math.max(distance, 0.1 * this.told.size));
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
