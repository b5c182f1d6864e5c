// Forces as arrows, axes of frames, and lines between two moving points.

import {
  BufferAttribute, BufferGeometry, ConeGeometry, CylinderGeometry, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshStandardMaterial, Vector3,
} from "three";
import { between } from "./data.js";

export const FORCES = { contact: "#b03a2e", reaction: "#6c3483" };
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

export class Links {
  constructor(told, root) {
    this.told = told;
    const geometry = new BufferGeometry();
    this.places = new BufferAttribute(new Float32Array(6 * told.length), 3);
    geometry.setAttribute("position", this.places);
    this.lines = new LineSegments(geometry, new LineBasicMaterial({ color: 0x7a4b1e }));
    this.lines.frustumCulled = false;
    root.add(this.lines);
  }

  update(instant) {
    this.told.forEach((link, i) => {
      [link.a, link.b].forEach((end, j) => this.places.array.set(between(end, instant, [0, 0, 0]), 6 * i + 3 * j));
    });
    this.places.needsUpdate = true;
  }
}
