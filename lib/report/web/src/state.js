// What all views share: the range of u they show, the place under the cursor, the colour field, what was
// picked to be cut or measured.

export function makeState(uBegin, uEnd, firstField) {
  const listeners = [];
  const state = {
    uBegin, uEnd,
    range: [uBegin, uEnd],
    place: null,       // [begin, end] of the finding that was asked for
    cursor: null,      // u
    firstField, field: firstField,  // the colour at first, of which links say nothing; the one chosen
    point: null,       // {u, v}: where the cross section lies
    measured: [],      // up to two {u, v}
    measuring: false,  // whether clicks on the plan measure
    map: null,         // {x, y, span} of the plan where it was moved by hand: middle and width in metres
    subscribe(listener) { listeners.push(listener); },
    emit(what, source) { for (const listener of listeners) listener(what, source); },
    setRange(begin, end, source) {
      const low = Math.max(uBegin, Math.min(begin, end)), high = Math.min(uEnd, Math.max(begin, end));
      if (!(high - low > 1e-3) || (Math.abs(low - state.range[0]) < 1e-6 && Math.abs(high - state.range[1]) < 1e-6)) return;
      state.range = [low, high];
      state.map = null;
      state.emit('range', source);
    },
    /// The range of that width, pushed back into the road where it sticks out.
    moveTo(begin, end) {
      const width = Math.min(uEnd - uBegin, Math.max(1, end - begin));
      const low = Math.min(uEnd - width, Math.max(uBegin, 0.5 * (begin + end) - 0.5 * width));
      state.setRange(low, low + width, 'keys');
    },
    /// `factor` nearer, then moved by that share of what is in view.
    zoom(factor, share) {
      const [low, high] = state.range, width = (high - low) / factor, at = state.centre();
      const begin = at - (at - low) / factor + share * width;
      state.moveTo(begin, begin + width);
    },
    /// Where zooming by keys goes: to the cursor, if it is in view.
    centre() {
      const [low, high] = state.range;
      return state.cursor !== null && state.cursor > low && state.cursor < high ? state.cursor : 0.5 * (low + high);
    },
    setCursor(u, source) {
      if (u === state.cursor) return;
      state.cursor = u;
      state.emit('cursor', source);
    },
    setField(key) {
      if (key === state.field) return;
      state.field = key;
      state.emit('field');
    },
    setPoint(point) {
      state.point = point;
      state.emit('point');
    },
    setMeasured(points) {
      state.measured = points;
      state.emit('measured');
    },
    setMeasuring(on) {
      state.measuring = on;
      state.emit('measuring');
    },
    goTo(begin, end) {
      const margin = Math.max(15, 0.5 * (end - begin));
      state.place = [begin, end];
      state.emit('place');
      state.setRange(begin - margin, end + margin, 'place');
      state.setCursor(0.5 * (begin + end), 'place');
    },
    reset() {
      state.place = null;
      state.emit('place');
      // Also where only the plan was moved.
      state.range = [NaN, NaN];
      state.setRange(uBegin, uEnd, 'place');
    },
  };
  return state;
}
