// SPDX-License-Identifier: Apache-2.0
// What was read since the page is open, as far back as it is shown: the load of each bus, the frames on each line, how long
// each device thought.

import { isFailure, response } from "/page/wire.js";

export const PLOTTED = 120e6;  // microseconds: two minutes
export const DRAWN = 60e6;  // of the lines
const MOST_WIRES = 6000;  // of a line
export const MOST_POINTS = 3000;  // of a device: less than two minutes of one that answers more than 25 times a second
const RECENT = 10e6;  // records of the last this, or twice this, say how far the clocks are apart
const SET_BACK = 1e6;  // so much less is no drift

/** Microseconds since the page was opened, by the clock of the browser. */
export const here = () => performance.now() * 1000;

export class History {
  constructor() {
    this.loads = new Map();  // bus: [{ at, value }], `at` by here(), value null where nothing was asked
    this.wires = new Map();  // bus: wires by their instant
    this.points = new Map();  // bus and address: [{ at, value }], value null: no good answer
    this.buses = new Map();  // by name, of the last status
    this.ahead = -Infinity;  // of mbgated's clock, before here()
    this.forgetClock();
  }

  /** The most of what was seen of `ahead`, since an instant by here() and in the time before. */
  forgetClock() {
    this.lately = { since: -Infinity, most: -Infinity };
    this.before = -Infinity;
  }

  /** The page was hidden, or begins: meanwhile clocks may have been set. */
  gap() {
    this.forgetClock();
    for (const load of this.loads.values()) {
      load.push({ at: here(), value: null });
    }
  }

  status(json) {
    this.buses = new Map(json.buses.map((bus) => [bus.name, bus]));
    for (const bus of json.buses) {
      const load = listOf(this.loads, bus.name);
      load.push({ at: here(), value: bus.load_percent });
      dropBefore(load, here() - PLOTTED);
    }
  }

  /** The instant at mbgated, as far as it is known: what it has sent took a moment to come here. */
  now() {
    return Math.round(here() + (this.ahead === -Infinity ? performance.timeOrigin * 1000 : this.ahead));
  }

  /** Microseconds that a character takes on this bus; 0: on a connection. */
  character(bus) {
    return (this.buses.get(bus)?.character_ms ?? 0) * 1000;
  }

  /** False: it is known already, from another request that shared it. */
  add(wire) {
    this.noteClock(wire.endedAt - here());
    const wires = listOf(this.wires, wire.bus);
    let place = wires.length;
    while (place > 0 && wires[place - 1].at > wire.at) {
      place -= 1;
    }
    if (place > 0 && wires[place - 1].key === wire.key) {
      return false;
    }
    wires.splice(place, 0, wire);
    dropBefore(wires, wire.at - DRAWN, MOST_WIRES);
    this.addPoint(wire);
    return true;
  }

  /** A record comes late, never early. But clocks drift, and mbgated's may be set: the most of the last seconds counts. */
  noteClock(seen) {
    const age = here() - this.lately.since;
    if (age >= RECENT) {
      this.before = age < 2 * RECENT ? this.lately.most : -Infinity;
      this.lately = { since: here(), most: -Infinity };
    }
    this.lately.most = Math.max(this.lately.most, seen);
    const ahead = Math.max(this.lately.most, this.before);
    if (this.ahead - ahead > SET_BACK) {
      // What is kept lies in the future, or where other frames will come.
      this.wires.clear();
      this.points.clear();
    }
    this.ahead = ahead;
  }

  addPoint(wire) {
    if (wire.sentAt === null || wire.outcome === "sent" || wire.outcome === "cut") {
      return;
    }
    const points = listOf(this.points, pointsKey(wire));
    const { from } = response(wire, this.character(wire.bus));
    const value = isFailure(wire) || from === null ? null : (from - wire.leftAt) / 1000;
    points.push({ at: wire.sentAt, value });
    dropBefore(points, wire.sentAt - PLOTTED, MOST_POINTS);
  }

  of(wires, bus) {
    return wires.get(bus) ?? [];
  }
}

export const pointsKey = (device) => `${device.bus} ${device.address}`;

function listOf(map, key) {
  if (!map.has(key)) {
    map.set(key, []);
  }
  return map.get(key);
}

function dropBefore(list, instant, most = Infinity) {
  let drop = Math.max(0, list.length - most);
  while (drop < list.length && list[drop].at < instant) {
    drop += 1;
  }
  if (drop > 0) {
    list.splice(0, drop);
  }
}
