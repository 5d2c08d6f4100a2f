// What people are told about their answers to the practice examples, which are about a boat.

import { data } from "./work.js";

const answer = (good, text) => ({ good, text });

/** What the study's file says to an answer to a practice item of its own. */
export function ownFeedback({ rating }) {
  const isRight = rating === undefined || data.own.right.includes(rating);
  return answer(isRight, isRight ? data.own.good : data.own.again);
}

/** No pattern can tell a good command from a bad one: people compare theirs with some. */
export function describeFeedback() {
  return {
    text: "Compare yours with some that would do: “Sail over to the buoy next to the lighthouse.” “The buoy that is by the lighthouse: go there.” “Head for the lighthouse and stop at its buoy.” All say what is to be done, and to which buoy. Yours may be quite different.",
  };
}

export function subtasksFeedback() {
  return {
    text: "Compare yours with some that would do: “Sail over to the buoy” from 0 s is enough. “Wait” from 0 s and “Sail to the buoy” from about 0.5 s would do, too. Each says what is done, and from when on.",
  };
}

const shape = (sdcs) => JSON.stringify(sdcs.map(plain));
const text = (list) => (list ?? []).map(([word]) => word).join(" ");

function plain(clause) {
  const isWords = Array.isArray(clause.f?.[0]);
  const below = (field) => (clause[field] ?? []).filter((c) => !Array.isArray(c)).map(plain);
  return [clause.type, isWords ? text(clause.f) : below("f"), text(clause.r), below("l"), below("l2")];
}

export function segmentFeedback(sdcs) {
  const object = (words) => ({ type: "OBJECT", f: words.split(" ").map((word) => [word, 0]) });
  const robot = [{ type: "OBJECT" }];
  const buoy = { type: "OBJECT", f: [object("the buoy")], r: [["by", 0]], l: [object("the lighthouse")] };
  const tree = (field, type, landmark) => [
    { type: "EVENT", f: robot, r: [["Sail", 0]], [field]: [{ type, r: [["to", 0]], l: [landmark] }] },
  ];
  const right = ["l", "l2"].flatMap((field) => ["PATH", "PLACE"].map((type) => shape(tree(field, type, buoy))));
  const found = shape(sdcs.map((c) => ({ ...c, r: c.r })));
  if (right.includes(found)) return answer(true, "That is how we would mark it, too.");
  const events = sdcs.filter((c) => c.type === "EVENT");
  if (!events.length) return answer(false, "Choose “Sail” and make it an EVENT that stands alone.");
  if (!found.includes("PATH")) return answer(false, "“to” is a PATH: the landmark of “Sail”.");
  if (!/"by"/.test(found)) return answer(false, "The buoy is described by the lighthouse: the OBJECT “the buoy” has the relation “by” and the landmark “the lighthouse”.");
  return answer(false, "EVENT “Sail” has the landmark PATH “to”, which has the landmark OBJECT “by”; its figure is “the buoy” and its landmark “the lighthouse”.");
}

export function groundFeedback({ groundings }) {
  const chosen = (node) => [...(groundings[node]?.objects ?? [])].sort().join();
  const wrong = Object.entries({ 3: "thing-c", 4: "thing-c", 5: "thing-d" }).find(([node, id]) => chosen(node) !== id);
  if (!wrong) return answer(true, "The boat sails to the buoy that is by the lighthouse.");
  if (wrong[0] === "5") return answer(false, "“the lighthouse” is the tower on the small island.");
  return answer(false, "Play the video: to which buoy does the boat sail? Choose that one, and no other.");
}

export function checkFeedback({ verdicts }) {
  if (verdicts[4] !== true) return answer(false, "“the buoy” alone could mean any buoy, so what is marked matches.");
  if (verdicts[5] !== false) return answer(false, "Nobody would call what is marked “the lighthouse”.");
  return answer(true, "Look at nothing but the words of the clause: that is right.");
}

export function rateFeedback({ rating }) {
  if (rating >= 4) return answer(true, "The boat does sail to the buoy by the lighthouse.");
  return answer(false, "Watch again: the boat sails to the buoy by the lighthouse. Most people would agree.");
}
