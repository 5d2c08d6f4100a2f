// A file of curves, read in parts: corpus_tools/tables/curve_file.py says how it is laid out.

import { mediaUrl } from "./server.js";

const HEAD_BYTES = 1 << 16; // holds the header and the coarsest array
const BLOCK_BYTES = 1 << 16;
const AT_ONCE = 3;
const MOST_BLOCKS = 400;

/**
 * Open a file of curves by its name among media. `came(level)` is called when a part of an array has come that was missing.
 *
 * Gives {curves, rate, samples, levels, part(level, first, end)}.
 */
export async function openCurves(id, came) {
  const url = mediaUrl(id);
  const head = await fetched(url, 0, HEAD_BYTES);
  const start = 8 + Number(new DataView(head).getBigUint64(0, true));
  const { __metadata__: about, ...arrays } = JSON.parse(new TextDecoder().decode(head.slice(8, start)));
  const levels = Object.keys(arrays).sort((a, b) => a - b).map((name) => {
    const { shape, data_offsets: [offset] } = arrays[name];
    const width = shape.slice(1).reduce((a, b) => a * b); // numbers of a row
    return { rows: shape[0], width, at: start + offset, ofBlock: Math.max(Math.floor(BLOCK_BYTES / 4 / width), 1) };
  });
  const blocks = new Map();
  const wanted = new Map();
  let atWork = 0;

  /** A run of rows that hasn't come yet is null, and asked for. */
  function block(level, number) {
    const key = `${level}:${number}`;
    const there = blocks.get(key);
    if (there) return there;
    const { rows, width, at, ofBlock } = levels[level];
    const first = number * ofBlock;
    const from = at + 4 * width * first;
    const to = from + 4 * width * Math.min(ofBlock, rows - first);
    if (to <= head.byteLength) return keep(key, head.slice(from, to));
    if (!wanted.has(key)) wanted.set(key, { from, to, isComing: false });
    goOn();
    return null;
  }
  function keep(key, bytes) {
    const numbers = new Float32Array(bytes);
    blocks.set(key, numbers);
    if (blocks.size > MOST_BLOCKS) blocks.delete(blocks.keys().next().value);
    return numbers;
  }
  /** What was asked for last comes first: of a quick drag only the end matters. */
  function goOn() {
    const next = [...wanted].filter(([, one]) => !one.isComing).at(-1);
    if (!next || atWork >= AT_ONCE) return;
    const [key, one] = next;
    one.isComing = true;
    atWork += 1;
    fetched(url, one.from, one.to)
      .then((bytes) => keep(key, bytes), () => null) // asked for again when it is needed
      .then(() => {
        atWork -= 1;
        wanted.delete(key);
        for (const [old, { isComing }] of wanted) if (!isComing && wanted.size > 2 * AT_ONCE) wanted.delete(old);
        came(Number(key.split(":")[0]));
        goOn();
      });
  }
  return {
    curves: JSON.parse(about.curves),
    rate: Number(about.rate),
    samples: levels[0].rows,
    levels,
    /** The blocks that hold the rows from `first` to before `end`, as [row of the first number, numbers]; null if one is missing. */
    part(level, first, end) {
      const { ofBlock } = levels[level];
      const found = [];
      for (let number = Math.floor(first / ofBlock); number * ofBlock < end; number += 1) {
        found.push([number * ofBlock, block(level, number)]);
      }
      return found.every(([, numbers]) => numbers) ? found : null;
    },
  };
}

async function fetched(url, from, to) {
  const response = await fetch(url, { headers: { Range: `bytes=${from}-${to - 1}` } });
  if (!response.ok) throw new Error(`${response.status}`);
  const bytes = await response.arrayBuffer();
  return response.status === 206 ? bytes : bytes.slice(from, to); // without ranges all has come
}
