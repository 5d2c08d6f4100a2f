// Keeps the numbers of a page fresh while somebody looks at them.
const PERIOD_MS = 30000;

async function refresh() {
  const shown = document.querySelector("[data-live]");
  if (document.hidden || !shown || shown.contains(document.activeElement)) return;
  const reply = await fetch(location.href, { redirect: "error" });
  if (!reply.ok) return;
  const page = new DOMParser().parseFromString(await reply.text(), "text/html");
  const fresh = page.querySelector("[data-live]");
  if (fresh) shown.replaceWith(document.adoptNode(fresh));
}

// Without a connection the numbers stay as they are until the next time.
setInterval(() => refresh().catch(() => {}), PERIOD_MS);
