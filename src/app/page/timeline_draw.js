// SPDX-License-Identifier: Apache-2.0
// Draws a stretch of a line to scale: what was sent, what was heard, the silence before each request, timeouts, quarantine.

import { colour } from "/page/theme.js";
import { isFailure, pieces, response } from "/page/wire.js";
import { between, milliseconds, timeOfDay } from "/page/words.js";

const ROWS = { request: [34, 28], response: [82, 28], silence: [130, 12], quarantine: [182, 18] };  // top and height
const READABLE = 17;  // pixels of a character in which two digits can be read
const LEAST_LABEL = 4;  // letters
const VISIBLE = 3;  // pixels of a character from which on they are told apart

/** `view`: { from, to } in microseconds. `chosen` is one of `wires`, or null. */
export class Picture {
  constructor({ pen, width, height }, view, character) {
    Object.assign(this, { pen, width, height, view, character });
  }

  x(at) {
    return ((at - this.view.from) / (this.view.to - this.view.from)) * this.width;
  }

  draw(wires, chosen, gap) {
    this.grid();
    this.title("request", "request");
    this.title("response", "response");
    this.title("silence", "silence before");
    this.title("quarantine", "quarantine");
    for (const wire of wires) {
      this.wire(wire, gap);
    }
    for (const [at, wire] of wires.entries()) {
      this.quarantine(wire, endOfQuarantine(wire, wires, at));
    }
    if (chosen) {
      this.frameAround(chosen);
    }
  }

  grid() {
    const { pen, view, width, height } = this;
    const step = roundStep((view.to - view.from) / Math.max(2, width / 110));
    pen.strokeStyle = colour("edge");
    pen.fillStyle = colour("faint");
    pen.textAlign = "left";
    pen.globalAlpha = 1;
    for (let at = Math.ceil(view.from / step) * step; at < view.to; at += step) {
      const x = Math.round(this.x(at)) + 0.5;
      pen.globalAlpha = 0.35;
      pen.beginPath();
      pen.moveTo(x, 16);
      pen.lineTo(x, height);
      pen.stroke();
      pen.globalAlpha = 1;
      pen.fillText(timeOfDay(Math.round(at), step >= 1000000 ? 0 : step >= 1000 ? 3 : 6).replace(/\.$/, ""), x + 3, 8);
    }
  }

  title(row, text) {
    this.pen.fillStyle = colour("faint");
    this.pen.textAlign = "left";
    this.pen.fillText(text, 4, ROWS[row][0] - 8);
  }

  wire(wire, gap) {
    if (wire.sentAt !== null) {
      this.silence(wire, gap);
      this.frame("request", wire.sentAt, wire.leftAt, wire.bytes, colour("request"), wire.text);
      this.waiting(wire);
    }
    const mark = colour(isFailure(wire) ? "bad" : "response");
    const all = pieces(wire, this.character);
    all.forEach((piece, at) => this.frame("response", piece.from, piece.to, piece.bytes, mark, at === 0 ? this.said(wire) : ""));
  }

  said(wire) {
    return isFailure(wire) ? `✕ ${wire.outcome}: ${wire.heardText}` : wire.heardText;
  }

  /** Bytes that take this time: a bar, its characters where they are wide enough, and what they say where there is room. */
  frame(row, from, to, bytes, mark, text) {
    const { pen, width } = this;
    const [left, right] = [this.x(from), Math.max(this.x(to), this.x(from) + 1.5)];
    if (right < 0 || left > width) {
      return;
    }
    const [top, high] = ROWS[row];
    pen.fillStyle = mark;
    pen.fillRect(left, top, right - left, high);
    const each = (right - left) / bytes.length;
    if (each >= VISIBLE) {
      this.characters(left, each, bytes, top, high);
    }
    if (each < READABLE && right - left > 60 && text) {
      this.label(text, left + 4, right - 4, top + high / 2, colour("on-mark"));
    }
  }

  characters(left, each, bytes, top, high) {
    const { pen, width } = this;
    pen.textAlign = "center";
    bytes.forEach((byte, at) => {
      const x = left + at * each;
      if (x + each >= 0 && x <= width) {
        pen.fillStyle = colour("panel");
        pen.fillRect(x, top, 1, high);
        if (each >= READABLE) {
          pen.fillStyle = colour("on-mark");
          pen.fillText(byte, x + each / 2, top + high / 2);
        }
      }
    });
    pen.textAlign = "left";
  }

  /** As much of the text as fits, where it can be seen. */
  label(text, left, right, y, ink) {
    const { pen, width } = this;
    const [from, to] = [Math.max(2, left), Math.min(width - 2, right)];
    let length = text.length;
    let shown = text;
    while (length > LEAST_LABEL && pen.measureText(shown).width > to - from) {
      length = Math.floor(length * 0.85);
      shown = `${text.slice(0, length)}…`;
    }
    if (pen.measureText(shown).width <= to - from) {
      pen.fillStyle = ink;
      pen.textAlign = "left";
      pen.fillText(shown, from, y);
    }
  }

  dashed(from, to, y, mark) {
    const { pen } = this;
    pen.strokeStyle = mark;
    pen.setLineDash([3, 3]);
    pen.beginPath();
    pen.moveTo(Math.max(-5, this.x(from)), y);
    pen.lineTo(Math.min(this.width + 5, this.x(to)), y);
    pen.stroke();
    pen.setLineDash([]);
  }

  /** The device thinks, or does not answer. */
  waiting(wire) {
    const { from } = response(wire, this.character);
    const [top, high] = ROWS.response;
    const until = from ?? wire.endedAt;
    const isLost = from === null && isFailure(wire);
    if (wire.outcome === "sent" || until <= wire.leftAt || this.x(until) < 0 || this.x(wire.leftAt) > this.width) {
      return;
    }
    const mark = colour(isLost ? "bad" : "faint");
    this.dashed(wire.leftAt, until, top + high / 2, mark);
    const text = isLost ? `✕ ${wire.outcome} in ${between(wire.leftAt, until)}` : `takes ${between(wire.leftAt, until)}`;
    this.label(text, this.x(wire.leftAt) + 4, this.x(until) - 4, top + high / 2 - 9, mark);
    if (isLost) {
      this.pen.fillStyle = mark;
      this.pen.fillRect(this.x(until) - 1, top, 3, high);
    }
  }

  silence(wire, gap) {
    const [left, right] = [this.x(wire.silentSince ?? wire.sentAt), this.x(wire.sentAt)];
    if (wire.silentSince === null || right < 0 || left > this.width || right - left < 2) {
      return;
    }
    const [top, high] = ROWS.silence;
    const enough = wire.silence >= gap;
    const { pen } = this;
    pen.strokeStyle = colour(enough ? "faint" : "bad");
    pen.beginPath();
    pen.moveTo(left, top);
    pen.lineTo(left, top + high);
    pen.moveTo(Math.max(-5, left), top + high / 2);
    pen.lineTo(Math.min(this.width + 5, right), top + high / 2);
    pen.moveTo(right, top);
    pen.lineTo(right, top + high);
    pen.stroke();
    const text = `${milliseconds(wire.silence)} ${enough ? "≥" : "<"} ${milliseconds(gap)}`;
    const room = Math.min(this.width, right) - Math.max(0, left);
    const fits = pen.measureText(text).width + 6 < room;
    const shown = fits ? text : milliseconds(wire.silence);
    this.label(shown, left + 2, right - 2, top + high + 9, colour(enough ? "text" : "bad"));
  }

  quarantine(wire, until) {
    if (until === null || this.x(until) < 0 || this.x(wire.endedAt) > this.width) {
      return;
    }
    const { pen, width } = this;
    const [top, high] = ROWS.quarantine;
    const [left, right] = [Math.max(-5, this.x(wire.endedAt)), Math.min(width + 5, this.x(until))];
    pen.strokeStyle = colour("warn");
    pen.strokeRect(left, top, right - left, high);
    pen.globalAlpha = 0.35;
    pen.beginPath();
    for (let x = left; x < right; x += 7) {
      pen.moveTo(x, top + high);
      pen.lineTo(Math.min(right, x + 7), top);
    }
    pen.stroke();
    pen.globalAlpha = 1;
    const text = `${wire.device ?? wire.address}: ${between(wire.endedAt, until)}`;
    this.label(text, left + 4, right - 4, top + high / 2, colour("text"));
  }

  frameAround(wire) {
    const { pen } = this;
    const to = Math.max(wire.endedAt, wire.leftAt ?? 0);
    const left = this.x(wire.at) - 3;
    pen.strokeStyle = colour("link");
    pen.lineWidth = 2;
    const [top, [low, high]] = [ROWS.request[0] - 4, ROWS.response];
    pen.strokeRect(left, top, this.x(to) - left + 3, low + high + 4 - top);
    pen.lineWidth = 1;
  }
}

/** It ends before its time where the device gets something else, or answers. */
export function endOfQuarantine(wire, wires, at) {
  if (wire.heldUntil === null) {
    return null;
  }
  const frame = wire.bytes.join(" ");
  const next = wires.slice(at + 1).find((it) => it.address === wire.address && it.sentAt !== null
    && (it.bytes.join(" ") !== frame || it.outcome === "answered" || it.heldUntil !== null));
  return next ? Math.min(wire.heldUntil, next.bytes.join(" ") === frame ? next.endedAt : next.sentAt) : wire.heldUntil;
}

function roundStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((digit) => digit * power).find((step) => step >= least);
}
