// SPDX-License-Identifier: Apache-2.0
// A transaction in full: each frame with its instants, what it means, and its bytes by field.

import { byId, element } from "/page/dom.js";
import { bytesOf, outcomeText, response, wireOf } from "/page/wire.js";
import { between, instant, milliseconds, timeOfDay } from "/page/words.js";

/** Fields of a frame: [name, bytes]. What is too short has fewer. */
export function fieldsOf(bytes, framing) {
  const take = (names) => {
    const found = [];
    let at = 0;
    for (const [name, size] of names) {
      const end = size < 0 ? Math.max(at, bytes.length + size + 1) : at + size;
      if (at < bytes.length && end > at) {
        found.push([name, bytes.slice(at, end)]);
      }
      at = end;
    }
    return found;
  };
  if (framing === "tcp") {
    return take([["transaction", 2], ["protocol", 2], ["length", 2], ["unit", 1], ["function", 1], ["data", -1]]);
  }
  if (framing === "ascii") {
    return take([["start", 1], ["address", 2], ["function", 2], ["data", -5], ["LRC", 2], ["end", 2]]);
  }
  return take([["address", 1], ["function", 1], ["data", -3], ["CRC", 2]]);
}

function fieldList(bytes, framing) {
  const items = fieldsOf(bytes, framing).map(([name, field]) => (
    element("li", {}, element("span", {}, name), element("code", {}, field.join(" ")))));
  return element("ul", { class: "fields" }, ...items);
}

function part(title, text, bytes, framing) {
  return [element("h4", {}, title), element("p", {}, text), ...(bytes.length > 0 ? [fieldList(bytes, framing)] : [])];
}

function wireParts(wire, character) {
  const where = `${wire.bus}, ${wire.device ?? `address ${wire.address}`}`;
  const parts = [];
  if (wire.sentAt !== null) {
    const silence = wire.silence === null ? "" : `, after ${milliseconds(wire.silence)} of silence`;
    const took = wire.leftAt > wire.sentAt ? `, takes ${between(wire.sentAt, wire.leftAt)}` : "";
    const title = `On the line: request to ${where} at ${timeOfDay(wire.sentAt, 6)}${silence}${took}`;
    parts.push(...part(title, wire.text, wire.bytes, wire.framing));
  }
  const heard = wire.heard.flatMap(({ bytes }) => bytes);
  const { from, to } = response(wire, character);
  const thought = wire.sentAt === null || from === null ? "" : `, after ${between(wire.leftAt, from)}`;
  const when = heard.length === 0 ? "nothing heard"
    : `heard from ${timeOfDay(Math.round(from), 6)} to ${timeOfDay(to, 6)}${thought}`;
  parts.push(...part(`On the line: ${when}`, wire.heardText, heard, wire.framing));
  const held = wire.heldUntil === null ? "" : `. Quarantine until ${timeOfDay(wire.heldUntil, 6)} at most.`;
  parts.push(element("p", {}, `${outcomeText(wire)} at ${timeOfDay(wire.endedAt, 6)}${held}`));
  return parts;
}

export class Decoded {
  constructor() {
    this.panel = byId("decoded");
    byId("decoded-close").addEventListener("click", () => {
      this.panel.hidden = true;
      this.opener?.focus();
    });
  }

  wire(wire, character) {
    this.open(`${wire.text}, ${wire.bus}`, wireParts(wire, character), false);
  }

  /** `json`: a record of the trace. `character(bus)`: microseconds. */
  record(json, character) {
    const wires = json.wire.map(wireOf).flatMap((wire) => wireParts(wire, character(wire.bus)));
    const parts = [];
    if (json.client) {
      const { client, request, answer } = json;
      const [asked, answered] = [instant(request.at), answer ? instant(answer.at) : null];
      const from = `${client.address} at ${timeOfDay(asked, 6)}, listener ${client.listener}, connection ${client.connection}`;
      parts.push(...part(`Request of ${from}`, request.text, bytesOf(request.bytes), "tcp"));
      parts.push(...wires);
      if (json.refused) {
        parts.push(element("p", {}, "The gateway has answered it without asking a device."));
      }
      const end = answer ? `Answer to the client at ${timeOfDay(answered, 6)}, ${between(asked, answered)} after its request`
        : "No answer to the client";
      parts.push(...part(end, answer ? answer.text : (json.ended ?? ""), answer ? bytesOf(answer.bytes) : [], "tcp"));
      if (json.ended) {
        parts.push(element("p", { class: "hint" }, `On its bus: ${json.ended}.`));
      }
    } else {
      parts.push(...wires);
    }
    this.open(json.client ? json.request.text : json.wire[0].bus, parts, true);
  }

  open(title, parts, takesFocus) {
    this.opener = document.activeElement;
    byId("decoded-title").textContent = title;
    byId("decoded-body").replaceChildren(...parts);
    this.panel.hidden = false;
    if (takesFocus) {
      byId("decoded-title").focus();
    }
  }
}
