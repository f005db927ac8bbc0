// SPDX-License-Identifier: Apache-2.0
// The last lines of the journal.

import { byId, tableRows } from "/page/dom.js";
import { dayAndTime, instant } from "/page/words.js";

const SHOWN = 50;
const SIGNS = { error: "✕", warning: "!", notice: "·", info: "·" };
const CLASSES = { error: "bad", warning: "warn" };

export class Events {
  constructor() {
    this.lines = new Map();  // by id: they come again with each new stream
    this.rows = tableRows(byId("event-rows"), (it) => it.id, [
      ["Time", (it) => dayAndTime(instant(it.at))],
      ["Level", (it) => `${SIGNS[it.level] ?? "·"} ${it.level}`, (it) => CLASSES[it.level] ?? ""],
      ["Event", (it) => it.text],
    ]);
  }

  add(id, json) {
    if (this.lines.has(id)) {
      return;
    }
    this.lines.set(id, { id, ...json });
    for (const old of [...this.lines.keys()].slice(0, -SHOWN)) {
      this.lines.delete(old);
    }
    this.timer ??= setTimeout(() => {
      this.timer = null;
      byId("no-events").hidden = true;
      this.rows.show([...this.lines.values()].reverse());
    }, 100);
  }
}
