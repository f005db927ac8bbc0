// SPDX-License-Identifier: Apache-2.0
// The status page: what is read goes to those who show it. It only reads (docs/api.yaml).

import { Decoded } from "/page/decode.js";
import { byId, setClass, setText } from "/page/dom.js";
import { Events } from "/page/events.js";
import { Feed } from "/page/feed.js";
import { History } from "/page/history.js";
import { Overview } from "/page/overview.js";
import { onTheme } from "/page/theme.js";
import { Timeline } from "/page/timeline.js";
import { Trace } from "/page/trace.js";
import { wireOf } from "/page/wire.js";
import { count, duration } from "/page/words.js";

const history = new History();
const decoded = new Decoded();
const overview = new Overview(history);
const timeline = new Timeline(history, decoded);
const trace = new Trace(history, decoded);
const events = new Events();
let last = null;  // status
let silence = "";  // why there is none
let hasStream = true;

function contact() {
  const stream = hasStream ? ""
    : "✕ The live trace is interrupted: mbgated sends no stream, or [http] max_streams is reached. The page tries again.";
  const text = silence ? `✕ ${silence}. The figures below are old.` : stream;
  setText(byId("contact"), text || "✓ Live.");
  setClass(byId("contact"), text ? "bad" : "good");
}

function show(status) {
  last = status;
  const old = status.configuration.reload_refused ? "; the last reload was refused, so the settings are older than the file" : "";
  const { version, uptime_s: uptime, configuration } = status;
  setText(byId("about"), [
    `mbgated ${version}, up ${duration(uptime)}, ${configuration.file} as of ${configuration.read_at}${old}. `,
    `${count(status.requests, "request")}, ${count(status.foreign_adus, "foreign ADU")}, `,
    `framing lost ${count(status.framing_lost, "time")}.`,
  ].join(""));
  overview.show(status);
  trace.status(status);
  timeline.status();
}

onTheme(() => last && overview.show(last));
new Feed({
  status(json) {
    silence = "";
    contact();
    history.status(json);
    show(json);
  },
  silent(why) {
    silence = why;
    contact();
  },
  record(kind, json) {
    json.wire.forEach((wire) => history.add(wireOf(wire)));
    trace.add(json);
  },
  line: (id, json) => events.add(id, json),
  lost: (number) => trace.addLost(number),
  gap: () => history.gap(),
  stream(isOpen) {
    hasStream = isOpen;
    contact();
  },
});
