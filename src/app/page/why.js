// SPDX-License-Identifier: Apache-2.0
// Why a bus or a device is in its state, in a sentence, from what the status says of it. What is wrong is said by mbgated's
// findings; this only words the figures beside them.

import { count, duration, milliseconds } from "/page/words.js";

const sentence = (text) => text[0].toUpperCase() + text.slice(1);
const found = (diagnoses) => diagnoses.map((it) => sentence(`${it.finding}: ${it.evidence}`)).join("; ");

/** `silent`: how many of its `devices` do not answer. */
export function whyOfBus(bus, diagnoses, silent, devices) {
  const answers = silent > 0 ? ` ${silent} of ${count(devices, "device")} ${silent === 1 ? "does" : "do"} not answer.` : "";
  if (diagnoses.length > 0) {
    return `${found(diagnoses)}.${answers}`;
  }
  if (!bus.open) {
    return "The line could not be opened, or was lost; mbgated tries again.";
  }
  const { verdict } = bus.quality;
  return (verdict === "unknown" ? "Too few answers for a verdict." : `The quality of the answers is ${verdict}.`) + answers;
}

export function whyOfDevice(device, diagnoses) {
  const unanswered = `${count(device.unanswered_in_row, "request")} in a row without an answer`;
  const probe = device.next_probe_in_ms === null ? "" : `; next probe in ${duration(device.next_probe_in_ms / 1000)}`;
  const why = {
    "not asked": "No client has asked it yet.",
    answering: device.quality.verdict === "unknown" ? "It has answered." : `Its answers are ${device.quality.verdict}.`,
    "not answering": `${unanswered}.`,
    offline: `${unanswered}${probe}.`,
    "damaged answers": "Its last answers were damaged.",
    "line not open": "Its line is not open.",
  }[device.state] ?? "";
  return diagnoses.length > 0 ? `${why} ${found(diagnoses)}.` : why;
}

/** A device that holds up its line: what it does, or nothing. */
export function slowness(device, all) {
  const own = device.latency_ms.device;
  if (own.p50 === null) {
    return "";
  }
  const halfOfTimeout = 0.5;
  if (own.p90 >= halfOfTimeout * device.response_timeout_ms) {
    const limit = milliseconds(device.response_timeout_ms);
    return `one answer in ten takes ${milliseconds(own.p90)} or longer, and the response timeout is ${limit}`;
  }
  const [times, least] = [5, 10];
  const others = all.filter((it) => it !== device && it.latency_ms.device.p50 !== null)
    .map((it) => it.latency_ms.device.p50).sort((one, other) => one - other);
  const usual = others[Math.floor((others.length - 1) / 2)];
  const isSlow = others.length > 0 && own.p50 >= least && own.p50 >= times * usual;
  const [half, around] = [own.p50, usual ?? 0].map(milliseconds);
  return isSlow ? `half of its answers take ${half} or longer, those of other devices ${around}` : "";
}
