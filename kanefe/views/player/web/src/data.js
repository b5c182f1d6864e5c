// What Python wrote into the page: a description in JSON, and one block of deflated bytes for all arrays.

const KINDS = { float32: Float32Array, float64: Float64Array, int16: Int16Array, uint8: Uint8Array, uint32: Uint32Array };

export async function readScene() {
  const told = JSON.parse(document.getElementById("scene").textContent);
  const bytes = Uint8Array.from(atob(document.getElementById("arrays").textContent.trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return withArrays(told, await new Response(stream).arrayBuffer());
}

// A copy in which each {at, type, shape} is the array itself; its shape stays with it.
function withArrays(value, buffer) {
  if (Array.isArray(value)) return value.map((part) => withArrays(part, buffer));
  if (value === null || typeof value !== "object") return value;
  if ("at" in value && "type" in value) {
    const length = value.shape.reduce((product, n) => product * n, 1);
    const array = new KINDS[value.type](buffer, value.at, length);
    array.shape = value.shape;
    return array;
  }
  return Object.fromEntries(Object.entries(value).map(([key, part]) => [key, withArrays(part, buffer)]));
}

// Between which two instants a time is: the first one, and the share of the way to the next.
export function instantAt(times, t) {
  let low = 0;
  let high = times.length - 1;
  if (t >= times[high]) return { row: Math.max(high - 1, 0), share: high > 0 ? 1 : 0 };
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  const step = times[low + 1] - times[low];
  return { row: low, share: step > 0 ? Math.max(0, (t - times[low]) / step) : 0 };
}

// Row of a table (instants, n) at an instant, between two of them.
export function between(table, { row, share }, out) {
  const n = out.length;
  const next = Math.min(row + 1, table.shape[0] - 1) * n;
  for (let i = 0; i < n; i++) out[i] = (1 - share) * table[row * n + i] + share * table[next + i];
  return out;
}
