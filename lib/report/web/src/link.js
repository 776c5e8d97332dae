// A link that leads to a place: what is looked at, in the part of the address after '#'. Ids of sections may
// stand there too; they hold no '='.

const numbers = (text, count) => {
  const list = (text ?? '').split(',').map((part) => (/^-?\d+(\.\d+)?$/.test(part) ? Number(part) : NaN));
  return list.length === count && list.every(Number.isFinite) ? list : null;
};

const rounded = (values) => values.map((value) => String(Math.round(1000 * value) / 1000 || 0)).join(',');

export function hashOf(state) {
  const parts = [];
  const whole = state.range[0] === state.uBegin && state.range[1] === state.uEnd;
  if (!whole) parts.push(`u=${rounded(state.range)}`);
  if (state.place) parts.push(`place=${rounded(state.place)}`);
  if (state.field !== state.firstField) parts.push(`colour=${encodeURIComponent(state.field)}`);
  if (state.point) parts.push(`cut=${rounded([state.point.u, state.point.v])}`);
  if (state.measured.length === 2) parts.push(`measure=${rounded(state.measured.flatMap((point) => [point.u, point.v]))}`);
  if (state.map) parts.push(`plan=${rounded([state.map.x, state.map.y, state.map.span])}`);
  return parts.length > 0 ? `#${parts.join('&')}` : '';
}

/// Takes over what the address says; true if it says something. What is not understood, or does not lie on
/// the road, is left out.
export function followHash(hash, state, sheet) {
  if (!hash.includes('=')) return false;
  const said = Object.fromEntries(hash.slice(1).split('&').map((part) => part.split('=')).filter((part) => part.length === 2));
  const onRoad = (u, v) => u >= state.uBegin && u <= state.uEnd && v >= sheet.v[0] - 0.01 && v <= sheet.v[sheet.columns - 1] + 0.01;
  const range = numbers(said.u, 2), one = numbers(said.u, 1), there = numbers(said.place, 2), cut = numbers(said.cut, 2), measured = numbers(said.measure, 4), map = numbers(said.plan, 3);
  const place = there && there[0] <= there[1] && onRoad(there[0], sheet.v[0]) && onRoad(there[1], sheet.v[0]) ? there : null;
  // What the place says of the cursor comes last.
  state.setPoint(cut && onRoad(cut[0], cut[1]) ? { u: cut[0], v: cut[1] } : null);
  if (state.point) state.setCursor(state.point.u, 'link');
  state.setMeasured(measured && onRoad(measured[0], measured[1]) && onRoad(measured[2], measured[3])
    ? [{ u: measured[0], v: measured[1] }, { u: measured[2], v: measured[3] }] : []);
  const field = sheet.fields.find((candidate) => encodeURIComponent(candidate.key) === said.colour);
  state.setField(field ? field.key : state.firstField);
  if (one && one[0] >= state.uBegin && one[0] <= state.uEnd) {
    state.goTo(one[0], one[0]);
  } else {
    state.place = place;
    state.emit('place');
    if (range) state.setRange(range[0], range[1], 'link');
    else if (!place) state.reset();
    else state.goTo(place[0], place[1]);
    if (place) state.setCursor(0.5 * (place[0] + place[1]), 'link');
  }
  state.map = map && map[2] > 0 ? { x: map[0], y: map[1], span: map[2] } : null;
  if (state.map) state.emit('map', 'link');
  return true;
}
