// The page of taut view: what the hand does goes to the session, what comes back goes to the display.

import * as api from './api.js';
import * as camera from './camera.js';
import { Display } from './display.js';
import { showInspection } from './inspector.js';
import { buildPanel } from './panel.js';
import { watchPointer } from './pointer.js';
import { Session } from './session.js';

const $ = (id) => document.getElementById(id);
const canvas = $('picture');
const pressed = (id) => $(id).getAttribute('aria-pressed') === 'true';
const press = (id, on) => $(id).setAttribute('aria-pressed', String(on));

const pictures = { follow: null, fixed: null, A: null, B: null };
const frames = new Map(); // frame -> its best picture since the last change of another kind
let display;
let eye = null;   // the camera as the hand left it
let probe = null; // where it is inspected, shares of the picture
let playing = null;

function say(line) {
  $('status').textContent = line;
}

function trouble(line) {
  $('trouble').hidden = !line;
  $('trouble').textContent = line ?? '';
}

// --- the picture --------------------------------------------------------------------------------------------------------

function sides() {
  if (pressed('compare')) return [pictures.A, pictures.B];
  return session.state?.wipe ? [pictures.follow, pictures.fixed ?? pictures.follow] : [pictures.follow, pictures.follow];
}

function draw() {
  const [left, right] = sides();
  if (!left) return;
  const two = pressed('compare') || session.state.wipe;
  const [name, first, kind] = $('channel').value.split(':');
  const part = Number(first ?? 0);
  const isColour = kind === 'colour';
  const isMatte = isColour && name.startsWith('crypto_'); // colours of its own
  display.look.wipe = two ? Number($('wipe').value) : 1;
  display.look.exposure = isMatte ? 0 : Number($('exposure').value);
  display.look.transform = isMatte ? 0 : Number($('transform').value);
  display.look.falseColours = name !== '' && !isColour && left.channels > 4;
  if (display.look.falseColours) display.look.range = rangeOf(left, part);
  $('range').textContent = display.look.falseColours ? `dark blue ${display.look.range[0].toPrecision(3)}, yellow ${display.look.range[1].toPrecision(3)}` : '';
  $('wipe').hidden = $('wipeLine').hidden = !two;
  $('wipeLine').style.left = `${100 * display.look.wipe}%`;
  display.show(left, right, part, isColour);
}

// How the scene says it is to be seen (its [image]), until the hand says otherwise.
let seenAs = '';
async function takeImage(image) {
  const text = JSON.stringify(image);
  if (text === seenAs) return;
  seenAs = text;
  const own = $('transform').querySelector('[value="3"]');
  own.hidden = own.disabled = image.own;
  own.textContent = image.view;
  $('exposure').value = image.exposure;
  if (!image.own) {
    try {
      display.takeView(await api.view());
    } catch (error) {
      if (seenAs === text) seenAs = ''; // to be tried again
      return trouble(error.message);
    }
  }
  $('transform').value = image.own ? Number(image.view === 'filmic') : 3;
  $('exposure').dispatchEvent(new Event('input'));
}

// A light group each, once.
function takeLights(names) {
  const menu = $('lights');
  if (menu.children.length === names.length && [...menu.children].every((option, i) => option.textContent === names[i])) return;
  menu.replaceChildren(...names.map((name, i) => new Option(name, `lights:${3 * i}:colour`)));
}

// Over the covered pixels.
function rangeOf(picture, part) {
  picture.ranges ??= {};
  if (picture.ranges[part]) return picture.ranges[part];
  let low = Infinity, high = -Infinity;
  for (let i = 0; i < picture.values.length; i += picture.channels) {
    if (picture.values[i + 3] === 0) continue;
    const value = api.fromHalf(picture.values[i + 4 + part]);
    if (!Number.isFinite(value)) continue; // the variance of one sample
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return (picture.ranges[part] = low <= high ? [low, high] : [0, 1]);
}

function onPicture(picture) {
  if (picture.milliseconds > 0) document.documentElement.dataset.firstPicture = picture.milliseconds.toFixed(1);
  if (picture.follows) {
    const known = frames.get(picture.frame);
    if (!known || known.version <= picture.version) frames.set(picture.frame, picture);
    if (picture.frame !== session.state.frame) return; // a hand has gone on
    pictures.follow = picture;
    playing?.arrived(picture);
  } else if (picture.frame === session.state.frame) {
    pictures.fixed = picture;
  }
  const coarse = picture.columns < picture.width ? `, ${picture.columns} x ${picture.rows} for now` : '';
  const follow = pictures.follow ?? picture;
  say(`${follow.samples} of ${follow.wanted} samples${follow.done ? ', done' : coarse}`);
  Object.assign(canvas.dataset, { samples: follow.samples, done: follow.done, version: follow.version, frame: follow.frame });
  draw();
}

// --- the session ---------------------------------------------------------------------------------------------------------

function onState(state, isMoving = false) {
  $('scene').textContent = state.scene;
  document.title = `${state.scene} - taut view`;
  canvas.setAttribute('aria-label', `${state.scene} at frame ${state.frame}`);
  if (canvas.width !== state.width && !pictures.follow) Object.assign(canvas, { width: state.width, height: state.height });
  if (state.status?.error) trouble(state.status.error);
  $('time').max = state.frames.length - 1;
  $('time').value = state.frames.indexOf(state.frame);
  $('time').setAttribute('aria-valuetext', `frame ${state.frame}`);
  $('timeValue').textContent = `${state.frame} of ${state.frames.at(-1)}`;
  press('wiping', state.wipe);
  press('denoising', state.denoise);
  takeImage(state.image);
  takeLights(state.lights);
  draw(); // the line of the wipe, which no new picture need follow
  $('undo').disabled = session.done.length === 0;
  $('redo').disabled = session.undone.length === 0;
  if (!isMoving) {
    eye = state.camera;
    showCamera();
    buildPanel($('panel'), state, changePanel);
  }
  $('overrides').value = state.changes.map((c) => `-D '${c.key}=${c.text}'`).join(' ');
  const shown = frames.get(state.frame);
  if (shown && shown !== pictures.follow && playing) {
    pictures.follow = shown;
    draw();
  }
}

const session = new Session({
  state: onState,
  picture: onPicture,
  gone: (isGone) => trouble(isGone ? 'The server is gone. This page looks for it every second; what was changed is kept here.' : null),
  failed: (line) => trouble(line),
});

function edit(changes, isLast = true) {
  frames.clear();
  trouble(null);
  session.change(changes, {}, isLast);
}

function changePanel(entry, value, isLast) {
  edit([{ key: entry.key, value, atFrame: entry.keyed !== null }], isLast);
}

// --- camera --------------------------------------------------------------------------------------------------------------

let resting = null;

// The last of a row of moves is a step of undo.
function look(next) {
  eye = next;
  showCamera();
  edit([{ key: 'camera', value: eye }], false);
  clearTimeout(resting);
  resting = setTimeout(() => edit([{ key: 'camera', value: eye }], true), 400);
}

function showCamera() {
  $('fov').disabled = eye.fov_deg === undefined;
  $('fov').value = eye.fov_deg ?? 40;
  $('fovValue').textContent = eye.fov_deg?.toFixed(1) ?? '';
  $('aperture').value = 1000 * eye.aperture_radius;
  $('apertureValue').textContent = (1000 * eye.aperture_radius).toFixed(1);
  if (document.activeElement !== $('focus')) $('focus').value = Number(eye.focus_distance.toPrecision(5));
}

const kTurn = 3; // radians for the picture's height
const orbit = (dx, dy) => eye && look(camera.orbit(eye, -kTurn * dx, kTurn * dy));
const pan = (dx, dy) => eye && look(camera.pan(eye, -dx, dy));
const dolly = (factor) => eye && look(camera.dolly(eye, factor));

// --- inspect and focus -----------------------------------------------------------------------------------------------------

let inspecting = false;

async function inspectAt(x, y) {
  probe = [x, y];
  if (inspecting) return;
  inspecting = true;
  const { width, height } = session.state;
  try {
    while (true) {
      const asked = probe;
      const found = await api.inspect(asked[0] * width, asked[1] * height);
      $('inspector').open = true;
      showInspection({ words: $('inspected'), overlay: $('overlay'), lobe: $('lobe') },
        { x: asked[0] * width, y: asked[1] * height }, { width, height }, found);
      if (asked === probe) break;
    }
  } catch (error) {
    if (!(error instanceof api.ServerGone)) trouble(error.message);
  }
  inspecting = false;
}

async function focusAt(x, y) {
  const { width, height } = session.state;
  try {
    const found = await api.inspect(x * width, y * height);
    if (found) look({ ...eye, focus_distance: Number(found.depth.toPrecision(7)) });
    else say('Nothing to focus on there');
  } catch (error) {
    trouble(error.message);
  }
}

function setInspecting(on) {
  press('inspecting', on);
  canvas.classList.toggle('pointing', on || pressed('focusing'));
  if (on && !probe) inspectAt(0.5, 0.5);
  if (!on) $('overlay').replaceChildren();
}

// --- time ----------------------------------------------------------------------------------------------------------------

function goTo(index) {
  const list = session.state.frames;
  const place = ((index % list.length) + list.length) % list.length;
  const frame = list[place];
  $('time').value = place; // the next key goes on from there
  const known = frames.get(frame);
  if (known) {
    pictures.follow = known;
    draw();
  }
  session.change([], { frame });
}

// One frame after the other as they come, at most at the scene's rate; those that were seen before need not come again.
function play(on) {
  press('play', on);
  $('play').textContent = on ? 'Stop' : 'Play';
  if (!on) {
    playing?.stop();
    playing = null;
    return;
  }
  let timer = null;
  let due = 0;
  const next = () => {
    due = performance.now() + 1000 / session.state.fps;
    goTo(session.state.frames.indexOf(session.state.frame) + 1);
  };
  playing = {
    arrived: (picture) => {
      if (picture.columns < picture.width && picture.samples < 1) return;
      clearTimeout(timer);
      timer = setTimeout(next, Math.max(0, due - performance.now()));
    },
    stop: () => clearTimeout(timer),
  };
  next();
}

// --- tools ---------------------------------------------------------------------------------------------------------------

function keep(side) {
  pictures[side] = pictures.follow;
  say(`Kept as ${side}`);
  $('compare').disabled = !(pictures.A && pictures.B);
}

const toggles = {
  play: () => play(!pressed('play')),
  wiping: () => session.change([], { wipe: !session.state.wipe }),
  denoising: () => {
    frames.clear();
    session.change([], { denoise: !session.state.denoise });
  },
  inspecting: () => setInspecting(!pressed('inspecting')),
  focusing: () => {
    press('focusing', !pressed('focusing'));
    canvas.classList.toggle('pointing', pressed('focusing') || pressed('inspecting'));
  },
  compare: () => {
    press('compare', !pressed('compare'));
    draw();
  },
  help: () => {
    $('helpText').hidden = !$('helpText').hidden;
    $('help').setAttribute('aria-expanded', String(!$('helpText').hidden));
  },
  undo: () => { frames.clear(); session.undo(); },
  redo: () => { frames.clear(); session.redo(); },
  takeA: () => keep('A'),
  takeB: () => keep('B'),
  cameraBack: () => edit([{ key: 'camera', value: null }]),
  copy: () => navigator.clipboard.writeText($('overrides').value).then(() => { $('saved').textContent = 'Copied'; },
    () => $('overrides').select()),
  save: async () => {
    try {
      const done = await api.save($('fileName').value);
      $('saved').textContent = `Saved as ${done.path}`;
    } catch (error) {
      $('saved').textContent = error.message;
    }
  },
  quit: async () => {
    try { await api.quit(); } catch { /* it is gone either way */ }
    say('The server has ended');
  },
};
for (const [id, act] of Object.entries(toggles)) $(id).addEventListener('click', act);

$('time').addEventListener('input', () => goTo(Number($('time').value)));
for (const id of ['exposure', 'transform', 'wipe']) $(id).addEventListener('input', () => {
  $('exposureValue').textContent = Number($('exposure').value).toFixed(1);
  draw();
});
$('channel').addEventListener('change', () => {
  frames.clear();
  session.change([], { channel: $('channel').value.split(':')[0] });
  draw();
});
$('fov').addEventListener('input', () => look({ ...eye, fov_deg: Number($('fov').value) }));
$('aperture').addEventListener('input', () => look({ ...eye, aperture_radius: Number($('aperture').value) / 1000 }));
$('focus').addEventListener('change', () => look({ ...eye, focus_distance: Math.max(0, Number($('focus').value)) }));

watchPointer(canvas, {
  orbit, pan, dolly,
  point: (x, y) => pressed('inspecting') && inspectAt(x, y),
  click: (x, y) => {
    if (pressed('focusing')) focusAt(x, y);
    else if (pressed('inspecting')) inspectAt(x, y);
  },
});

const kStep = 0.03;
const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function arrow(event, [dx, dy]) {
  if (event.altKey && (session.state.wipe || pressed('compare'))) {
    $('wipe').value = Number($('wipe').value) + kStep * (dx - dy);
    draw();
  } else if (event.altKey) {
    const [x, y] = probe ?? [0.5, 0.5];
    setInspecting(true);
    inspectAt(Math.min(1, Math.max(0, x + 0.02 * dx)), Math.min(1, Math.max(0, y + 0.02 * dy)));
  } else if (event.shiftKey) {
    pan(-kStep * dx, -kStep * dy);
  } else {
    orbit(-kStep * dx, -kStep * dy);
  }
}

const keys = {
  '+': () => dolly(0.95), '=': () => dolly(0.95), '-': () => dolly(1 / 0.95),
  ',': () => goTo(Number($('time').value) - 1), '.': () => goTo(Number($('time').value) + 1),
  ' ': toggles.play, w: toggles.wiping, n: toggles.denoising, i: toggles.inspecting, f: toggles.focusing, a: toggles.takeA, b: toggles.takeB,
  c: () => $('compare').disabled || toggles.compare(), '?': toggles.help,
  s: () => { $('saving').open = true; $('fileName').focus(); },
  '[': () => expose(-0.5), ']': () => expose(0.5),
  Enter: () => probe && pressed('focusing') && focusAt(...probe),
};

function expose(stops) {
  $('exposure').value = Number($('exposure').value) + stops;
  $('exposure').dispatchEvent(new Event('input'));
}

document.addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.metaKey) {
    if (event.key.toLowerCase() !== 'z' || event.target.matches('textarea, input:not([type=range]):not([type=checkbox])')) return;
    event.preventDefault();
    (event.shiftKey ? toggles.redo : toggles.undo)();
    return;
  }
  // A control that has the keys keeps them.
  if (event.target !== canvas && event.target.matches('input, select, textarea, summary')) return;
  if ((event.key === ' ' || event.key === 'Enter') && event.target.matches('button')) return;
  const act = arrows[event.key] ? () => arrow(event, arrows[event.key]) : keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!act) return;
  event.preventDefault();
  act();
});

try {
  display = new Display(canvas);
  await session.start();
} catch (error) {
  trouble(error.message || String(error));
}
