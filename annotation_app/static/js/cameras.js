// Further cameras beside a player's video, on its clock. One is large, the others are small.

import { announce, h } from "./dom.js";
import { mediaUrl } from "./server.js";
import { keep, read } from "./storage.js";
import { _ } from "./speech.js";

const LARGE = "g3:camera";
const ALIKE = "g3:cameras-alike";
const EVERY_MS = 100;
const EXACT_S = 0.0001; // the same frame
const SAME_S = 0.004; // players that play are hardly more exact
const FAR_S = 0.4; // from here on a camera is put to the place, below it catches up
const CATCH_UP_S = 0.5;
const MOST_FASTER = 0.3;

/**
 * Show the `views` of other cameras beside the video of a player's box.
 *
 * `cameras` has the names of all, that of the video first. Gives {element, next(), setAlike(yes), isAlike}.
 */
export function showCameras(box, video, { cameras, views }) {
  const others = views.map((id, i) =>
    h("video", {
      src: mediaUrl(id), preload: video.preload, playsinline: true, disablepictureinpicture: true,
      "aria-label": _("The video of the camera %(camera)s", { camera: cameras[i + 1] }),
    }),
  );
  for (const other of others) {
    other.muted = true;
    other.addEventListener("click", () => video.click());
  }
  const screens = [box.querySelector(".screen"), ...others.map((other) => h("div", { class: "screen" }, other))];
  const choosers = cameras.map((name, i) =>
    h("button", { type: "button", class: "choose", title: _("Show this camera large (V: the next one)"), onclick: () => enlarge(i) }, h("span", { dir: "auto" }, name)),
  );
  const element = h("div", { class: "cameras", "data-small": others.length });
  screens[0].before(element);
  element.append(...screens.map((screen, i) => h("div", { class: "camera" }, screen, choosers[i])));
  let large = Math.max(cameras.indexOf(read(LARGE)), 0);

  function draw() {
    [...element.children].forEach((camera, i) => camera.classList.toggle("large", i === large));
    choosers.forEach((button, i) => button.setAttribute("aria-pressed", i === large));
    element.classList.toggle("alike", isAlike());
  }
  function enlarge(i) {
    large = i;
    keep(LARGE, cameras[i]);
    keep(ALIKE, "");
    draw();
    announce(_("Large: %(camera)s", { camera: cameras[i] }));
  }
  function setAlike(yes) {
    keep(ALIKE, yes ? "yes" : "");
    draw();
  }
  draw();
  keepInStep(video, others);
  return { element, next: () => enlarge((large + 1) % cameras.length), setAlike, get isAlike() { return isAlike(); } };
}

const isAlike = () => read(ALIKE) === "yes";

/** Have other videos show the moment that a video shows. */
function keepInStep(video, others) {
  let timer = 0;

  const ahead = (other) => video.currentTime - other.currentTime;
  function place(other) {
    const to = Math.min(video.currentTime, Number.isFinite(other.duration) ? other.duration : Infinity);
    if (Math.abs(other.currentTime - to) > EXACT_S) other.currentTime = to;
  }
  function correct() {
    for (const other of others) {
      const gap = ahead(other);
      if (other.seeking || other.ended) continue;
      if (Math.abs(gap) > FAR_S * video.playbackRate) place(other);
      const faster = Math.abs(gap) < SAME_S ? 0 : gap / CATCH_UP_S;
      const rate = video.playbackRate * (1 + Math.max(-MOST_FASTER, Math.min(faster, MOST_FASTER)));
      if (Math.abs(other.playbackRate - rate) > 0.002) other.playbackRate = rate;
      if (other.paused) other.play().catch(() => {}); // it shows its moment when it can
    }
  }
  function go() {
    clearInterval(timer);
    timer = setInterval(correct, EVERY_MS);
    correct();
  }
  function halt() {
    clearInterval(timer);
    for (const other of others) other.pause();
  }
  function stand() {
    others.forEach(place);
  }
  video.addEventListener("playing", go);
  video.addEventListener("waiting", halt);
  video.addEventListener("ended", () => (halt(), stand()));
  video.addEventListener("pause", () => {
    halt();
    // What is on the screen may be a frame behind the clock, to which the others go.
    if (!video.ended && !video.seeking) video.currentTime = video.currentTime;
    stand();
  });
  for (const what of ["seeking", "seeked"]) video.addEventListener(what, stand);
  for (const other of others) {
    other.addEventListener("loadedmetadata", stand);
    other.addEventListener("seeked", () => video.paused && !video.seeking && stand());
  }
  if (!video.paused) go();
}
