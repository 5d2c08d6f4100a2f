// The video player of all pages: a bar below the picture, which covers nothing of it.

import { showCameras } from "./cameras.js";
import { showCurves } from "./curves.js";
import { announce, h, isShortcut, s } from "./dom.js";
import { mediaUrl } from "./server.js";
import { keep, read } from "./storage.js";
import { _, decimal, number } from "./speech.js";

const SPEEDS = [0.5, 0.75, 1, 1.25, 1.5, 2, 3, 4];
const SPEED = "g3:speed";
const USUAL_FPS = 25;
const ENOUGH = 0.9;
const ICONS = {
  play: "M4 2v12l10-6z",
  pause: "M3 2h4v12H3zM9 2h4v12H9z",
  start: "M2 2h2v12H2zM14 2v12L5 8z",
  back: "M11 2v12L3 8zM12 2h2v12h-2z",
  on: "M5 2v12l8-6zM2 2h2v12H2z",
  alike: "M1 2h6v5H1zM9 2h6v5H9zM1 9h6v5H1zM9 9h6v5H9z",
  full: "M2 2h5v2H4v3H2zM9 2h5v5h-2V4H9zM2 9h2v3h3v2H2zM12 9h2v5H9v-2h3z",
};
const players = new WeakMap();
let active = null; // whose keys they are, where a page has several

for (const box of document.querySelectorAll("[data-player]")) equip(box);
document.addEventListener("keydown", press);

/** The player of a box that a template has made. */
export const playerOf = (box) => players.get(box) ?? equip(box);

/**
 * Give the video in a box a bar. The box tells `data-fps` and `data-duration`, if they are known. What is shown beside the
 * video is in `data-beside`, or in the data of a task's page.
 *
 * Gives {element, video, note, seek(t), time}; `moved(t)` is called as the video goes on.
 */
export function equip(box, moved = () => {}) {
  const video = box.querySelector("video");
  const note = h("p", { class: "note", role: "status" });
  let fps = Number(box.dataset.fps) || 0;
  const beside = JSON.parse(box.dataset.beside ?? "null") ?? besideOfPage(video) ?? {};
  const cameras = beside.views?.length ? showCameras(box, video, beside) : null;

  const button = (icon, label, onclick, more = {}) =>
    h("button", { type: "button", title: label, "aria-label": label, onclick, ...more }, drawn(icon));
  const name = h("span", {}, _("Play"));
  const play = h("button", { type: "button", class: "play", title: _("Play or pause (K)"), onclick: toggle }, drawn("play"), name);
  const toStart = button("start", _("To the start"), () => go(0), { class: "to-start" });
  const slider = h("input", { type: "range", min: 0, max: 1, step: "any", value: 0, "aria-label": _("Time in the video, in seconds") });
  const clock = h("span", { class: "clock" });
  const speed = h(
    "select",
    { "aria-label": _("Speed"), title: _("Speed (< slower, > faster)"), onchange: () => setSpeed(Number(speed.value)) },
    SPEEDS.map((value) => h("option", { value }, `${decimal(value)}×`)),
  );
  const full = document.fullscreenEnabled
    ? button("full", _("Full screen"), () => (document.fullscreenElement ? document.exitFullscreen() : box.requestFullscreen()))
    : null;
  const alike = cameras && button("alike", _("All cameras alike"), () => setAlike(!cameras.isAlike), { "aria-pressed": cameras.isAlike });
  const bar = h(
    "div",
    { class: "player-bar", dir: "ltr", role: "group", "aria-label": _("Controls of the video") },
    play, toStart,
    button("back", _("One frame back (,)"), () => step(-1)),
    button("on", _("One frame on (.)"), () => step(1)),
    h("span", { class: "player-time" }, slider, clock), speed, alike ?? "", full ?? "",
  );

  function setAlike(yes) {
    cameras.setAlike(yes);
    alike.setAttribute("aria-pressed", cameras.isAlike);
  }
  function nextCamera() {
    if (!cameras) return;
    cameras.next();
    alike.setAttribute("aria-pressed", false);
  }
  /** As the server has measured it: browsers may not know yet, or take a header's word for it. */
  function duration() {
    const measured = Number(box.dataset.duration);
    if (measured > 0) return measured;
    return Number.isFinite(video.duration) ? video.duration : 0;
  }

  function toggle() {
    active = player;
    if (video.paused) video.play().catch(() => {}); // an error says so itself
    else video.pause();
  }
  function seek(t) {
    video.currentTime = t;
    show(t);
  }
  function go(t) {
    active = player;
    video.pause();
    seek(t);
  }
  /** To the middle of the frame before or after: what is shown there is never in doubt. */
  function step(by) {
    const rate = fps || USUAL_FPS;
    const last = Math.max(Math.ceil(duration() * rate - 1e-3) - 1, 0);
    const shown = Math.min(Math.floor(video.currentTime * rate + 1e-3), last); // also at the very end
    const frame = Math.min(Math.max(shown + by, 0), last);
    go(frame ? (frame + 0.5) / rate : 0);
  }
  function show(t) {
    slider.max = duration();
    slider.step = fps ? 1 / fps : "any";
    slider.value = t;
    slider.setAttribute("aria-valuetext", _("%(time)s seconds", { time: number(t) }));
    clock.textContent = _("%(time)s / %(whole)s s", { time: number(Math.min(t, duration())), whole: number(duration()) });
    toStart.disabled = t === 0;
    curves?.at(t);
    moved(t);
  }
  function setSpeed(value) {
    video.defaultPlaybackRate = video.playbackRate = value;
    speed.value = value;
    keep(SPEED, String(value));
  }
  /** The speed before or after. */
  function changeSpeed(by) {
    const at = SPEEDS.indexOf(Number(speed.value)) + by;
    if (SPEEDS[at]) setSpeed(SPEEDS[at]);
    announce(_("Speed %(speed)s", { speed: decimal(Number(speed.value)) }));
  }
  /** Where nobody has told the frames' rate, the two nearest frames do: a busy browser leaves some out. */
  function measure(before) {
    video.requestVideoFrameCallback((_now, { mediaTime }) => {
      const rate = Math.round(1 / Math.abs(mediaTime - before));
      if (rate <= 120) fps = Math.max(fps, rate);
      measure(mediaTime);
    });
  }

  const player = { element: box, video, note, seek, toggle, step, changeSpeed, nextCamera, get duration() { return duration(); }, get time() { return video.currentTime || 0; } };
  const curves = beside.curves ? showCurves(beside, { video, go, step, get duration() { return duration(); } }) : null;
  players.set(box, player);
  active ??= player;
  video.controls = false;
  video.tabIndex = 0;
  const kept = Number(read(SPEED));
  if (isBegun(video)) speed.value = video.playbackRate;
  else setSpeed(SPEEDS.includes(kept) ? kept : 1);
  slider.addEventListener("input", () => go(Number(slider.value)));
  video.addEventListener("click", toggle);
  video.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    toggle();
  });
  if (!fps && video.requestVideoFrameCallback) measure(NaN);
  for (const what of ["play", "pause", "ended"]) {
    video.addEventListener(what, () => {
      name.textContent = video.paused ? _("Play") : _("Pause");
      play.replaceChildren(drawn(video.paused ? "play" : "pause"), name);
    });
  }
  for (const what of ["timeupdate", "seeked", "loadedmetadata"]) {
    video.addEventListener(what, () => show(video.currentTime));
  }
  const failure = h(
    "p",
    { class: "note", "data-kind": "open", role: "alert" },
    _("The video can't be played."), " ",
    h("button", { type: "button", onclick: () => { failure.hidden = true; video.load(); } }, _("Try again")),
  );
  failure.hidden = !video.error;
  video.addEventListener("error", () => (failure.hidden = false));
  box.append(bar, note, failure, curves?.element ?? "");
  show(isBegun(video) ? video.currentTime : 0);
  catchUp(video);
  return player;
}

/** When the frame begins that a video shows, in seconds. */
export function shownFrom(video, fps) {
  const seconds = fps ? Math.floor(video.currentTime * fps + 1e-3) / fps : video.currentTime;
  return Math.round(seconds * 1000) / 1000;
}

/** Have a player's video watched to its end: `watched({watched_s, speed})` is called when it has been. */
export function watchToEnd(player, alreadyWatched, watched) {
  const { video, note } = player;
  let isDone = alreadyWatched;
  let fastest = 0;

  function say(text, kind) {
    note.textContent = text;
    note.dataset.kind = kind;
  }
  function timed() {
    if (!video.paused) fastest = Math.max(fastest, video.playbackRate);
  }
  video.addEventListener("play", timed);
  video.addEventListener("ratechange", timed);
  video.addEventListener("ended", () => {
    if (isDone) return;
    const seconds = played(video);
    if (seconds < ENOUGH * player.duration) {
      say(_("You have left out a part of the video. Watch that too, please."), "open");
      return;
    }
    isDone = true;
    say(_("You have watched it to the end. You can watch it again."), "done");
    watched({ watched_s: Math.round(seconds * 10) / 10, speed: fastest || video.playbackRate });
  });
  say(
    isDone ? _("You have watched it to the end. You can watch it again.")
      : _("Watch the video to its end before you send."),
    isDone ? "done" : "open",
  );
  catchUp(video);
}

/** What is shown beside a video by the data of a task's page, if they are about this video. */
function besideOfPage(video) {
  const { payload } = JSON.parse(document.getElementById("item")?.textContent ?? "{}");
  return payload?.video && mediaUrl(payload.video) === video.getAttribute("src") ? payload.beside : null;
}

/** Whether somebody has used the browser's own controls, which are there before this script is. */
function isBegun(video) {
  return !video.paused || video.played.length > 0;
}

/** Have listeners know of what was played before they were there. */
function catchUp(video) {
  if (!video.paused) video.dispatchEvent(new Event("play"));
  if (video.ended) video.dispatchEvent(new Event("ended"));
}

/** How many seconds of a video have been played, at any speed. */
function played(video) {
  let seconds = 0;
  for (let i = 0; i < video.played.length; i += 1) {
    seconds += video.played.end(i) - video.played.start(i);
  }
  return seconds;
}

function press(event) {
  if (!active || !isShortcut(event) || !active.element.isConnected) return;
  const does = {
    k: active.toggle,
    ",": () => active.step(-1),
    ".": () => active.step(1),
    "<": () => active.changeSpeed(-1),
    ">": () => active.changeSpeed(1),
    v: active.nextCamera,
  }[event.key.toLowerCase()];
  if (!does) return;
  event.preventDefault();
  does();
}

function drawn(icon) {
  return s("svg", { class: "icon", viewBox: "0 0 16 16", width: 16, height: 16, "aria-hidden": "true" }, s("path", { d: ICONS[icon] }));
}
