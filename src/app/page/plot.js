// SPDX-License-Identifier: Apache-2.0
// The two small plots: the load of a bus as a line, what a device thought as dots. Each says in words what it shows.

import { duration, milliseconds } from "/page/words.js";
import { MOST_POINTS, PLOTTED } from "/page/history.js";
import { cleared, colour } from "/page/theme.js";

const LEFT = 52;  // pixels for the numbers
const EDGE = 12;  // above and below

/** `span` in microseconds, up to `now`. */
function frame(canvas, now, span, top, topText) {
  const drawn = cleared(canvas);
  if (!drawn) {
    return null;
  }
  const { pen, width, height } = drawn;
  const x = (at) => LEFT + (width - LEFT - 4) * (1 - (now - at) / span);
  const y = (value) => height - EDGE - 8 - (height - 2 * EDGE - 8) * Math.min(1, value / top);
  pen.strokeStyle = colour("edge");
  pen.beginPath();
  pen.moveTo(LEFT, y(top));
  pen.lineTo(LEFT, y(0));
  pen.lineTo(width - 4, y(0));
  pen.stroke();
  pen.fillStyle = colour("faint");
  pen.textAlign = "right";
  pen.fillText(topText, LEFT - 4, y(top));
  pen.fillText("0", LEFT - 4, y(0));
  pen.textAlign = "left";
  pen.fillText(`${span === PLOTTED ? "2 min" : duration(span / 1e6)} ago`, LEFT, height - 6);
  pen.textAlign = "right";
  pen.fillText("now", width - 4, height - 6);
  return { pen, x, y, width };
}

export function plotLoad(canvas, name, samples, now) {
  const values = samples.filter(({ value }) => value !== null).map(({ value }) => value);
  const text = values.length === 0 ? "nothing yet" : `now ${values[values.length - 1]} %, at most ${Math.max(...values)} %`;
  canvas.setAttribute("aria-label", `Load of ${name} in the last two minutes: ${text}`);
  const drawn = frame(canvas, now, PLOTTED, 100, "100 %");
  if (!drawn) {
    return;
  }
  const { pen, x, y } = drawn;
  pen.strokeStyle = colour("request");
  pen.lineWidth = 2;
  pen.beginPath();
  let isAmid = false;
  for (const { at, value } of samples) {
    if (value !== null) {
      pen[isAmid ? "lineTo" : "moveTo"](Math.max(LEFT, x(at)), y(value));
    }
    isAmid = value !== null;
  }
  pen.stroke();
  pen.lineWidth = 1;
}

/** The next round number. */
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((digit) => digit * power).find((round) => round >= value);
}

function wordsOf(points) {
  const good = points.filter(({ value }) => value !== null).map(({ value }) => value).sort((one, other) => one - other);
  const bad = `${points.length - good.length} without a good answer`;
  if (good.length === 0) {
    return `no answer, ${bad}`;
  }
  const [half, longest] = [good[Math.floor((good.length - 1) / 2)], good[good.length - 1]].map(milliseconds);
  return `${good.length} answers, half of them within ${half}, the longest ${longest}, ${bad}`;
}

/** How far back the points of a device go: no more of them are kept than so many. */
function reach(points, now) {
  return points.length < MOST_POINTS ? PLOTTED : Math.min(PLOTTED, Math.max(1e6, now - points[0].at));
}

export function plotLatency(canvas, name, points, now) {
  const span = reach(points, now);
  const shown = points.filter(({ at }) => at >= now - span);
  const time = span === PLOTTED ? "two minutes" : duration(span / 1e6);
  canvas.setAttribute("aria-label", `How long ${name} took to answer, in the last ${time}: ${wordsOf(shown)}`);
  const top = roundUp(Math.max(1, ...shown.map(({ value }) => value ?? 0)));
  const drawn = frame(canvas, now, span, top, `${top} ms`);
  if (!drawn) {
    return;
  }
  const { pen, x, y } = drawn;
  pen.fillStyle = colour("response");
  for (const { at, value } of shown) {
    if (value !== null) {
      pen.fillRect(x(at) - 1.5, y(value) - 1.5, 3, 3);
    }
  }
  pen.strokeStyle = colour("bad");
  pen.lineWidth = 2;
  pen.beginPath();
  for (const { at, value } of shown) {
    if (value === null) {
      const [left, high] = [x(at) - 3, y(top) - 3];
      pen.moveTo(left, high);
      pen.lineTo(left + 6, high + 6);
      pen.moveTo(left + 6, high);
      pen.lineTo(left, high + 6);
    }
  }
  pen.stroke();
  pen.lineWidth = 1;
}
