// Forces as arrows, axes of frames, and lines over moving points.

import {
  ConeGeometry, CylinderGeometry, Group, InstancedMesh, Matrix4, Mesh, MeshStandardMaterial, Quaternion, Vector3,
} from "three";
import { between } from "./data.js";

export const FORCES = { contact: "#b03a2e", reaction: "#6c3483" };
export const LINK = "#7a4b1e";
const [TAUT, SLACK, GONE] = [0, 1, 2]; // states of a line
const MOST_DASHES = 60; // of a line between two points
const AXES = ["#c0392b", "#2e8b57", "#2c5fa8"];
const UP = new Vector3(0, 1, 0);
const SHAFT = new CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0);
const HEAD = new ConeGeometry(1, 1, 16).translate(0, -0.5, 0);

class Arrow {
  constructor(colour, width, options = {}) {
    const material = new MeshStandardMaterial({ color: colour, roughness: 0.6, ...options });
    this.width = width;
    this.shaft = new Mesh(SHAFT, material);
    this.head = new Mesh(HEAD, material);
    this.group = new Group();
    this.group.add(this.shaft, this.head);
  }

  point(direction, length) {
    const head = Math.min(6 * this.width, 0.6 * length);
    this.group.visible = length > 0.2 * this.width;
    if (!this.group.visible) return;
    this.group.quaternion.setFromUnitVectors(UP, direction);
    this.shaft.scale.set(this.width, length - head, this.width);
    this.head.position.set(0, length, 0);
    this.head.scale.set(2.4 * this.width, head, 2.4 * this.width);
  }
}

export function triad(length) {
  const group = new Group();
  AXES.forEach((colour, i) => {
    const arrow = new Arrow(colour, 0.022 * length);
    arrow.point(new Vector3().setComponent(i, 1), length);
    group.add(arrow.group);
  });
  return group;
}

export class Force {
  constructor(told, size, largest, root) {
    this.told = told;
    this.unit = (0.22 * size) / (largest || 1);
    // forces act inside of what they act on: they are seen through it
    this.arrow = new Arrow(FORCES[told.kind], 0.0032 * size, { depthTest: false, transparent: true, opacity: 0.85 });
    for (const part of this.arrow.group.children) part.renderOrder = 1;
    this.vector = [0, 0, 0];
    this.place = [0, 0, 0];
    root.add(this.arrow.group);
  }

  update(instant, factor, isShown) {
    between(this.told.f, instant, this.vector);
    between(this.told.p, instant, this.place);
    const force = new Vector3(...this.vector);
    const length = force.length() * this.unit * factor;
    this.arrow.group.position.set(...this.place);
    if (length > 0) this.arrow.point(force.normalize(), length);
    this.arrow.group.visible &&= isShown && length > 0;
  }
}

// Springs, ropes and the like: a thin rod from each end to the next; of what is slack dashes, of what has broken nothing.
export class Links {
  constructor(told, size, root) {
    this.told = told;
    this.width = 0.0022 * size;
    this.dash = 0.02 * size;
    this.points = told.map((link) => new Float32Array(3 * link.p.shape[1]));
    const most = told.reduce((sum, link) => sum + MOST_DASHES * (link.p.shape[1] - 1), 0);
    this.rods = new InstancedMesh(SHAFT, new MeshStandardMaterial({ color: LINK, roughness: 0.7 }), Math.max(most, 1));
    this.rods.frustumCulled = false;
    root.add(this.rods);
  }

  update(instant) {
    let count = 0;
    const [from, to, turn, place] = [new Vector3(), new Vector3(), new Quaternion(), new Matrix4()];
    this.told.forEach((link, i) => {
      const points = between(link.p, instant, this.points[i]);
      const state = link.states ? link.states[instant.row] : TAUT;
      if (state === GONE) return;
      for (let k = 3; k < points.length; k += 3) {
        from.fromArray(points, k - 3);
        to.fromArray(points, k).sub(from);
        const length = to.length();
        if (!(length > 0)) continue;
        turn.setFromUnitVectors(UP, to.divideScalar(length));
        const dashes = state === SLACK ? Math.min(Math.max(Math.round((0.5 * length) / this.dash), 1), MOST_DASHES) : 1;
        const share = state === SLACK ? 0.5 : 1;
        for (let j = 0; j < dashes; j++) {
          const start = from.clone().addScaledVector(to, ((j + 0.5 * (1 - share)) * length) / dashes);
          place.compose(start, turn, new Vector3(this.width, (share * length) / dashes, this.width));
          this.rods.setMatrixAt(count++, place);
        }
      }
    });
    this.rods.count = count;
    this.rods.instanceMatrix.needsUpdate = true;
  }
}
