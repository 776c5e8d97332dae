// What all views share: the range of u they show, the place under the cursor, the colour field.

export function makeState(uBegin, uEnd) {
  const listeners = [];
  const state = {
    uBegin, uEnd,
    range: [uBegin, uEnd],
    place: null,       // [begin, end] of the finding that was asked for
    cursor: null,      // u
    field: 'elevation',
    subscribe(listener) { listeners.push(listener); },
    emit(what, source) { for (const listener of listeners) listener(what, source); },
    setRange(begin, end, source) {
      const low = Math.max(uBegin, Math.min(begin, end)), high = Math.min(uEnd, Math.max(begin, end));
      if (!(high - low > 1e-3) || (Math.abs(low - state.range[0]) < 1e-6 && Math.abs(high - state.range[1]) < 1e-6)) return;
      state.range = [low, high];
      state.emit('range', source);
    },
    setCursor(u, source) {
      if (u === state.cursor) return;
      state.cursor = u;
      state.emit('cursor', source);
    },
    setField(key) {
      state.field = key;
      state.emit('field');
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
      state.setRange(uBegin, uEnd, 'place');
    },
  };
  return state;
}
