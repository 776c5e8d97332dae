// Elements from plain values. Text is always text: nothing here parses markup.
import { metres } from './format.js';

export function el(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === 'onclick') node.addEventListener('click', value);
    else if (value !== undefined && value !== null) node.setAttribute(key, String(value));
  }
  for (const child of children.flat()) {
    if (child === null || child === undefined) continue;
    node.append(child instanceof Node ? child : document.createTextNode(String(child)));
  }
  return node;
}

export function table(heads, rows, attributes = {}) {
  const cell = (name, value) => {
    const plain = value !== null && typeof value === 'object' && 'number' in value;
    return plain ? el(name, { class: 'number' }, value.number) : el(name, {}, value);
  };
  return el('div', { class: 'scroll' }, el('table', attributes,
    heads ? el('thead', {}, el('tr', {}, heads.map((head) => cell('th', head)))) : null,
    el('tbody', {}, rows.map((row) => el('tr', {}, row.map((value) => cell('td', value)))))));
}

/// Fills a list anew. Where the keyboard was in it, it stays: at what has the same words, or at what is in its place now.
export function refill(box, ...children) {
  const stops = () => [...box.querySelectorAll('button, input, select, a[href], summary')];
  const words = (each) => `${each.tagName} ${each.getAttribute('aria-label') ?? each.textContent}`;
  const before = stops(), place = before.indexOf(document.activeElement), held = place < 0 ? '' : words(before[place]);
  box.replaceChildren(...children);
  if (place < 0) return;
  const now = stops();
  (now.find((each) => words(each) === held) ?? now[Math.min(place, now.length - 1)])?.focus({ preventScroll: true });
}

/// Text that is written many times a second: a node that says it already is left alone, for the browser would draw it anew.
export function write(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export function css(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

export function placeButton(state, begin, end) {
  const text = end - begin < 1 ? `u ${metres(begin)} m` : `u ${metres(begin)}–${metres(end)} m`;
  return el('button', {
    class: 'place', type: 'button', 'data-begin': begin, 'data-end': end, title: 'Show this place in every view',
    onclick: () => state.goTo(begin, end),
  }, text);
}

/// Tells tests, and whoever inspects the page, what range of u a view shows.
export function markRange(node, begin, end) {
  node.dataset.uBegin = begin.toFixed(3);
  node.dataset.uEnd = end.toFixed(3);
}
