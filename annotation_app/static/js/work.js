// What all tasks share: the state with undo and redo, drafts, sending, and what people are told.

import { $, announce, h, isTyping, useSingleKeys, usesSingleKeys } from "./dom.js";
import { Drafts } from "./drafts.js";
import { deliver, entries, put } from "./outbox.js";
import { ownFeedback } from "./practice.js";
import { send } from "./server.js";
import { _ } from "./speech.js";

export const data = JSON.parse($("item").textContent);
export const payload = data.payload;

const LONGEST_HISTORY = 200;
const HOLD_AGAIN_MS = 60000;
const LOST = _("Somebody else may have got this one meanwhile. You can go on, or load the page again for another.");

/**
 * Begin to work on the page's item.
 *
 * initial: the state without a draft; anything that JSON can say. `data.start` goes over it: where
 * somebody decides between answers, parts of one of these.
 * draw(state): show it. body(state): the answer. problems(state): messages, before it is sent.
 * doubts(state): questions before it is sent; who has read them may send it all the same.
 * feedback(state): for practice, {good, text}; without `good` there is no verdict. explain(state, right):
 * the same as a text, for an answer that isn't the right one of a study's own practice. undoable: whether undo is offered.
 */
export function begin({ initial, draw, body, problems, doubts = () => [], feedback, explain, undoable = true }) {
  const drafts = new Drafts(data.who, data, show);
  let state = drafts.latest?.body ?? (data.start ? { ...initial, ...data.start } : initial);
  let past = [];
  let future = [];
  let isSending = false;

  function show(kind, text) {
    $("saving").dataset.state = kind;
    $("saving").textContent = text;
  }

  function refresh() {
    $("undo").hidden = $("redo").hidden = !undoable;
    $("undo").disabled = !past.length;
    $("redo").disabled = !future.length;
    draw(state);
  }

  /** `silent` changes are drafted but are no step of undo: time watched, which clause is shown. */
  function change(next, { silent = false } = {}) {
    if (!silent) {
      past = [...past.slice(-LONGEST_HISTORY), state];
      future = [];
      tell([]);
      $("feedback").hidden = true;
    }
    state = next;
    drafts.keep(state);
    refresh();
  }

  function step(from, to, word) {
    if (!from.length) return;
    to.push(state);
    state = { ...from.pop(), ...watchedIn(state) };
    drafts.keep(state);
    refresh();
    announce(word);
  }
  const undo = () => step(past, future, _("Undone"));
  const redo = () => step(future, past, _("Done again"));

  function tell(messages) {
    $("problems").replaceChildren(
      ...(messages.length ? [h("ul", {}, messages.map((text) => h("li", {}, text)))] : []),
    );
  }

  async function submit(isSure = false) {
    if (isSending) return;
    const found = problems(state);
    tell(found);
    if (found.length) return;
    if (data.practice) return practise();
    const open = isSure ? [] : doubts(state);
    if (open.length) {
      tell(open);
      $("problems").append(h("button", { type: "button", onclick: () => submit(true) }, _("Send it all the same")));
      return;
    }
    const entry = {
      item: data.item,
      uuid: uuid(),
      body: body(state),
      at: Date.now(),
      ...(data.to && { to: data.to, comment: $("comment").value }),
    };
    try {
      put(data.who, entry);
    } catch {
      // kept in this page only; leaving it warns
    }
    await sendOff(entry);
  }

  async function sendOff(entry) {
    isSending = true;
    drafts.stop();
    $("submit").disabled = true;
    show("saving", _("Sending…"));
    const result = await deliver(data.who, entry, (message) => show("waiting", message));
    isSending = false;
    if (entry.item !== data.item) return;
    if (result.kept) {
      drafts.forget();
      show("saved", _("Sent"));
      announce(_("Sent. The next one comes now."));
      location.assign(result.next ?? data.next);
      return;
    }
    $("submit").disabled = false;
    drafts.resume();
    show("local", _("Not sent"));
    tell(result.problems.length ? result.problems.map((p) => p.message) : [result.error]);
  }

  async function practise() {
    const { good, text } = data.own ? ownFeedback(data.own, body(state), explain && ((right) => explain(state, right))) : feedback(state);
    const verdict = { true: _("Well done."), false: _("Not quite.") }[good] ?? _("Thank you.");
    const box = $("feedback");
    box.hidden = false;
    box.dataset.good = good ?? "open";
    box.replaceChildren(h("p", {}, h("strong", {}, verdict), " ", text));
    box.focus();
    if (data.keep) box.append(keeper(body(state)));
    if (good === false) return;
    // Kept before one can go on, and the focus stays where it is by then.
    if (data.signed_in) await send("POST", `/api/practice/${data.task}`, {}).catch(() => {});
    const onwards = h("p", {}, h("a", { class: "button primary", href: data.next }, _("Go on")));
    box.append(onwards);
    onwards.scrollIntoView({ block: "nearest" });
  }

  /** For those who set up a study: keep an answer to one of its practice items as right, or as wrong. */
  function keeper(answer) {
    const why = h("input", { "aria-label": "Why it is wrong", placeholder: "Why it is wrong", maxlength: 1000 });
    const said = h("span", { role: "status" });
    const keep = async (reason) => {
      const sent = await send("POST", data.keep, { body: answer, why: reason }).catch(() => null);
      said.textContent = sent?.status === 200 ? "Kept." : sent?.data.error ?? "There is no network.";
    };
    return h("fieldset", { class: "keeper" }, h("legend", {}, "For you, who set up the study"),
      h("button", { type: "button", onclick: () => keep("") }, "Keep it as the right answer"),
      why, h("button", { type: "button", onclick: () => (why.value.trim() ? keep(why.value) : why.focus()) }, "Keep it as a wrong one"), said);
  }

  async function note(name) {
    $("note-text").value = "";
    $("note").returnValue = "";
    const isSkip = name === "skip";
    $("note-title").textContent = isSkip ? _("Skip this one?") : _("What is the matter?");
    $("note-ok").textContent = isSkip ? _("Skip it") : _("Send the report");
    $("note-why").textContent = isSkip ? _("Why? If you like, tell the people who run the study") : _("Tell the people who run the study");
    $("note").showModal();
    await new Promise((done) => $("note").addEventListener("close", done, { once: true }));
    if ($("note").returnValue !== "ok") return;
    const reason = $("note-text").value;
    try {
      const path = `/api/items/${data.item}/${name}`;
      const sent = await send("POST", path, { uuid: uuid(), reason });
      if (sent.status !== 200) return tell([sent.data.error]);
      if (name === "flag") return show("saved", _("Reported. Thank you!"));
      drafts.forget();
      location.assign(sent.data.next);
    } catch {
      tell([_("There is no network. Try again in a while.")]);
    }
  }

  let heldUntil = 0; // by this page's clock

  /** The item was only held for a look; whoever does something has it on. */
  async function hold() {
    if (data.practice || data.to || isSending || Date.now() < heldUntil) return;
    heldUntil = Date.now() + HOLD_AGAIN_MS;
    try {
      const { status, data: reply } = await send("POST", `/api/items/${data.item}/begin`, {});
      if (status !== 200) heldUntil = 0;
      else if (!reply.leased) show("local", LOST);
    } catch {
      heldUntil = 0; // no network: the next action asks again
    }
  }
  for (const name of ["pointerdown", "keydown", "input", "play"]) {
    $("main").addEventListener(name, hold, { capture: true });
  }

  const singleKeys = $("single-keys");
  if (singleKeys) {
    singleKeys.checked = usesSingleKeys();
    singleKeys.addEventListener("change", () => useSingleKeys(singleKeys.checked));
    singleKeys.disabled = false;
  }
  $("submit").addEventListener("click", () => submit());
  $("undo").addEventListener("click", undo);
  $("redo").addEventListener("click", redo);
  $("skip")?.addEventListener("click", () => note("skip"));
  $("flag")?.addEventListener("click", () => note("flag"));
  document.addEventListener("keydown", (event) => {
    const control = event.ctrlKey || event.metaKey;
    if (!control) return;
    const key = event.key.toLowerCase();
    if (key === "enter") submit();
    else if (isTyping(event) || !undoable) return;
    else if (key === "z" && !event.shiftKey) undo();
    else if (key === "y" || key === "z") redo();
    else return;
    event.preventDefault();
  });
  window.addEventListener("beforeunload", (event) => {
    if (isSending || drafts.isBehind) event.preventDefault();
  });

  refresh();
  for (const id of ["submit", "skip", "flag"]) if ($(id)) $(id).disabled = false;
  if (drafts.latest) show(drafts.isBehind ? "local" : "saved", _("Your draft is back"));
  if (!data.practice) sendLeft(sendOff);
  return { change, get state() { return state; } };
}

/** What was watched stays watched, whatever is undone. */
function watchedIn({ watched, watched_s, speed, played_to_end }) {
  return {
    ...(played_to_end && { played_to_end }),
    ...(watched && { watched }),
    ...(watched_s !== undefined && { watched_s }),
    ...(speed !== undefined && { speed }),
  };
}

/** Send answers that an earlier page could not: this item's first, then others'. */
async function sendLeft(sendOff) {
  const left = entries(data.who);
  const own = left.find((entry) => entry.item === data.item);
  for (const entry of left) if (entry !== own) deliver(data.who, entry, () => {});
  if (own) await sendOff(own);
}

/** crypto.randomUUID is there over HTTPS only. */
function uuid() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  bytes[6] = (bytes[6] & 0x0f) | 0x40;
  bytes[8] = (bytes[8] & 0x3f) | 0x80;
  const hex = [...bytes].map((b) => b.toString(16).padStart(2, "0")).join("");
  return hex.replace(/^(.{8})(.{4})(.{4})(.{4})(.{12})$/, "$1-$2-$3-$4-$5");
}
