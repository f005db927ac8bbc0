// SPDX-License-Identifier: Apache-2.0
// How the page is changed: what comes from devices, clients and the configuration only ever becomes text. Nodes stay where
// they are as long as what they show is there, so that neither focus nor a reading position is lost.

export const byId = (id) => document.getElementById(id);

/** An element with these attributes; children are nodes, or become text. */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

/** Only where it is another one: a screen reader does not repeat what stays. */
export function setText(node, text) {
  if (node.textContent !== text) {
    node.textContent = text;
  }
}

export function setClass(node, name) {
  if (node.className !== name) {
    node.className = name;
  }
}

/** Has a child of `parent` for each item, in their order. `make(item)` gives { node, update }; `update(item)` is called at once
 *  and each time after that. Of equal keys the first is the first again. */
export class Keyed {
  constructor(parent, keyOf, make) {
    this.parent = parent;
    this.keyOf = keyOf;
    this.make = make;
    this.shown = new Map();
  }

  show(items) {
    const before = this.shown;
    this.shown = new Map();
    const seen = new Map();
    let place = this.parent.firstElementChild;
    for (const item of items) {
      const name = this.keyOf(item);
      seen.set(name, (seen.get(name) ?? 0) + 1);
      const key = `${name} ${seen.get(name)}`;
      const entry = before.get(key) ?? this.make(item);
      before.delete(key);
      this.shown.set(key, entry);
      entry.update(item);
      if (entry.node === place) {
        place = place.nextElementSibling;
      } else {
        this.parent.insertBefore(entry.node, place);
      }
    }
    for (const entry of before.values()) {
      entry.node.remove();
    }
  }
}

/** Rows of a table: `columns` are [label, (item) => text, (item) => class]. Instead of a text there may be a function that makes
 *  a node, once. */
export function tableRows(body, keyOf, columns) {
  return new Keyed(body, keyOf, () => {
    const cells = columns.map(([label]) => element("td", { role: "cell", "data-label": label }, element("span")));
    const node = element("tr", { role: "row" }, ...cells);
    const update = (item) => columns.forEach(([, content, classOf], at) => {
      fill(cells[at].firstChild, content(item), classOf?.(item));
    });
    return { node, update };
  });
}

function fill(place, content, className) {
  setClass(place, className ?? "");
  if (typeof content === "string") {
    setText(place, content);
  } else if (!place.firstChild) {
    place.append(content());
  }
}

/** A <dl> of these terms; update(texts) fills in what they are. */
export function terms(className, names) {
  const values = names.map(() => element("dd"));
  const pairs = names.map((name, at) => element("div", {}, element("dt", {}, name), values[at]));
  const node = element("dl", { class: className }, ...pairs);
  return { node, update: (texts) => texts.forEach((text, at) => setText(values[at], text)) };
}

/** The options of a <select>, `all` first if it has one; what was chosen stays chosen. */
export function setOptions(select, names) {
  const first = select.options[0]?.value === "" ? [select.options[0]] : [];
  const old = [...select.options].slice(first.length).map((option) => option.value);
  if (old.length !== names.length || old.some((name, at) => name !== names[at])) {
    const chosen = select.value;
    select.replaceChildren(...first, ...names.map((name) => element("option", { value: name }, name)));
    select.value = names.includes(chosen) || first.length > 0 && chosen === "" ? chosen : (first[0]?.value ?? names[0] ?? "");
    if (select.value !== chosen) {
      select.dispatchEvent(new Event("change"));
    }
  }
}
