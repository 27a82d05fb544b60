// The page's side of a session: changes go out one at a time, the last of those that wait together; pictures come in as they are made.

import * as api from './api.js';

const kOneStep = 800; // milliseconds
const pause = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

export class Session {
  // on: state(state, isFromHere), picture(picture), gone(isGone), failed(line)
  constructor(on) {
    this.on = on;
    this.state = null;
    this.waiting = new Map(); // key -> change
    this.request = {};
    this.busy = false;
    this.undone = [];
    this.done = [];
    this.gesture = null; // undo of the changes since the hand came down
  }

  async start() {
    await this.take(await api.state());
    this.listen(true);
  }

  async take(state) {
    const restarted = this.state && this.state.id !== state.id;
    if (restarted) {
      const lost = this.state.changes;
      this.newest = [0, 0];
      if (lost.length > 0) state = await api.change({ changes: lost, wipe: this.state.wipe, channel: this.state.channel, denoise: this.state.denoise });
    }
    this.state = state;
    this.on.state(state);
  }

  // Asks for pictures until the page is left. Held fixed is asked for while there is a wipe.
  async listen(follows) {
    this.newest ??= [0, 0];
    const side = follows ? 0 : 1;
    while (follows || this.state.wipe) {
      try {
        const picture = await api.picture(follows, this.newest[side]);
        this.gone(false);
        if (picture && picture.number > this.newest[side]) {
          this.newest[side] = picture.number;
          this.on.picture(picture);
        }
      } catch (error) {
        if (!(error instanceof api.ServerGone)) this.on.failed(error.message);
        this.gone(error instanceof api.ServerGone);
        await pause(1);
        if (follows) await this.reconnect();
      }
    }
    this.listening = false;
  }

  async reconnect() {
    try {
      await this.take(await api.state());
      this.gone(false);
    } catch { /* still gone */ }
  }

  gone(isGone) {
    if (this.isGone === isGone) return;
    this.isGone = isGone;
    this.on.gone(isGone);
  }

  // changes: [{key, value | text, atFrame}]; `more`: frame, wipe, channel, denoise. A hand that moves makes one step of undo until it rests.
  change(changes, more = {}, isLast = true) {
    for (const c of changes) this.waiting.set(c.key, c);
    Object.assign(this.request, more);
    this.restsAfter = isLast;
    this.flush();
  }

  async flush() {
    if (this.busy || (this.waiting.size === 0 && Object.keys(this.request).length === 0)) return;
    this.busy = true;
    const changes = [...this.waiting.values()];
    const request = { ...this.request, changes };
    const rests = this.restsAfter;
    this.waiting.clear();
    this.request = {};
    try {
      const state = await api.change(request);
      this.keep(state.undo, rests);
      this.state = state;
      if (state.wipe && !this.listening) {
        this.listening = true;
        this.listen(false);
      }
      this.on.state(state, !rests || this.waiting.size > 0);
    } catch (error) {
      if (error instanceof api.ServerGone) this.gone(true);
      else this.on.failed(error.message);
    }
    this.busy = false;
    this.flush();
  }

  keep(undo, rests) {
    if (undo.length > 0) {
      const known = new Set((this.gesture ?? []).map((c) => c.key));
      this.gesture = [...(this.gesture ?? []), ...undo.filter((c) => !known.has(c.key))];
    }
    if (!rests || !this.gesture) return;
    // Steps of one control that follow each other at once are one.
    const keys = this.gesture.map((c) => c.key).join();
    const now = performance.now();
    if (keys !== this.lastKeys || now - this.lastTime > kOneStep || this.undone.length > 0) this.done.push(this.gesture);
    this.lastKeys = keys;
    this.lastTime = now;
    this.undone = [];
    this.gesture = null;
  }

  async step(from, to) {
    const changes = from.pop();
    this.lastKeys = null;
    if (!changes) return;
    try {
      const state = await api.change({ changes });
      to.push(state.undo);
      this.state = state;
      this.on.state(state);
    } catch (error) {
      this.on.failed(error.message);
    }
  }
  undo() { return this.step(this.done, this.undone); }
  redo() { return this.step(this.undone, this.done); }
}
