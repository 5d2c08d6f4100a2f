// Talking to the server's JSON interface.

import { _ } from "./speech.js";

const TIMEOUT_MS = 20000;
const LONGEST_AGAIN_MS = 120000;
const root = document.querySelector('meta[name="root"]')?.content ?? "";
const meta = document.querySelector('meta[name="csrf-token"]');

/**
 * Send JSON. Gives {status, data, againMs}: after how long the server wants it sent again, or 0.
 * Throws if there is no answer at all.
 */
export async function send(method, path, value, { keepalive = false } = {}) {
  const first = await once(method, path, value, keepalive);
  if (first.status !== 400 || keepalive) return first;
  // The page may be older than the sign-in: ask for a new token, once.
  const session = await once("GET", "/api/session");
  if (session.status !== 200) return session;
  meta.content = session.data.csrf ?? meta.content;
  const second = await once(method, path, value, keepalive);
  // Where the server doesn't take the browser's cookie it isn't the answer that is wrong.
  if (second.status !== 400 || session.data.signed_in) return second;
  return { ...second, status: 401, data: { error: _("Sign in again in another tab.") } };
}

async function once(method, path, value, keepalive) {
  const response = await fetch(root + path, {
    method,
    keepalive,
    body: value === undefined ? undefined : JSON.stringify(value),
    headers: { "Content-Type": "application/json", "X-CSRFToken": meta.content },
    signal: AbortSignal.timeout(TIMEOUT_MS),
  });
  const data = await response.json().catch(() => ({}));
  return { status: response.status, data, againMs: againMs(response) };
}

function againMs(response) {
  const seconds = Number(response.headers.get("Retry-After"));
  return seconds > 0 ? Math.min(1000 * seconds, LONGEST_AGAIN_MS) : 0;
}

/** Whether sending the same thing again may help. */
export const isPassing = (status) => status === 408 || status === 429 || status >= 500;

/** A path of the app as the browser knows it, which a proxy may serve under another path. */
export const here = (path) => root + path;

export const mediaUrl = (id) => here(id.startsWith("/") ? id : `/media/${id}`);
