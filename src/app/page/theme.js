// SPDX-License-Identifier: Apache-2.0
// Colours and pixels for what is drawn: page.css names the colours, for light and dark.

const scheme = matchMedia("(prefers-color-scheme: dark)");
const still = matchMedia("(prefers-reduced-motion: reduce)");

export const wantsStill = () => still.matches;

let colours = null;
scheme.addEventListener("change", () => (colours = null));

export function colour(name) {
  if (!colours) {
    const style = getComputedStyle(document.documentElement);
    const names = ["back", "panel", "text", "faint", "edge", "link", "good", "warn", "bad", "request", "response", "on-mark"];
    colours = new Map(names.map((it) => [it, style.getPropertyValue(`--${it}`).trim()]));
  }
  return colours.get(name);
}

/** Calls `draw` when the colours have become others. */
export function onTheme(draw) {
  scheme.addEventListener("change", draw);
}

/** An empty canvas as sharp as the screen: { pen, width, height } in CSS pixels; null while it is not shown. */
export function cleared(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (width === 0 || height === 0) {
    return null;
  }
  const scale = window.devicePixelRatio || 1;
  const [wide, high] = [Math.round(width * scale), Math.round(height * scale)];
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "12px system-ui, sans-serif";
  pen.textBaseline = "middle";
  return { pen, width, height };
}
