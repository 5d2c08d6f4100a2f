// Answers that are not acknowledged yet. They stay in the browser until the server has them,
// also when the tab is closed in between; the uuid makes sure that they count once.

import { isPassing, send } from "./server.js";
import { erase, names, read, write } from "./storage.js";
import { _ } from "./speech.js";

const FIRST_WAIT_MS = 1000;
const LONGEST_WAIT_MS = 30000;
// So that not all browsers come at once when the server is back.
const SPREAD = 0.25;

const prefix = (who) => `g3:${who}:out:`;

export function put(who, entry) {
  write(prefix(who) + entry.uuid, JSON.stringify(entry));
}

export function remove(who, uuid) {
  erase(prefix(who) + uuid);
}

export function entries(who) {
  return names()
    .filter((key) => key.startsWith(prefix(who)))
    .map((key) => JSON.parse(read(key)))
    .sort((a, b) => a.at - b.at);
}

/**
 * Send an answer until the server says what became of it.
 * `waiting(message)` is called before each further try.
 */
export async function deliver(who, entry, waiting) {
  for (let wait = FIRST_WAIT_MS; ; wait = Math.min(2 * wait, LONGEST_WAIT_MS)) {
    let message = _("Not sent yet: there is no network. Your answer is kept and will be sent.");
    let again = 0;
    try {
      const path = `/api/items/${entry.item}/${entry.to ?? "answer"}`;
      const { uuid, body, comment } = entry;
      const sent = { uuid, body, comment };
      const { status, data, againMs } = await send("POST", path, sent);
      again = againMs;
      if (status === 200) {
        remove(who, entry.uuid);
        return { kept: true, ...data };
      }
      if (status === 401) message = _("Not sent yet. %(why)s", { why: data.error });
      else if (isPassing(status)) message = why(status);
      else {
        remove(who, entry.uuid);
        return { kept: false, error: data.error, problems: data.problems ?? [] };
      }
    } catch {
      // no network
    }
    waiting(message);
    await pause(Math.max(wait, again) * (1 + SPREAD * Math.random()));
  }
}

function why(status) {
  if (status === 429) return _("Not sent yet: that was a bit fast. Your answer waits here and is sent by itself.");
  if (status >= 502) return _("Not sent yet: the study can't be reached. Your answer waits in this browser and is sent by itself.");
  return _("Not sent yet: the server has a problem. Your answer waits in this browser and is sent by itself.");
}

/** Wait, or until there is network again. */
function pause(ms) {
  return new Promise((resolve) => {
    const timer = setTimeout(go, ms);
    function go() {
      clearTimeout(timer);
      window.removeEventListener("online", go);
      resolve();
    }
    window.addEventListener("online", go);
  });
}
