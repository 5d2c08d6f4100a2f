// Order of the site's search results: pages for users, pages for developers, then the API.
// Sphinx takes the numbers as they are here, its defaults, and calls `score` with each result.
var Scorer = {
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: {0: 15, 1: 5, 2: -5},
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
  score: ([page, title, anchor, description, score, file, kind]) => {
    if (kind === "object" || page.startsWith("reference/modules/")) return score - 1000;
    return /^(changelog|architecture|examples|contributing)/.test(page) ? score - 500 : score;
  },
};
