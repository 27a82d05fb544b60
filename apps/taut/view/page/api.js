// What the server is asked. Paths are relative to the page's address, which holds the token.

export class ServerGone extends Error {}

async function ask(path, options) {
  let response;
  try {
    response = await fetch(path, options);
  } catch {
    throw new ServerGone(path);
  }
  if (response.status === 204) return null;
  if (response.ok) return response;
  let line = `${response.status} ${response.statusText}`;
  try { line = (await response.json()).error ?? line; } catch { /* no JSON: the status says it */ }
  throw new Error(line);
}

const send = async (path, body) =>
  (await ask(path, { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(body) })).json();

export const state = async () => (await ask('state')).json();
export const change = (request) => send('change', request);
export const save = (name) => send('save', { name });
export const quit = () => send('quit', {});
export const view = async () => new Uint16Array(await (await ask('view')).arrayBuffer());
export const inspect = async (x, y) => (await ask(`inspect?x=${x}&y=${y}`)).json();

const kHeaderWords = 16;

// The next picture after that number, or null: none for a while. Linear halves, rows from the top.
export async function picture(follows, after) {
  const response = await ask(`picture?follows=${follows ? 1 : 0}&after=${after}`);
  if (response === null) return null;
  const bytes = await response.arrayBuffer();
  const words = new Uint32Array(bytes, 0, kHeaderWords);
  return {
    number: words[1], version: words[2], frame: new Int32Array(bytes, 12, 1)[0], follows: words[4] === 1,
    columns: words[5], rows: words[6], width: words[7], height: words[8], samples: words[9], wanted: words[10],
    done: words[11] === 1, channels: words[12], milliseconds: new Float32Array(bytes, 52, 1)[0],
    values: new Uint16Array(bytes, 4 * kHeaderWords),
  };
}

// A half float as a number.
export function fromHalf(h) {
  const sign = h & 0x8000 ? -1 : 1;
  const exponent = (h >> 10) & 31;
  const fraction = h & 1023;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}
