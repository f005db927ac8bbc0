// SPDX-License-Identifier: Apache-2.0
// The bus timeline: which stretch of which line is shown, how it is moved and zoomed, and the same in a table.

import { byId, element, setOptions, setText, tableRows } from "/page/dom.js";
import { DRAWN } from "/page/history.js";
import { cleared, onTheme, wantsStill } from "/page/theme.js";
import { Picture } from "/page/timeline_draw.js";
import { isFailure, outcomeText, response } from "/page/wire.js";
import { between, duration, milliseconds, timeOfDay } from "/page/words.js";

const LAG = 150000;  // microseconds: what is newer may not have come yet
const SHORTEST = 20;  // microseconds that the picture may have; at least two characters
const MOST_ROWS = 30;
const STEP = 1.5;  // of a zoom
const EXTRA = 5e6;  // microseconds: a request may have begun before what it still shows

const quarantineText = (wire) => (wire.heldUntil === null ? "" : `; quarantine ${between(wire.endedAt, wire.heldUntil)} at most`);
const endOf = (wire) => Math.max(wire.endedAt, wire.leftAt ?? 0);

export class Timeline {
  constructor(history, decoded) {
    this.history = history;
    this.decoded = decoded;
    this.canvas = byId("timeline-canvas");
    this.bus = byId("timeline-bus");
    this.span = 2e6;
    this.end = 0;
    this.isFollowing = true;
    this.chosen = null;
    this.needed = 0;  // milliseconds of silence
    this.rows = tableRows(byId("timeline-rows"), (it) => it.key, this.columns());
    this.listen();
    onTheme(() => this.draw());
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    this.animate(0);
  }

  columns() {
    const of = (wire) => response(wire, this.history.character(wire.bus));
    return [
      ["Sent at", (it) => () => this.chooser(it)],
      ["Device", (it) => it.device ?? (it.sentAt === null ? "–" : `address ${it.address}`)],
      ["Request", (it) => it.text],
      ["Silence before (needed)", (it) => this.silence(it)],
      ["Request takes", (it) => (it.leftAt > it.sentAt ? between(it.sentAt, it.leftAt) : "–")],
      ["Device takes", (it) => (it.sentAt === null ? "–" : between(it.leftAt, of(it).from))],
      ["Response takes", (it) => (this.history.character(it.bus) > 0 ? between(of(it).from, of(it).to) : "–")],
      ["Outcome", (it) => outcomeText(it) + quarantineText(it), (it) => (isFailure(it) ? "bad" : "")],
    ];
  }

  /** To the microsecond: it is held against what is needed. */
  silence(wire) {
    return wire.silence === null ? "–" : `${wire.silence.toFixed(3)} ms (${this.needed.toFixed(3)} ms)`;
  }

  chooser(wire) {
    const button = element("button", { type: "button", class: "link" }, timeOfDay(wire.at, 6));
    button.addEventListener("click", () => this.choose(wire));
    return button;
  }

  listen() {
    this.bus.addEventListener("change", () => this.show());
    byId("timeline-pause").addEventListener("click", () => this.follow(!this.isFollowing));
    const acts = {
      "timeline-earlier": () => this.move(-0.25), "timeline-later": () => this.move(0.25),
      "timeline-in": () => this.zoom(1 / STEP), "timeline-out": () => this.zoom(STEP),
      "timeline-previous": () => this.step(-1), "timeline-next": () => this.step(1),
    };
    for (const [id, act] of Object.entries(acts)) {
      byId(id).addEventListener("click", act);
    }
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    // Else it moves the page, which is longer than its window.
    this.canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== this.canvas && !event.ctrlKey) {
        return;
      }
      event.preventDefault();
      this.zoom(event.deltaY > 0 ? STEP : 1 / STEP, event.offsetX / this.canvas.clientWidth);
    }, { passive: false });
    this.listenToPointers();
  }

  listenToPointers() {
    const held = new Map();  // pointers that are down, and where
    let moved = 0;
    const spread = () => {
      const [one, other] = [...held.values()];
      return Math.max(1, Math.abs(one - other));
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      held.set(event.pointerId, event.offsetX);
      moved = 0;
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!held.has(event.pointerId)) {
        return;
      }
      const before = held.size === 2 ? spread() : 0;
      const by = event.offsetX - held.get(event.pointerId);
      held.set(event.pointerId, event.offsetX);
      moved += Math.abs(by);
      if (held.size === 2) {
        this.zoom(before / spread());
      } else if (moved > 3) {
        this.move(-by / this.canvas.clientWidth);
      }
    });
    const release = (event) => {
      if (held.delete(event.pointerId) && held.size === 0 && moved <= 3 && event.type === "pointerup") {
        this.chooseAt(this.end - this.span * (1 - event.offsetX / this.canvas.clientWidth));
      }
    };
    this.canvas.addEventListener("pointerup", release);
    this.canvas.addEventListener("pointercancel", release);
  }

  key(event) {
    const acts = {
      ArrowLeft: () => this.move(-0.1), ArrowRight: () => this.move(0.1),
      ArrowUp: () => this.step(-1), ArrowDown: () => this.step(1),
      PageUp: () => this.move(-1), PageDown: () => this.move(1), Home: () => this.follow(true),
      "+": () => this.zoom(1 / STEP), "=": () => this.zoom(1 / STEP), "-": () => this.zoom(STEP),
      " ": () => this.follow(!this.isFollowing),
    };
    if (acts[event.key] && !event.ctrlKey && !event.altKey && !event.metaKey) {
      event.preventDefault();
      acts[event.key]();
    }
  }

  /** Of the line that is shown, in their order. */
  wires() {
    return this.history.of(this.history.wires, this.bus.value);
  }

  follow(on) {
    this.isFollowing = on;
    const button = byId("timeline-pause");
    button.setAttribute("aria-pressed", String(!on));
    this.show();
  }

  move(share) {
    this.end += share * this.span;
    const now = this.history.now();
    this.end = Math.min(Math.max(this.end, now - DRAWN), now + this.span / 2);
    this.follow(false);
  }

  /** What stays in its place when it is zoomed, as a share of the picture: now, or what was chosen, or the middle. */
  still() {
    if (this.isFollowing) {
      return 1;
    }
    const at = this.chosen ? 1 - (this.end - this.chosen.at) / this.span : -1;
    return at >= 0 && at <= 1 ? at : 0.5;
  }

  /** `at`: what stays in its place, as a share of the picture. */
  zoom(factor, at = this.still()) {
    const least = Math.max(SHORTEST, 2 * this.history.character(this.bus.value));
    const span = Math.min(Math.max(this.span * factor, least), DRAWN / 2);
    this.end -= (this.span - span) * (1 - at);
    this.span = span;
    this.show();
  }

  choose(wire) {
    this.chosen = wire;
    const ends = endOf(wire);
    const silence = wire.silentSince === null ? 0 : Math.min(wire.at - wire.silentSince, 2000 * this.needed);
    const length = Math.max(ends - wire.at + silence, 1000);
    this.span = length * 1.3;
    this.end = ends + length * 0.15;
    this.follow(false);
    this.decoded.wire(wire, this.history.character(wire.bus));
  }

  chooseAt(at) {
    const slack = this.span / 100;
    const found = this.wires().filter((it) => it.at - slack <= at && at <= endOf(it) + slack).pop();
    if (found) {
      this.chosen = found;
      this.follow(false);
      this.decoded.wire(found, this.history.character(found.bus));
    }
  }

  step(by) {
    const all = this.wires();
    const start = this.chosen?.bus === this.bus.value ? all.indexOf(this.chosen) : -1;
    const at = start < 0 ? all.length - 1 : Math.min(Math.max(start + by, 0), all.length - 1);
    if (all[at]) {
      this.choose(all[at]);
    }
  }

  status() {
    setOptions(this.bus, [...this.history.buses.keys()]);
    this.needed = this.history.buses.get(this.bus.value)?.frame_gap_ms ?? 0;
    this.table();
  }

  show() {
    this.needed = this.history.buses.get(this.bus.value)?.frame_gap_ms ?? 0;
    this.draw();
    this.table();
  }

  inView() {
    const [from, to] = [this.end - this.span, this.end];
    return this.wires().filter((it) => endOf(it) >= from && (it.silentSince ?? it.at) <= to);
  }

  draw() {
    const drawn = cleared(this.canvas);
    if (!drawn) {
      return;
    }
    this.end = this.isFollowing ? this.history.now() - LAG : this.end;
    const view = { from: this.end - this.span, to: this.end };
    const amid = this.wires().filter((it) => (
      (it.heldUntil ?? it.endedAt) >= view.from - EXTRA && (it.silentSince ?? it.at) <= view.to));
    const character = this.history.character(this.bus.value);
    new Picture(drawn, view, character).draw(amid, amid.includes(this.chosen) ? this.chosen : null, this.needed);
    const span = this.span < 1e6 ? milliseconds(this.span / 1000) : duration(this.span / 1e6);
    const each = character > 0 ? `, a character takes ${milliseconds(character / 1000)}` : "";
    setText(byId("timeline-span"), `${span} shown${each}.`);
  }

  /** The same as the picture, in words. */
  table() {
    const all = this.inView();
    const shown = all.slice(-MOST_ROWS).reverse();
    this.rows.show(shown);
    shown.forEach((wire, at) => {
      const row = this.rows.parent.children[at];
      row.classList.toggle("chosen", wire === this.chosen);
      row.setAttribute("aria-current", String(wire === this.chosen));
    });
    const more = all.length > shown.length ? `, the last ${shown.length} of ${all.length}` : "";
    setText(byId("timeline-caption"), `Requests in the picture, the newest first${more}`);
  }

  /** While it follows, it moves: ten times a second, or once for those who want no motion. */
  animate(last) {
    requestAnimationFrame((now) => {
      const due = now - last >= (wantsStill() ? 1000 : 100);
      if (due && this.isFollowing) {
        this.draw();
      }
      this.animate(due ? now : last);
    });
  }
}
