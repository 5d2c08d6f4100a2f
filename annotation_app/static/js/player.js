// The video of Describe and Rate, and watching any video to its end.

import { h } from "./dom.js";
import { mediaUrl } from "./server.js";

const ENOUGH = 0.9;

/** Show a video; `watched(seconds)` is called when all of it has been played. */
export function showVideo(container, payload, alreadyWatched, watched) {
  const note = h("p", { class: "note", role: "status" });
  const video = h("video", {
    controls: true,
    controlslist: "nodownload noplaybackrate",
    disablepictureinpicture: true,
    playsinline: true,
    preload: "auto",
    muted: true,
    "aria-label": "The video",
    poster: payload.poster && mediaUrl(payload.poster),
    src: mediaUrl(payload.video),
  });
  watchToEnd(video, note, alreadyWatched, watched);
  video.addEventListener("error", () => {
    const again = h("button", { type: "button", onclick: () => video.load() }, "Try again");
    note.replaceChildren("The video can't be played. ", again);
    note.dataset.kind = "open";
  });
  container.append(video, note);
  return video;
}

/** Tell in a note whether a video was watched, and call `watched(seconds)` when it has been. */
export function watchToEnd(video, note, alreadyWatched, watched) {
  let isDone = alreadyWatched;

  function say(text, kind) {
    note.textContent = text;
    note.dataset.kind = kind;
  }

  video.addEventListener("ended", () => {
    if (isDone) return;
    const seconds = played(video);
    if (seconds < ENOUGH * video.duration) {
      say("You have left out a part of the video. Watch that too, please.", "open");
      return;
    }
    isDone = true;
    say("You have watched it to the end. You can watch it again.", "done");
    watched(Math.round(seconds * 10) / 10);
  });
  say(
    isDone ? "You have watched it to the end. You can watch it again."
      : "Watch the video to its end before you send.",
    isDone ? "done" : "open",
  );
}

function played(video) {
  let seconds = 0;
  for (let i = 0; i < video.played.length; i += 1) {
    seconds += video.played.end(i) - video.played.start(i);
  }
  return seconds;
}
