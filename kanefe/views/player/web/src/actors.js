// Everything of the run that moves, at any time of it.

import { BufferGeometry, Float32BufferAttribute, Group, Line, LineBasicMaterial, Quaternion, Vector3 } from "three";
import { between, instantAt } from "./data.js";
import { Force, Links, triad } from "./arrows.js";
import { BODIES, GROUND, table } from "./colours.js";
import { Part } from "./parts.js";

const TABLES = { displacement: table("displacement"), stress: table("stress") };

export class Actors {
  constructor(told, root) {
    this.told = told;
    this.frames = told.frames.map(() => new Group());
    this.fixed = new Group();
    root.add(...this.frames, this.fixed);
    let number = 0;
    this.bodies = told.bodies.map((body) => {
      const colour = body.kind === "ground" ? GROUND : BODIES[number++ % BODIES.length];
      const parts = body.parts.map((part) => new Part(part, part.is_endless ? GROUND : colour, this.group(part.frame)));
      const axes = triad(0.09 * told.size);
      this.group(body.frame).add(axes);
      const stick = body.stick ? this.stick(body, colour) : null;
      return { name: body.name, kind: body.kind, frame: body.frame, colour, parts, axes, stick, isShown: true };
    });
    this.groundAxes = triad(0.12 * told.size);
    this.groundAxes.position.set(...told.origin).negate();
    root.add(this.groundAxes);
    const largest = Math.max(0, ...told.arrows.map((arrow) => arrow.largest));
    this.forces = told.arrows.map((arrow) => new Force(arrow, told.size, largest, root));
    this.links = new Links(told.links, told.size, root);
  }

  group(frame) {
    return frame < 0 ? this.fixed : this.frames[frame];
  }

  stick(body, colour) {
    const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute([0, 0, 0, ...body.stick], 3));
    const line = new Line(geometry, new LineBasicMaterial({ color: colour }));
    this.group(body.frame).add(line);
    return line;
  }

  // Put everything where it is at time t.
  update(t, view) {
    const instant = instantAt(this.told.times, t);
    const place = [0, 0, 0];
    const one = new Quaternion();
    const two = new Quaternion();
    this.told.frames.forEach(({ p, e }, i) => {
      this.frames[i].position.set(...between(p, instant, place));
      const next = Math.min(instant.row + 1, e.shape[0] - 1);
      one.set(e[4 * instant.row + 1], e[4 * instant.row + 2], e[4 * instant.row + 3], e[4 * instant.row]);
      two.set(e[4 * next + 1], e[4 * next + 2], e[4 * next + 3], e[4 * next]);
      this.frames[i].quaternion.slerpQuaternions(one, two, instant.share).normalize();
    });
    const field = view.colour;
    for (const body of this.bodies) {
      for (const part of body.parts) {
        const isShown = body.isShown && (view.surfaces || !part.told.surface);
        part.mesh.visible = isShown;
        part.creases.visible = isShown && !(part.lines && view.mesh);
        if (part.lines) part.lines.visible = isShown && view.mesh;
        if (part.grid) part.grid.visible = isShown;
        if (part.deforms && isShown) {
          part.deform(instant, view.scale);
          part.colour(field, this.told.largest[field] ?? 0, TABLES[field]);
        }
      }
      body.axes.visible = body.isShown && (view.axes || body.kind === "frame");
      if (body.stick) body.stick.visible = body.isShown;
    }
    this.groundAxes.visible = view.axes;
    for (const force of this.forces) force.update(instant, view.force, view[force.told.kind]);
    this.links.update(instant);
    this.links.rods.visible = view.links;
  }

  // Where the middle of what travels is at time t, from the middle of the scene.
  travelled(t) {
    return new Vector3(...between(this.told.travel.p, instantAt(this.told.times, t), [0, 0, 0]));
  }

  // Where the name of a body stands.
  anchor(body) {
    const group = this.group(body.frame);
    group.updateMatrixWorld(true);
    const part = body.parts[0];
    if (!part) return group.getWorldPosition(new Vector3());
    part.anchor ??= middle(part.rest);
    return part.anchor.clone().applyMatrix4(group.matrixWorld);
  }

  // Positions in N of the points of a body's first part, as numbers: for checks.
  positions(name) {
    const body = this.bodies.find((one) => one.name === name);
    const group = this.group(body.frame);
    group.updateMatrixWorld(true);
    const points = body.parts[0].points;
    const found = [];
    for (let i = 0; i < points.length; i += 3) {
      const p = new Vector3(points[i], points[i + 1], points[i + 2]).applyMatrix4(group.matrixWorld);
      found.push(p.x + this.told.origin[0], p.y + this.told.origin[1], p.z + this.told.origin[2]);
    }
    return found;
  }
}

function middle(points) {
  const low = new Vector3(Infinity, Infinity, Infinity);
  const high = low.clone().negate();
  const point = new Vector3();
  for (let i = 0; i < points.length; i += 3) {
    point.set(points[i], points[i + 1], points[i + 2]);
    low.min(point);
    high.max(point);
  }
  return low.add(high).multiplyScalar(0.5);
}
