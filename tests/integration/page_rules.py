# SPDX-License-Identifier: Apache-2.0
"""What the status page must keep for people who see little, or nothing, or use no mouse: rules of our own, looked at in the
browser by what it has computed."""

# Text whose contrast to what is behind it is below 4.5 (WCAG 2.1, 1.4.3), each once.
CONTRAST = """
const number = (colour) => colour.match(/[\\d.]+/g).map(Number);
const light = ([red, green, blue]) => {
  const linear = [red / 255, green / 255, blue / 255].map((it) => (
    it <= 0.04045 ? it / 12.92 : ((it + 0.055) / 1.055) ** 2.4));
  return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
};
const contrast = (one, other) => {
  const [dark, bright] = [light(one), light(other)].sort((left, right) => left - right);
  return (bright + 0.05) / (dark + 0.05);
};
const behind = (element) => {
  for (let at = element; at; at = at.parentElement) {
    const colour = number(getComputedStyle(at).backgroundColor);
    if (colour[3] !== 0) {
      return colour;
    }
  }
  return [255, 255, 255];
};
const found = new Set();
let looked = 0;
for (const element of document.querySelectorAll("body, body *")) {
  const hasText = [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.textContent.trim() !== "");
  if (!hasText || element.getClientRects().length === 0 || element.tagName === "OPTION") {
    continue;
  }
  looked += 1;
  const style = getComputedStyle(element);
  const ratio = contrast(number(style.color), behind(element));
  if (ratio < 4.5 || style.opacity !== "1") {
    found.add(`${ratio.toFixed(2)} ${element.tagName} ${element.className}: ${element.textContent.slice(0, 40)}`);
  }
}
// What is drawn: letters on the ground of a picture, and on what is marked in it. 3 suffices for marks (1.4.11).
const probe = document.body.appendChild(document.createElement("i"));
const named = (name) => {
  probe.style.color = `var(--${name})`;
  return number(getComputedStyle(probe).color);
};
const pairs = [
  ...["text", "faint", "bad", "good", "warn", "link"].flatMap((name) => [[name, "panel", 4.5], [name, "back", 4.5]]),
  ...["request", "response", "bad"].map((mark) => ["on-mark", mark, 4.5]),
  ...["request", "response", "bad", "warn", "edge"].map((mark) => [mark, "panel", 3]),
];
for (const [one, other, least] of pairs) {
  const ratio = contrast(named(one), named(other));
  if (ratio < least) {
    found.add(`${ratio.toFixed(2)} of --${one} on --${other}`);
  }
}
probe.remove();
return { looked, found: [...found] };
"""

# Values that cannot be read without scrolling the page sideways, or are cut off.
FIT = """
const width = document.documentElement.clientWidth;
const found = [];
if (document.documentElement.scrollWidth > width) {
  found.push(`the page is ${document.documentElement.scrollWidth} wide in a window of ${width}`);
}
const values = [...document.querySelectorAll("dd, td, h2, h3, p, .controls > *, .fields li, canvas")]
  .filter((it) => it.getClientRects().length > 0 && !it.closest(".skip"));
for (const value of values) {
  const box = value.getBoundingClientRect();
  const isCut = value.tagName !== "CANVAS" && value.clientWidth > 0 && value.scrollWidth > value.clientWidth + 1;
  if (box.left < 0 || box.right > width + 0.5 || box.width < 1 || isCut) {
    found.push(`${value.tagName} from ${box.left} to ${box.right}: ${value.textContent.slice(0, 40)}`);
  }
}
return { looked: values.length, found };
"""

# What a screen reader would not be told.
LABELS = """
const found = [];
const textOf = (ids) => ids.split(" ").map((id) => document.getElementById(id)?.textContent.trim() ?? "").join(" ").trim();
const nameOf = (it) => it.getAttribute("aria-label")
  || (it.hasAttribute("aria-labelledby") && textOf(it.getAttribute("aria-labelledby")))
  || [...(it.labels ?? [])].map((label) => label.textContent.trim()).join(" ")
  || (it.matches("button, a") && it.textContent.trim());
for (const it of document.querySelectorAll("button, a, select, input, canvas, nav, form, section, [role=region], [role=group]")) {
  if (!nameOf(it)) {
    found.push(`${it.tagName} ${it.id} has no name`);
  }
  for (const attribute of ["aria-labelledby", "aria-describedby"]) {
    if (it.hasAttribute(attribute) && textOf(it.getAttribute(attribute)) === "" && !it.hidden) {
      found.push(`${it.tagName} ${it.id}: ${attribute} leads nowhere`);
    }
  }
}
for (const table of document.querySelectorAll("table")) {
  if (!table.caption?.textContent.trim() || [...table.querySelectorAll("th")].some((head) => head.scope !== "col")) {
    found.push(`a table has no caption, or heads without scope: ${table.textContent.slice(0, 40)}`);
  }
}
let level = 0;
for (const heading of document.querySelectorAll("h1, h2, h3, h4, h5, h6")) {
  const own = Number(heading.tagName[1]);
  if (own > level + 1) {
    found.push(`${heading.tagName} after H${level}: ${heading.textContent}`);
  }
  level = own;
}
for (const [what, count] of [["main", 1], ["header", 1], ["h1", 1], ["nav", 1]]) {
  if (document.querySelectorAll(what).length !== count) {
    found.push(`not one ${what}`);
  }
}
const ids = [...document.querySelectorAll("[id]")].map((it) => it.id);
if (new Set(ids).size !== ids.length) {
  found.push("an id is there twice");
}
if (document.documentElement.lang !== "en" || !document.title) {
  found.push("no language, or no title");
}
// A sign beside each colour: who sees none must know it too.
for (const it of document.querySelectorAll(".bad, .warn, .good")) {
  if (!/^[✕✓!·]/.test(it.textContent) && it.textContent !== "" && !it.hidden) {
    found.push(`a colour alone: ${it.textContent.slice(0, 40)}`);
  }
}
return { looked: ids.length, found };
"""
