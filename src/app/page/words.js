// SPDX-License-Identifier: Apache-2.0
// Numbers as people read them. Instants are microseconds since 1970, as numbers: they are exact until the year 2255.

/** "2026-11-25T00:00:01.000250Z" in microseconds; null stays null. */
export function instant(text) {
  if (text === null || text === undefined) {
    return null;
  }
  const whole = 19;  // up to the seconds
  const fraction = text.slice(whole + 1, -1).padEnd(6, "0");
  return Date.parse(`${text.slice(0, whole)}Z`) * 1000 + Number(fraction);
}

/** "2.10 ms": three figures, or as many as there are before the point. */
export function milliseconds(value) {
  if (value === null || value === undefined) {
    return "–";
  }
  const digits = Math.abs(value) >= 100 ? 0 : Math.abs(value) >= 10 ? 1 : 2;
  return `${value.toFixed(digits)} ms`;
}

/** Of two instants; "–" if one of them is not there. */
export function between(from, to) {
  return from === null || to === null ? "–" : milliseconds((to - from) / 1000);
}

/** "850 ms", "4.5 s", "3 min 5 s", "2 h 5 min", "3 d 4 h" */
export function duration(seconds) {
  if (seconds < 1) {
    return `${Math.round(seconds * 1000)} ms`;
  }
  if (seconds < 60) {
    return `${seconds < 10 ? seconds.toFixed(1) : Math.floor(seconds)} s`;
  }
  const units = [["d", 86400], ["h", 3600], ["min", 60], ["s", 1]];
  const at = units.findIndex(([, size]) => seconds >= size);
  const [[large, size], [small, part]] = [units[at], units[at + 1]];
  return `${Math.floor(seconds / size)} ${large} ${Math.floor((seconds % size) / part)} ${small}`;
}

const two = (number) => String(number).padStart(2, "0");

/** The time of day here, "14:03:07.123456" with six digits. */
export function timeOfDay(micros, digits = 3) {
  const date = new Date(Math.floor(micros / 1000));
  const fraction = String(micros % 1000000).padStart(6, "0").slice(0, digits);
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}.${fraction}`;
}

/** The day too, where it is another one. */
export function dayAndTime(micros) {
  const date = new Date(micros / 1000);
  const isToday = date.toDateString() === new Date().toDateString();
  const day = `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())} `;
  return (isToday ? "" : day) + timeOfDay(micros);
}

export function count(number, one, many = `${one}s`) {
  return `${number} ${number === 1 ? one : many}`;
}

/** "axis-x", or the address where the configuration has no device. */
export function deviceName(device) {
  return device.name ?? `address ${device.address} of ${device.bus}`;
}
