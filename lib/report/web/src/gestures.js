// What a finger, a wheel and a key do to a plot. One finger belongs to the page, which it scrolls; two fingers
// belong to the plot. The style sheet lets plots pan with `touch-action: pan-y`.

/// Calls move(before, now) as two fingers on `node` move; each is {x, y, apart} in the node's pixels.
export function onTwoFingers(node, move) {
  let last = null;
  const of = (event) => {
    const box = node.getBoundingClientRect(), [a, b] = event.targetTouches;
    return {
      x: 0.5 * (a.clientX + b.clientX) - box.left, y: 0.5 * (a.clientY + b.clientY) - box.top,
      apart: Math.max(1, Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY)),
    };
  };
  const begin = (event) => { last = event.targetTouches.length === 2 ? of(event) : null; };
  node.addEventListener('touchstart', begin, { passive: true });
  node.addEventListener('touchend', begin, { passive: true });
  node.addEventListener('touchcancel', () => { last = null; }, { passive: true });
  // Not passive, but it holds back the page for two fingers only.
  node.addEventListener('touchmove', (event) => {
    if (event.targetTouches.length !== 2) return;
    if (event.cancelable) event.preventDefault();
    const now = of(event);
    if (last) move(last, now);
    last = now;
  }, { passive: false });
}

/// Whether a wheel's turn is meant for the plot: it was clicked or has the keyboard, or Ctrl is held (which is
/// also what pinching a touchpad sends). Any other turn scrolls the page.
export function wheelIsFor(node, event) {
  return event.ctrlKey || event.metaKey || document.activeElement === node;
}

/// What a key asks of a plot: {zoom: factor}, {dx, dy} (steps to the right and up) or {reset: true}; null: nothing.
export function wishOf(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return null;
  switch (event.key) {
    case '+': case '=': return { zoom: 1.5 };
    case '-': case '_': return { zoom: 1 / 1.5 };
    case '0': return { reset: true };
    case 'ArrowLeft': return { dx: -1, dy: 0 };
    case 'ArrowRight': return { dx: 1, dy: 0 };
    case 'ArrowUp': return { dx: 0, dy: 1 };
    case 'ArrowDown': return { dx: 0, dy: -1 };
    default: return null;
  }
}

/// answer(wish) tells whether it used the key; only then the page does not get it.
export function onKeys(node, answer) {
  node.addEventListener('keydown', (event) => {
    if (event.target !== node) return;
    const wish = wishOf(event);
    if (!wish || !answer(wish)) return;
    event.preventDefault();
    event.stopPropagation();
  });
}
