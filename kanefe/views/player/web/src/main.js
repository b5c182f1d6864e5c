// The page: time, controls, and when to draw.

import { Vector3 } from "three";
import { Actors } from "./actors.js";
import { FORCES, LINK } from "./arrows.js";
import { drawBar, GROUND, withUnit } from "./colours.js";
import { readScene } from "./data.js";
import { Stage } from "./stage.js";

const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];
const GOOD_LENGTH = [3, 40]; // s that a run may take to be shown as fast as it was
const WANTED_LENGTH = 10; // s
const FEW = 14; // bodies of which names are shown at the start
const LINE = 15; // height of a name, pixels
const PAUSE = '<svg width="12" height="14"><rect width="4" height="14"/><rect x="8" width="4" height="14"/></svg>';
const PLAY = '<svg width="13" height="14"><path d="M1 0 13 7 1 14z"/></svg>';

const $ = (id) => document.getElementById(id);

async function main() {
  const told = await readScene();
  const options = new URLSearchParams(location.hash.slice(1));
  const first = told.times[0];
  const last = told.times.at(-1);
  const view = {
    colour: options.get("colour") ?? told.colour,
    scale: told.scale,
    force: 1,
    names: told.bodies.length <= FEW,
    axes: false,
    mesh: false,
    grid: Boolean(told.travel) || !told.bodies.some((body) => body.parts.some((part) => part.is_endless)),
    surfaces: true,
    contact: true,
    reaction: true,
    links: true,
  };
  const clock = { t: first, isPlaying: false, speed: 1, seen: 0 };
  let isDirty = true;
  const touch = () => (isDirty = true);

  const stage = new Stage($("canvas"), told, touch);
  const actors = new Actors(told, stage.scene);
  const names = actors.bodies.filter((body) => body.kind !== "ground").map((body) => nameTag(body));
  const TRAVEL = { place: () => actors.travelled(clock.t) };
  const NOTHING = { place: () => new Vector3() };
  const followable = [
    ["nothing", NOTHING], ...(told.travel ? [["what travels", TRAVEL]] : []),
    ...actors.bodies.filter((body) => body.frame >= 0).map((body) => [body.name, { place: () => actors.anchor(body) }]),
  ];
  let followed = told.travel ? TRAVEL : NOTHING;
  let was = new Vector3();

  $("title").textContent = told.title === "kanefe" ? "" : told.title;
  fillSelects();
  fillChecks();
  bindControls();
  const fit = () => {
    stage.fit($("panel").open ? $("panel").offsetWidth : 0, $("controls").offsetHeight);
    touch();
  };
  new ResizeObserver(fit).observe($("canvas"));
  $("panel").addEventListener("toggle", fit);
  fit();
  for (const name of (options.get("hide") ?? "").split(",").filter(Boolean)) hide(name);
  for (const name of (options.get("show") ?? "").split(",").filter((key) => key in view)) view[name] = true;
  setTime(options.has("t") ? Number(options.get("t")) : first);
  follow(followable.find(([name]) => name === options.get("follow"))?.[1] ?? followed);
  look(options.get("view") ?? "all");
  const isStill = matchMedia("(prefers-reduced-motion: reduce)").matches || last === first;
  play(options.has("play") ? options.get("play") !== "0" : !options.has("t") && !isStill);
  requestAnimationFrame(step);
  const target = () => stage.controls.target.toArray().map((x, i) => x + told.origin[i]);
  window.kanefe = { positions: (name) => actors.positions(name), rods: () => actors.links.rods.count, target, setTime, play, clock };

  function step(now) {
    requestAnimationFrame(step);
    if (clock.isPlaying) {
      const passed = clock.seen ? (now - clock.seen) / 1000 : 0;
      const t = clock.t + Math.min(passed, 0.1) * clock.speed;
      setTime(t > last ? first : t);
    }
    clock.seen = now;
    if (!isDirty) return;
    isDirty = false;
    draw();
  }

  function draw() {
    actors.update(clock.t, view);
    if (followed !== NOTHING) {
      const place = followed.place();
      stage.shift(place.clone().sub(was));
      was = place;
      isDirty = clock.isPlaying;
    }
    stage.keepGrid();
    stage.grid.visible = view.grid;
    stage.draw();
    placeNames();
    document.documentElement.dataset.drawn = "1";
    document.documentElement.dataset.time = String(clock.t);
  }

  // From now on the eye goes with something.
  function follow(chosen) {
    followed = chosen;
    $("follow").value = String(followable.findIndex(([, one]) => one === chosen));
    stage.go(Boolean(told.travel) && chosen !== NOTHING);
  }

  function look(name) {
    actors.update(clock.t, view);
    was = followed.place();
    stage.look(name, stage.travels ? actors.travelled(clock.t) : undefined);
    touch();
  }

  function setTime(t) {
    clock.t = Math.min(Math.max(Number.isFinite(t) ? t : first, first), last);
    $("time").value = String(last > first ? (clock.t - first) / (last - first) : 0);
    const digits = Math.max(0, 3 - Math.floor(Math.log10(last - first || 1)));
    $("clock").textContent = `${clock.t.toFixed(digits)} / ${last.toFixed(digits)} s`;
    touch();
  }

  function play(isPlaying) {
    clock.isPlaying = isPlaying && last > first;
    clock.seen = 0;
    $("play").innerHTML = clock.isPlaying ? PAUSE : PLAY;
  }

  function hide(name) {
    const body = actors.bodies.find((one) => one.name === name);
    if (!body) return;
    body.isShown = false;
    const box = [...document.querySelectorAll("#bodies input")].find((input) => input.dataset.body === name);
    if (box) box.checked = false;
  }

  function nameTag(body) {
    const tag = document.createElement("span");
    tag.textContent = body.name;
    $("names").append(tag);
    return { body, tag };
  }

  function placeNames() {
    const { clientWidth: width, clientHeight: height } = $("canvas");
    const placed = [];
    for (const { body, tag } of names) {
      const at = actors.anchor(body).project(stage.camera);
      const isSeen = view.names && body.isShown && at.z < 1 && Math.abs(at.x) < 1 && Math.abs(at.y) < 1;
      tag.style.display = isSeen ? "" : "none";
      if (!isSeen) continue;
      const x = 0.5 * (1 + at.x) * width;
      let y = 0.5 * (1 - at.y) * height;
      const reach = 3.5 * body.name.length;
      const covers = (other) => Math.abs(other.x - x) < other.reach + reach && Math.abs(other.y - y) < LINE;
      for (let i = 0; i < names.length && placed.some(covers); i++) y += LINE;
      placed.push({ x, y, reach });
      tag.style.left = `${x}px`;
      tag.style.top = `${y}px`;
    }
  }

  function fillSelects() {
    const colours = ["displacement", "stress"].filter((field) => told.largest[field] > 0);
    if (!colours.includes(view.colour)) view.colour = "none";
    select($("colour"), [...colours, "none"].map((name) => [name, name]), view.colour);
    $("colour").parentElement.hidden = colours.length === 0;
    select($("follow"), followable.map(([name], i) => [String(i), name]), "0");
    const length = last - first || 1;
    const asIs = length >= GOOD_LENGTH[0] && length <= GOOD_LENGTH[1];
    const nearest = SPEEDS.reduce((a, b) => (far(b) < far(a) ? b : a));
    function far(speed) { return Math.abs(Math.log(length / speed / WANTED_LENGTH)); }
    clock.speed = options.has("speed") ? Number(options.get("speed")) : asIs ? 1 : nearest;
    select($("speed"), SPEEDS.map((speed) => [String(speed), `${speed} ×`]), String(clock.speed));
    showBar();
  }

  function fillChecks() {
    const has = (kind) => told.arrows.some((arrow) => arrow.kind === kind);
    const isMeshed = actors.bodies.some((body) => body.parts.some((part) => part.lines));
    const rows = [
      ["names", "names", true], ["axes", "axes", true], ["grid", "grid", true], ["mesh", "mesh", isMeshed],
      ["surfaces", "surfaces", told.bodies.some((body) => body.parts.some((part) => part.surface))],
      ["contact", "contact forces", has("contact"), FORCES.contact],
      ["reaction", "joint reactions", has("reaction"), FORCES.reaction],
      ["links", "springs, ropes", told.links.length > 0, LINK],
    ];
    for (const [key, label, isThere, colour] of rows.filter((row) => row[2])) {
      const box = check($("shown"), label, colour, view[key] || (options.get("show") ?? "").split(",").includes(key));
      box.addEventListener("change", () => { view[key] = box.checked; touch(); });
    }
    for (const body of actors.bodies) {
      const box = check($("bodies"), body.name, body.kind === "ground" ? GROUND : body.colour, true);
      box.dataset.body = body.name;
      box.addEventListener("change", () => { body.isShown = box.checked; touch(); });
    }
    $("scale-row").hidden = !(told.largest.displacement > 0);
    $("force-row").hidden = told.arrows.length === 0;
    const longest = Math.max(0, ...told.arrows.map((arrow) => arrow.largest));
    if (longest > 0) $("force-value").textContent = `longest ${withUnit(longest, "N")}`;
  }

  function showBar() {
    drawBar(view.colour, view.colour === "stress" ? told.stress_name : view.colour, told.largest[view.colour] ?? 0);
  }

  function bindControls() {
    $("play").addEventListener("click", () => play(!clock.isPlaying));
    $("time").addEventListener("input", () => { play(false); setTime(first + Number($("time").value) * (last - first)); });
    $("speed").addEventListener("change", () => (clock.speed = Number($("speed").value)));
    $("colour").addEventListener("change", () => {
      view.colour = $("colour").value;
      showBar();
      touch();
    });
    const scale = $("scale");
    scale.value = String(Math.log10(Math.max(view.scale, 1)));
    const say = () => ($("scale-value").textContent = `× ${view.scale.toPrecision(3)}`);
    say();
    scale.addEventListener("input", () => { view.scale = 10 ** Number(scale.value); say(); touch(); });
    $("force").addEventListener("input", () => { view.force = 10 ** Number($("force").value); touch(); });
    $("follow").addEventListener("change", () => {
      follow(followable[Number($("follow").value)][1]);
      if (followed === NOTHING || followed === TRAVEL) look("all");
      else was = followed.place();
      touch();
    });
    for (const button of document.querySelectorAll("[data-view]")) {
      button.addEventListener("click", () => look(button.dataset.view));
    }
    addEventListener("keydown", (event) => {
      if (event.target.closest?.("input, select, button, summary")) return;
      const by = (last - first) / 200;
      const keys = {
        " ": () => play(!clock.isPlaying),
        ArrowLeft: () => { play(false); setTime(clock.t - by); },
        ArrowRight: () => { play(false); setTime(clock.t + by); },
        Home: () => look("all"),
      };
      if (!(event.key in keys)) return;
      event.preventDefault();
      keys[event.key]();
    });
    if (innerWidth < 640) $("panel").open = false;
  }
}

function select(element, pairs, chosen) {
  for (const [value, label] of pairs) {
    const option = document.createElement("option");
    option.value = value;
    option.textContent = label;
    option.selected = value === chosen;
    element.append(option);
  }
}

function check(parent, text, colour, isChecked) {
  const label = document.createElement("label");
  const box = document.createElement("input");
  box.type = "checkbox";
  box.checked = isChecked;
  label.append(box);
  if (colour) {
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    swatch.style.background = colour;
    label.append(swatch);
  }
  label.append(text);
  parent.append(label);
  return box;
}

main().catch((error) => {
  const message = document.getElementById("message");
  message.hidden = false;
  message.textContent = `The run cannot be shown: ${error.message}. A browser with WebGL 2 shows it.`;
  throw error;
});
