// Meshes that are fixed in a frame, and those that deform in it by modes.

import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, LineBasicMaterial, LineSegments, Mesh, MeshStandardMaterial,
} from "three";
import { between } from "./data.js";
import { BARE } from "./colours.js";

const INK = new LineBasicMaterial({ color: 0x2a3440, transparent: true, opacity: 0.55 });
const FINE = new LineBasicMaterial({ color: 0x2a3440, transparent: true, opacity: 0.22 });
const DARK = 0.4; // light of the lowest place of a field of heights, of that of the highest

export class Part {
  constructor(told, colour, frame) {
    this.told = told;
    this.rest = told.points;
    this.points = new Float32Array(told.points);
    this.pointsAttribute = new BufferAttribute(this.points, 3);
    const geometry = new BufferGeometry();
    this.places = new BufferAttribute(new Float32Array(3 * told.vertices.length), 3);
    geometry.setAttribute("position", this.places);
    geometry.setIndex(new BufferAttribute(told.triangles, 1));
    this.geometry = geometry;
    this.plain = new Color(colour);
    this.material = new MeshStandardMaterial({
      color: colour, roughness: 0.62, metalness: 0.05, side: DoubleSide,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    });
    if (told.is_glass) Object.assign(this.material, { transparent: true, opacity: 0.22, depthWrite: false });
    if (told.is_endless) Object.assign(this.material, { transparent: true, opacity: 0.5, depthWrite: false });
    this.mesh = new Mesh(geometry, this.material);
    this.mesh.frustumCulled = false;
    this.creases = this.edges(told.creases, INK);
    this.lines = told.lines ? this.edges(told.lines, FINE) : null;
    if (this.lines) this.lines.visible = false;
    this.grid = told.grid ? this.edges(told.grid, FINE) : null;
    frame.add(...[this.mesh, this.creases, this.lines, this.grid].filter(Boolean));
    if (told.modes) this.prepareModes(told);
    if (told.shades) this.shade(told);
    this.fill();
  }

  edges(pairs, material) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.pointsAttribute);
    geometry.setIndex(new BufferAttribute(pairs, 1));
    const lines = new LineSegments(geometry, material);
    lines.frustumCulled = false;
    return lines;
  }

  prepareModes(told) {
    const count = this.rest.length / 3;
    this.amplitudes = new Float32Array(told.factors.length);
    this.moved = new Float32Array(3 * count);
    this.values = new Float32Array(count);
    this.stress = told.stresses ? new Float32Array(6 * count) : null;
    this.colours = new BufferAttribute(new Float32Array(3 * told.vertices.length), 3);
    this.geometry.setAttribute("color", this.colours);
  }

  // Heights from dark to light.
  shade(told) {
    const light = Float32Array.from(told.vertices, (point) => DARK + ((1 - DARK) * told.shades[point]) / 255);
    const colours = Float32Array.from({ length: 3 * light.length }, (_, i) => light[Math.floor(i / 3)]);
    this.geometry.setAttribute("color", new BufferAttribute(colours, 3));
    this.material.vertexColors = true;
  }

  get deforms() {
    return this.told.modes !== undefined;
  }

  // Put the points where they are at an instant; displacements are drawn larger by `scale`.
  deform(instant, scale) {
    between(this.told.amplitudes, instant, this.amplitudes);
    sum(this.told.modes, this.told.factors, this.amplitudes, this.moved);
    for (let i = 0; i < this.moved.length; i++) this.points[i] = this.rest[i] + scale * this.moved[i];
    this.fill();
  }

  fill() {
    copyRows(this.points, this.told.vertices, this.places.array);
    this.places.needsUpdate = true;
    this.pointsAttribute.needsUpdate = true;
    this.geometry.computeVertexNormals();
  }

  // Colour by a field: "displacement", "stress" or "none".
  colour(field, largest, table) {
    const isField = this.deforms && largest > 0 && (field === "displacement" || (field === "stress" && this.stress));
    if (this.material.vertexColors !== Boolean(isField)) {
      this.material.vertexColors = Boolean(isField);
      this.material.color.set(isField ? "#ffffff" : this.plain);
      this.material.needsUpdate = true;
    }
    if (!isField) return;
    if (field === "stress") {
      sum(this.told.stresses, this.told.stress_factors, this.amplitudes, this.stress);
      vonMises(this.stress, this.values);
    } else lengths(this.moved, this.values);
    const { vertices, bare } = this.told;
    const out = this.colours.array;
    for (let v = 0; v < vertices.length; v++) {
      const point = vertices[v];
      const isBare = field === "stress" && bare[point];
      const k = 3 * Math.min(255, Math.round((255 * this.values[point]) / largest));
      for (let c = 0; c < 3; c++) out[3 * v + c] = isBare ? BARE[c] : table[k + c];
    }
    this.colours.needsUpdate = true;
  }
}

// out = sum_i amplitudes_i factors_i shapes_i
function sum(shapes, factors, amplitudes, out) {
  const n = out.length;
  out.fill(0);
  for (let i = 0; i < amplitudes.length; i++) {
    const size = amplitudes[i] * factors[i];
    if (size === 0) continue;
    const start = i * n;
    for (let j = 0; j < n; j++) out[j] += size * shapes[start + j];
  }
}

function copyRows(rows, chosen, out) {
  for (let v = 0; v < chosen.length; v++) {
    const from = 3 * chosen[v];
    out[3 * v] = rows[from];
    out[3 * v + 1] = rows[from + 1];
    out[3 * v + 2] = rows[from + 2];
  }
}

function lengths(vectors, out) {
  for (let i = 0; i < out.length; i++) out[i] = Math.hypot(vectors[3 * i], vectors[3 * i + 1], vectors[3 * i + 2]);
}

function vonMises(s, out) {
  for (let i = 0; i < out.length; i++) {
    const [xx, yy, zz, yz, xz, xy] = [s[6 * i], s[6 * i + 1], s[6 * i + 2], s[6 * i + 3], s[6 * i + 4], s[6 * i + 5]];
    const normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2;
    out[i] = Math.sqrt(0.5 * normal + 3 * (yz * yz + xz * xz + xy * xy));
  }
}
