// Drafts: in the browser at once, on the server soon after.

import { isPassing, send } from "./server.js";
import { erase, read, write } from "./storage.js";
import { _ } from "./speech.js";

const DELAY_MS = 1000;
const AGAIN_MS = 5000;

/** The draft that is newer: the browser's or the server's. */
export function newest(who, data) {
  const stored = read(key(who, data));
  const own = stored ? JSON.parse(stored) : null;
  if (own && data.draft) return own.revision >= data.draft.revision ? own : data.draft;
  return own ?? data.draft;
}

/** An adjudicator has a draft for each answer that they begin with, in this browser only. */
const key = (who, { item, from }) => `g3:${who}:draft:${item}${from ? `:${from}` : ""}`;

export class Drafts {
  #timer;
  #sending = false;
  #onServer;

  constructor(who, data, show) {
    this.key = key(who, data);
    this.path = data.practice || data.to ? null : `/api/items/${data.item}/draft`;
    this.show = show;
    this.latest = newest(who, data);
    this.#onServer = data.draft?.revision ?? 0;
    this.stopped = false;
    window.addEventListener("online", () => this.#save());
    window.addEventListener("pagehide", () => this.#save({ keepalive: true }));
    if (this.isBehind) this.#plan(0);
  }

  get isBehind() {
    return !this.stopped && this.path !== null && (this.latest?.revision ?? 0) > this.#onServer;
  }

  keep(body) {
    this.latest = { revision: (this.latest?.revision ?? 0) + 1, body };
    try {
      write(this.key, JSON.stringify(this.latest));
    } catch {
      // the browser's storage is full; the server's copy has to do
    }
    if (this.path === null) return;
    this.show("saving", _("Saving…"));
    this.#plan(DELAY_MS);
  }

  /** The answer is on its way: no draft must come after it. */
  stop() {
    clearTimeout(this.#timer);
    this.stopped = true;
  }

  resume() {
    this.stopped = false;
  }

  forget() {
    this.stop();
    erase(this.key);
  }

  #plan(ms) {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#save(), ms);
  }

  async #save({ keepalive = false } = {}) {
    if (!this.isBehind || (this.#sending && !keepalive)) return;
    const sent = this.latest;
    let again = AGAIN_MS;
    this.#sending = true;
    try {
      const { status, data, againMs } = await send("PUT", this.path, sent, { keepalive });
      again = Math.max(again, againMs);
      if (isPassing(status)) throw new Error(`status ${status}`);
      this.#onServer = sent.revision;
      if (this.stopped) return;
      if (status !== 200) this.show("local", data.error ?? _("Not saved"));
      else if (!data.kept) this.show("local", _("Changed in another tab: load this page again"));
      else if (!this.isBehind) this.show("saved", _("Saved"));
    } catch {
      if (!this.stopped) this.show("local", _("Kept in this browser, not on the server yet"));
      this.#plan(again);
      return;
    } finally {
      this.#sending = false;
    }
    if (this.isBehind) this.#plan(DELAY_MS);
  }
}
