// SPDX-License-Identifier: Apache-2.0
// What was on a line, as a trace tells it: a frame, the silence before it and what came back, in instants and characters.

import { instant } from "/page/words.js";

/** "01 03" as ["01", "03"]. */
export const bytesOf = (hex) => (hex === "" ? [] : hex.split(" "));

/** One of a record's `wire`. Instants are numbers, and null where there is none. */
export function wireOf(json) {
  const heard = json.heard.map((piece) => ({ at: instant(piece.at), bytes: bytesOf(piece.bytes) }));
  const sentAt = json.sent ? instant(json.sent.at) : null;
  const wire = {
    bus: json.bus,
    device: json.device,
    address: json.address,
    framing: json.framing,
    outcome: json.outcome,
    tries: json.try ?? 0,
    text: json.sent ? json.sent.text : "no request",
    heardText: json.heard_text,
    bytes: json.sent ? bytesOf(json.sent.bytes) : [],
    sentAt,
    leftAt: json.sent ? instant(json.left_at) ?? sentAt : null,
    silence: json.silence_ms ?? null,  // milliseconds, before it
    silentSince: (json.silence_ms ?? null) === null ? null : sentAt - Math.round(json.silence_ms * 1000),
    heldUntil: instant(json.held_until),
    endedAt: instant(json.ended_at),
    heard: sentAt === null ? heard : withoutEcho(heard, bytesOf(json.sent.bytes), json.heard_text),
  };
  wire.at = sentAt ?? heard[0]?.at ?? wire.endedAt;
  wire.key = `${wire.bus} ${wire.address} ${wire.at}`;
  return wire;
}

/** A line with an echo hears first what was sent. */
function withoutEcho(heard, sent, text) {
  if (!text.startsWith("the same bytes as sent")) {
    return heard;
  }
  let left = sent.length;
  return heard.map(({ at, bytes }) => {
    const rest = bytes.slice(left);
    left = Math.max(0, left - bytes.length);
    return { at, bytes: rest };
  }).filter(({ bytes }) => bytes.length > 0);
}

/** Pieces of what was heard with the instants at which their characters began and ended: the last one of a piece had ended when
 *  it was read. `character` in microseconds; 0: on a connection. */
export function pieces(wire, character) {
  let free = wire.leftAt ?? 0;
  return wire.heard.map(({ at, bytes }) => {
    const from = Math.max(free, at - bytes.length * character);
    free = at;
    return { from: Math.min(from, at), to: at, bytes };
  });
}

/** When the first character of the response began, and when its last one had ended; nulls if nothing came. */
export function response(wire, character) {
  const all = pieces(wire, character);
  return all.length === 0 ? { from: null, to: null } : { from: all[0].from, to: all[all.length - 1].to };
}

export const isFailure = (wire) => wire.outcome !== "answered" && wire.outcome !== "sent";

/** A word, and a sign that is no colour. */
export function outcomeText(wire) {
  const tried = wire.tries > 1 ? ` (try ${wire.tries})` : "";
  return `${isFailure(wire) ? "✕ " : "✓ "}${wire.outcome}${tried}`;
}
