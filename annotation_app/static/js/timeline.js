// A part of a video: a timeline with a handle at each end, for the mouse, fingers and keys.

import { h } from "./dom.js";
import { _, number } from "./speech.js";

const SECOND = 1;

/**
 * Show a timeline. `duration` in seconds; `frame` is how long one frame lasts; `marks` are times that may be ends;
 * `moved(t)` is called while a handle or the cursor is moved, so that the video shows that moment;
 * `chosen([start, end])` when one has been set: null for an end that nobody has set yet.
 */
export function showTimeline({ duration, frame, marks = [], moved, chosen }) {
  const ends = [null, null];
  const NAMES = ["Start", "End"];
  const LABELS = [_("Start of the part"), _("End of the part")];
  const selection = h("div", { class: "selection" });
  const cursor = h("div", { class: "now" });
  const handles = NAMES.map((name, i) =>
    h("div", {
      class: `handle handle-${name.toLowerCase()}`, role: "slider", tabindex: 0, "aria-label": LABELS[i],
      "aria-valuemin": 0, "aria-valuemax": duration, "data-key": name,
      onkeydown: (event) => byKey(i, event),
      onpointerdown: (event) => grab(event, (t) => put(i, t), () => tell()),
    }),
  );
  const track = h("div", {
    class: "track",
    onpointerdown: (event) => event.target.closest(".handle") || grab(event, (t) => seek(t), () => {}),
  }, selection, ...marks.map(tick), cursor, ...handles);
  const element = h("div", { class: "timeline", dir: "ltr" }, track);

  const place = (part, t) => part.style.setProperty("left", `${(100 * t) / duration}%`);
  function tick(t) {
    const line = h("div", { class: "tick" });
    line.style.setProperty("left", `${(100 * t) / duration}%`);
    return line;
  }
  const rest = (i) => ends[i] ?? (i ? duration : 0);
  /** Whole frames, and the start before the end. */
  function within(i, t) {
    const steps = Math.round(t / frame) * frame;
    const [low, high] = i ? [rest(0) + frame, duration] : [0, rest(1) - frame];
    return Math.round(1000 * Math.max(low, Math.min(high, steps))) / 1000;
  }
  function put(i, t) {
    ends[i] = within(i, t);
    draw();
    seek(ends[i]);
  }
  function seek(t) {
    place(cursor, t);
    moved(t);
  }
  const tell = () => chosen([...ends]);

  function grab(event, move, end) {
    event.preventDefault();
    const target = event.currentTarget;
    target.focus?.({ preventScroll: true });
    target.setPointerCapture(event.pointerId);
    const time = ({ clientX }) => {
      const box = track.getBoundingClientRect();
      return Math.max(0, Math.min(1, (clientX - box.left) / box.width)) * duration;
    };
    const follow = (moving) => move(time(moving));
    follow(event);
    target.addEventListener("pointermove", follow);
    target.addEventListener("lostpointercapture", () => {
      target.removeEventListener("pointermove", follow);
      end();
    }, { once: true });
  }

  function byKey(i, event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    const pages = { PageDown: -SECOND, PageUp: SECOND }[event.key];
    const to = event.key === "Home" ? 0 : event.key === "End" ? duration
      : steps ? rest(i) + steps * (event.shiftKey ? SECOND : frame)
      : pages ? rest(i) + pages : null;
    if (to === null) return;
    event.preventDefault();
    event.stopPropagation();
    put(i, to);
    tell();
  }

  function draw() {
    handles.forEach((handle, i) => {
      const t = rest(i);
      place(handle, t);
      handle.classList.toggle("unset", ends[i] === null);
      handle.setAttribute("aria-valuenow", t);
      handle.setAttribute("aria-valuetext", ends[i] === null ? _("not set") : _("%(time)s seconds", { time: number(t) }));
    });
    place(selection, rest(0));
    selection.style.setProperty("width", `${(100 * (rest(1) - rest(0))) / duration}%`);
    selection.hidden = ends[0] === null && ends[1] === null;
  }
  draw();
  place(cursor, 0);
  return {
    element,
    /** Set an end, 0 or 1, to a time of the video. */
    set(i, t) {
      put(i, t);
      tell();
    },
    /** Show a part, of which an end may be null. */
    show([start, end]) {
      [ends[0], ends[1]] = [start, end];
      draw();
    },
    /** Show where the video is. */
    at(t) { place(cursor, Math.min(t, duration)); },
  };
}
