// Keeps the numbers of the progress table fresh while somebody looks at them.
const PERIOD_MS = 15000;
const table = document.getElementById("by-task");

async function refresh() {
  if (document.hidden) return;
  const reply = await fetch(table.dataset.source, { headers: { Accept: "application/json" } });
  if (!reply.ok) return;
  for (const progress of (await reply.json()).data) {
    const row = table.querySelector(`[data-task="${progress.task}"]`);
    if (!row) continue;
    const percent = progress.wanted ? Math.floor((100 * progress.answered) / progress.wanted) : 0;
    for (const [field, value] of Object.entries({ ...progress, percent })) {
      const cell = row.querySelector(`[data-field="${field}"]`);
      if (cell) cell.textContent = value;
    }
    const bar = row.querySelector("progress");
    bar.max = progress.wanted;
    bar.value = progress.answered;
  }
}

// Without a connection the numbers stay as they are until the next time.
setInterval(() => refresh().catch(() => {}), PERIOD_MS);
