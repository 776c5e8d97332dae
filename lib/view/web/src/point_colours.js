// Colours of points, each written into [r, g, b] of 0 to 255.

// Viridis (CC0), from dark to light.
const stops = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];
const others = [[29, 111, 204], [214, 96, 26], [20, 140, 84], [150, 70, 180], [196, 48, 72], [120, 110, 40], [20, 150, 165], [230, 150, 30], [110, 120, 130], [220, 90, 160]];

// Classes of ASPRS (LAS 1.4): numbers, names, colours; others by their number.
const classes = {
  0: ['never classified', [128, 134, 140]], 1: ['unclassified', [128, 134, 140]], 2: ['ground', [176, 122, 70]], 3: ['low vegetation', [140, 190, 80]], 4: ['medium vegetation', [84, 160, 60]],
  5: ['high vegetation', [36, 120, 50]], 6: ['building', [205, 80, 60]], 7: ['noise', [210, 20, 140]], 9: ['water', [50, 120, 220]], 10: ['rail', [130, 90, 160]], 11: ['road', [84, 96, 112]],
  17: ['bridge', [220, 150, 40]], 18: ['high noise', [210, 20, 140]],
};
export const classNames = Object.fromEntries(Object.entries(classes).map(([number, [name]]) => [number, name]));

function copy(from, rgb) {
  for (let c = 0; c < 3; ++c) rgb[c] = from[c];
}

/// From 0 to 1, beyond as at the ends; no number: grey.
export function ofShare(t, rgb) {
  if (!(t >= 0 || t < 0)) { copy(classes[0][1], rgb); return; }
  const at = Math.min(0.999999, Math.max(0, t)) * (stops.length - 1), k = Math.floor(at), f = at - k;
  for (let c = 0; c < 3; ++c) rgb[c] = stops[k][c] + f * (stops[k + 1][c] - stops[k][c]);
}

export const ofNumber = (number, rgb) => copy(others[number % others.length], rgb);

export const ofClass = (number, rgb) => (classes[number] ? copy(classes[number][1], rgb) : ofNumber(number, rgb));

const low = [33, 102, 172], middle = [244, 244, 244], high = [178, 24, 43];

/// From -1, blue, over 0, nearly white, to 1, red; beyond as at the ends, no number: grey.
export function ofSigned(t, rgb) {
  if (!(t >= 0 || t < 0)) { copy(classes[0][1], rgb); return; }
  const to = t < 0 ? low : high, f = Math.min(1, Math.abs(t));
  for (let c = 0; c < 3; ++c) rgb[c] = middle[c] + f * (to[c] - middle[c]);
}
