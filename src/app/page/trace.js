// SPDX-License-Identifier: Apache-2.0
// The live trace: the last transactions that pass the filter, and the decoded view of one.

import { byId, element, setOptions, setText, tableRows } from "/page/dom.js";
import { between, instant, timeOfDay } from "/page/words.js";

const KEPT = 2000;
const SHOWN = 60;
const INTERVAL = 250;  // ms between two looks
const NOBODY = "–";  // in place of a client

/** One line of the list. */
function lineOf(id, json) {
  const [wire] = json.wire;
  const at = json.request ? instant(json.request.at) : instant(wire.sent?.at ?? wire.heard[0]?.at ?? wire.ended_at);
  const targets = json.targets ?? json.wire.map(({ bus, device }) => ({ bus, device }));
  const answer = json.answer ? json.answer.text : (json.ended ?? wire?.heard_text ?? "no answer");
  return {
    id, json, at,
    client: json.client?.address ?? NOBODY,
    buses: [...new Set([...targets, ...json.wire].map(({ bus }) => bus))],
    devices: [...new Set([...targets, ...json.wire].map(({ device }) => device).filter((name) => name !== null))],
    function: json.request ? parseInt(json.request.bytes.slice(21, 23), 16) : null,
    request: json.request ? json.request.text : (wire.sent?.text ?? "no request"),
    answer: (json.failed ? "✕ " : "✓ ") + answer,
    took: json.answer ? between(at, instant(json.answer.at)) : "–",
  };
}

export class Trace {
  constructor(history, decoded) {
    this.history = history;
    this.decoded = decoded;
    this.lines = [];
    this.count = 0;
    this.lost = 0;
    this.isPaused = false;
    this.rows = tableRows(byId("trace-rows"), (it) => String(it.id), [
      ["Time", (it) => () => this.opener(it)],
      ["Client", (it) => it.client],
      ["Device", (it) => it.devices.join(", ") || it.buses.join(", ") || "–"],
      ["Request", (it) => it.request],
      ["Answer", (it) => it.answer, (it) => (it.json.failed ? "bad" : "")],
      ["Took", (it) => it.took],
    ]);
    const names = ["bus", "device", "client", "function", "text", "failed"];
    this.fields = Object.fromEntries(names.map((name) => [name, byId(`trace-${name}`)]));
    const form = byId("trace-filter");
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("input", () => this.show());
    form.addEventListener("change", () => this.show());
    byId("trace-pause").addEventListener("click", (event) => {
      this.isPaused = !this.isPaused;
      event.currentTarget.setAttribute("aria-pressed", String(this.isPaused));
      this.show();
    });
    this.show();
  }

  opener(line) {
    const button = element("button", { type: "button", class: "link" }, timeOfDay(line.at, 3));
    button.addEventListener("click", () => this.decoded.record(line.json, (bus) => this.history.character(bus)));
    return button;
  }

  add(json) {
    this.count += 1;
    const line = lineOf(this.count, json);
    this.lines.push(line);
    if (this.lines.length > KEPT) {
      this.lines.shift();
    }
    this.showSoon();
  }

  addLost(count) {
    this.lost += count;
    this.showSoon();
  }

  /** Addresses to choose from: of those that are connected and of the lines that are kept, and the one that is chosen. */
  clients(connected) {
    const lines = [...this.lines, ...(this.held ?? [])];
    const all = new Set([...connected.map(({ address }) => address), ...lines.map(({ client }) => client)]);
    all.add(this.fields.client.value);
    all.delete("");
    all.delete(NOBODY);
    return [...all].sort();
  }

  status(status) {
    setOptions(this.fields.bus, status.buses.map(({ name }) => name));
    setOptions(this.fields.device, status.devices.filter(({ name }) => name !== null).map(({ name }) => name));
    setOptions(this.fields.client, this.clients(status.clients));
  }

  matches() {
    const { bus, device, client, text, failed } = this.fields;
    const code = this.fields.function.value.trim();
    const number = /^0x[0-9a-f]+$/i.test(code) || /^\d+$/.test(code) ? Number(code) : null;
    const isWrong = code !== "" && number === null;
    this.fields.function.setAttribute("aria-invalid", String(isWrong));
    const words = text.value.toLowerCase();
    return (line) => (bus.value === "" || line.buses.includes(bus.value))
      && (device.value === "" || line.devices.includes(device.value))
      && (client.value === "" || line.client === client.value)
      && (code === "" || line.function === number)
      && (!failed.checked || line.json.failed)
      && (words === "" || `${line.request} ${line.answer}`.toLowerCase().includes(words));
  }

  showSoon() {
    this.timer ??= setTimeout(() => {
      this.timer = null;
      if (!this.isPaused) {
        this.show();
      }
    }, INTERVAL);
  }

  show() {
    if (this.isPaused) {
      this.held ??= this.lines.slice();
    } else {
      this.held = null;
    }
    const all = this.held ?? this.lines;
    const matching = all.filter(this.matches());
    this.rows.show(matching.slice(-SHOWN).reverse());
    const lost = this.lost > 0 ? `; ${this.lost} more were dropped, because they were too many for this page` : "";
    const last = matching.length > SHOWN ? `, the last ${SHOWN} shown` : "";
    setText(byId("trace-count"), `${matching.length} of the last ${all.length} transactions match${last}${lost}.`);
  }
}
