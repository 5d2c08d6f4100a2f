// On the page of all tasks: send what is left in the browser.

import { $ } from "./dom.js";
import { deliver, entries } from "./outbox.js";
import { _ } from "./speech.js";

const box = $("outbox");
for (const entry of entries(box.dataset.who)) {
  box.hidden = false;
  box.textContent = _("An answer was not sent yet. Sending it now…");
  const result = await deliver(box.dataset.who, entry, (message) => (box.textContent = message));
  box.textContent = result.kept
    ? _("An answer that was not sent yet has now been sent.")
    : _("An answer could not be kept: %(why)s", { why: result.error });
}
