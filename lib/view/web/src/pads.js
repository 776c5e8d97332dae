// What a gamepad or a finger asks for: {steer: -1 left to 1 right, throttle, brake: 0 to 1}; null: nothing.

const kFull_px = 120;  // a finger that far from where it was put down asks for all
const kDead = 0.06;  // sticks do not rest at zero
const share = (value) => Math.min(1, Math.max(0, value));

export function padNow() {
  const pad = [...(navigator.getGamepads?.() ?? [])].find((each) => each?.connected);
  if (!pad) return null;
  const stick = pad.axes[0] ?? 0;
  return { steer: Math.abs(stick) < kDead ? 0 : stick, throttle: pad.buttons[7]?.value ?? 0, brake: pad.buttons[6]?.value ?? 0 };
}

/// A finger on one of the pictures: sideways it steers, upwards it accelerates, downwards it brakes. Gives what it asks for now.
export function makeTouchPad(canvases) {
  let finger = null, begin = [0, 0], at = [0, 0];
  for (const canvas of canvases) {
    canvas.style.touchAction = 'none';
    canvas.addEventListener('pointerdown', (event) => {
      if (event.pointerType !== 'touch' || finger !== null) return;
      finger = event.pointerId;
      begin = at = [event.clientX, event.clientY];
    });
    canvas.addEventListener('pointermove', (event) => { if (event.pointerId === finger) at = [event.clientX, event.clientY]; });
    for (const kind of ['pointerup', 'pointercancel']) canvas.addEventListener(kind, (event) => { if (event.pointerId === finger) finger = null; });
  }
  return () => {
    if (finger === null) return null;
    const [right, up] = [(at[0] - begin[0]) / kFull_px, (begin[1] - at[1]) / kFull_px];
    return { steer: Math.min(1, Math.max(-1, right)), throttle: share(up), brake: share(-up) };
  };
}
