// Colours of bodies and of fields, and the bar that says what the latter mean.

export const BODIES = ["#5b8ab8", "#d9954a", "#79a86b", "#b56b80", "#8c7bb3", "#b8a35a", "#5fa8a6", "#a07a62"];
export const GROUND = "#c3cad3";
export const BARE = [0.72, 0.75, 0.79];

// Viridis and Turbo at equal distances, from the first colour to the last.
const STOPS = {
  displacement: ["#440154", "#482878", "#3e4a89", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"],
  stress: ["#30123b", "#4458cb", "#3e9bfe", "#18d5cc", "#46f783", "#a4fc3c", "#e1dc37", "#fda531", "#ef5a11", "#c42502", "#7a0402"],
};
const UNITS = { displacement: "m", stress: "Pa" };
const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

function linear(hex) {
  return [1, 3, 5].map((i) => {
    const c = parseInt(hex.slice(i, i + 2), 16) / 255;
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  });
}

// 256 colours as linear light, for vertices.
export function table(field) {
  const stops = STOPS[field].map(linear);
  const colours = new Float32Array(3 * 256);
  for (let i = 0; i < 256; i++) {
    const at = (i / 255) * (stops.length - 1);
    const k = Math.min(Math.floor(at), stops.length - 2);
    for (let c = 0; c < 3; c++) colours[3 * i + c] = stops[k][c] + (at - k) * (stops[k + 1][c] - stops[k][c]);
  }
  return colours;
}

// A number with its unit: 1240 N is "1.24 kN".
export function withUnit(value, unit) {
  const [factor, prefix] = PREFIXES.find(([size]) => value >= size) ?? PREFIXES.at(-1);
  return `${(value / factor).toPrecision(3)} ${prefix}${unit}`;
}

export function drawBar(field, name, largest) {
  const bar = document.getElementById("bar");
  bar.hidden = !(field in STOPS) || !(largest > 0);
  if (bar.hidden) return;
  const unit = UNITS[field];
  const [factor, prefix] = PREFIXES.find(([size]) => largest >= size) ?? PREFIXES.at(-1);
  document.getElementById("bar-title").textContent = `${name} [${prefix}${unit}]`;
  const canvas = document.getElementById("bar-colours");
  const paint = canvas.getContext("2d");
  const fill = paint.createLinearGradient(0, canvas.height, 0, 0);
  STOPS[field].forEach((colour, i, all) => fill.addColorStop(i / (all.length - 1), colour));
  paint.fillStyle = fill;
  paint.fillRect(0, 0, canvas.width, canvas.height);
  const ticks = document.getElementById("bar-ticks");
  ticks.replaceChildren();
  for (let i = 0; i <= 4; i++) {
    const tick = document.createElement("span");
    tick.textContent = ((largest / factor) * (i / 4)).toPrecision(3);
    tick.style.bottom = `${25 * i}%`;
    ticks.append(tick);
  }
}
