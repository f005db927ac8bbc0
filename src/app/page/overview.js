// SPDX-License-Identifier: Apache-2.0
// Findings, buses, devices and clients, as the last status has them.

import { Keyed, byId, element, setClass, setText, tableRows, terms } from "/page/dom.js";
import { here, pointsKey } from "/page/history.js";
import { plotLatency, plotLoad } from "/page/plot.js";
import { slowness, whyOfBus, whyOfDevice } from "/page/why.js";
import { count, deviceName, duration, milliseconds } from "/page/words.js";

const SIGNS = { good: "✓", warn: "!", bad: "✕", unknown: "·" };
const DEVICE_STATES = {
  answering: "good", "not answering": "warn", offline: "bad", "damaged answers": "warn", "not asked": "unknown",
  "line not open": "bad",
};

function makeFinding() {
  const title = element("h3");
  const [evidence, place] = [element("p"), element("p", { class: "hint" })];
  const node = element("li", { class: "card finding" }, title, evidence, place);
  const update = (it) => {
    setText(title, `✕ ${it.subject}: ${it.finding}`);
    setText(evidence, it.evidence);
    setText(place, `Look at: ${it.look_at}`);
  };
  return { node, update };
}

function card() {
  const [title, state, why] = [element("h3"), element("p"), element("p", { class: "why" })];
  const plot = element("canvas", { role: "img" });
  const node = element("article", { class: "card" }, title, state, why);
  const head = (name, mark, word, reason) => {
    setText(title, name);
    setClass(state, `state ${mark}`);
    setText(state, `${SIGNS[mark]} ${word}`);
    setText(why, reason);
  };
  return { node, head, plot };
}

function makeBus(history) {
  const { node, head, plot } = card();
  const facts = terms("facts", ["Line", "Load", "Waiting", "Quality"]);
  const counts = terms("counts", ["Sent", "Answered", "No response", "Bad CRC", "Late answers", "Retries", "Other bytes"]);
  node.append(facts.node, counts.node, plot);
  const update = ({ bus, diagnoses, devices }) => {
    const counted = bus.counters;
    const silent = devices.filter(({ state }) => state === "offline" || state === "not answering").length;
    const mark = bus.open ? (diagnoses.length + silent > 0 ? "warn" : "good") : "bad";
    head(bus.name, mark, bus.open ? `open, ${bus.state}` : "not open", whyOfBus(bus, diagnoses, silent, devices.length));
    const pace = bus.baud ? `, ${bus.baud} baud ${bus.format}` : "";
    const { verdict, count: bad, of } = bus.quality;
    facts.update([
      `${bus.line}, ${bus.discipline.toUpperCase()}${pace}`, `${bus.load_percent} %`, count(bus.waiting, "request"),
      of > 0 ? `${verdict} (${bad} of ${of})` : verdict,
    ]);
    counts.update([
      counted.transmissions, counted.responses, counted.timeouts, counted.bad_crcs, counted.late_responses, counted.retries,
      counted.noise_bytes + counted.stray_bytes,
    ].map(String));
    plotLoad(plot, bus.name, history.of(history.loads, bus.name), here());
  };
  return { node, update };
}

const percentiles = ({ p50, p90, p99 }) => (p50 === null ? "–" : [p50, p90, p99].map(milliseconds).join(", "));

function makeDevice(history) {
  const { node, head, plot } = card();
  const slow = element("p", { class: "warn slow" });
  slow.hidden = true;
  const facts = terms("facts", ["Bus, address", "Device takes (50, 90, 99 %)", "On the wire", "Waits for the line", "Response timeout",
    "Last answer", "Quarantine"]);
  const counts = terms("counts", ["Sent", "Answered", "No response", "Bad CRC", "Late answers", "Exceptions"]);
  node.append(slow, facts.node, counts.node, plot);
  const update = ({ device, diagnoses, pace }) => {
    const [counted, times] = [device.counters, device.latency_ms];
    const since = device.state_since_s === null ? "" : ` for ${duration(device.state_since_s)}`;
    head(deviceName(device), DEVICE_STATES[device.state] ?? "unknown", device.state + since, whyOfDevice(device, diagnoses));
    slow.hidden = pace === "";
    setText(slow, pace && `! slow: ${pace}`);
    const codes = Object.entries(device.exceptions).map(([code, seen]) => `${seen} × ${code}`).join(", ");
    const held = device.held_back_ms > 0 ? `held back for ${milliseconds(device.held_back_ms)} more`
      : `no; ${milliseconds(device.quarantine_ms)} after a missing response`;
    facts.update([
      `${device.bus}, ${device.address}`, percentiles(times.device), percentiles(times.wire), percentiles(times.queue),
      milliseconds(device.response_timeout_ms),
      device.last_answer_ms_ago === null ? "never" : `${duration(device.last_answer_ms_ago / 1000)} ago`, held,
    ]);
    counts.update([
      counted.transmissions, counted.responses, counted.timeouts, counted.bad_crcs, counted.late_responses,
      counted.exceptions === 0 ? 0 : `${counted.exceptions}${codes && ` (${codes})`}`,
    ].map(String));
    plotLatency(plot, deviceName(device), history.of(history.points, pointsKey(device)), history.now());
  };
  return { node, update };
}

export class Overview {
  constructor(history) {
    this.findings = new Keyed(byId("finding-list"), (it) => `${it.subject} ${it.finding} ${it.look_at}`, makeFinding);
    this.buses = new Keyed(byId("bus-list"), (it) => it.bus.name, () => makeBus(history));
    this.devices = new Keyed(byId("device-list"), (it) => pointsKey(it.device), () => makeDevice(history));
    this.clients = tableRows(byId("client-rows"), (it) => `${it.listener} ${it.address}`, [
      ["Address", (it) => it.address],
      ["Listener", (it) => it.listener],
      ["Requests", (it) => String(it.requests)],
      ["Not answered yet", (it) => String(it.outstanding)],
      ["Refused", (it) => String(it.refused)],
    ]);
  }

  show(status) {
    const of = (subject) => status.diagnoses.filter((it) => it.subject === subject);
    this.findings.show(status.diagnoses);
    setText(byId("no-findings"), status.diagnoses.length > 0 ? "The worst first." : "✓ No faults found.");
    this.buses.show(status.buses.map((bus) => (
      { bus, diagnoses: of(`bus ${bus.name}`), devices: status.devices.filter((device) => device.bus === bus.name) })));
    this.devices.show(status.devices.map((device) => (
      { device, diagnoses: of(`device ${device.name}`), pace: slowness(device, status.devices) })));
    this.clients.show(status.clients);
    byId("no-clients").hidden = status.clients.length > 0;
  }
}
