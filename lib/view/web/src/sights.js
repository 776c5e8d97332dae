// What a run tells beside its numbers: scans, edges of the drivable area, a planned way; drawn on the map from above.

const kFresh_s = 1, kKept = 400;

/// The images of the axes of yaw, then pitch (nose down positive), then roll (left side up positive).
export function turned([roll, pitch, yaw], [x, y, z]) {
  const [cr, sr, cp, sp, cy, sy] = [roll, pitch, yaw].flatMap((angle) => [Math.cos(angle), Math.sin(angle)]);
  return [
    cy * cp * x + (cy * sp * sr - sy * cr) * y + (cy * sp * cr + sy * sr) * z,
    sy * cp * x + (sy * sp * sr + cy * cr) * y + (sy * sp * cr - cy * sr) * z,
    -sp * x + cp * sr * y + cp * cr * z,
  ];
}

/// Where the car was at a time, between the measurements that are known; the nearest one beyond them.
export function placeAt(past, time_s) {
  if (past.length === 0) return null;
  const after = past.findIndex((each) => each.time_s >= time_s);
  if (after === 0) return past[0];
  if (after < 0) return past.at(-1);
  const [a, b] = [past[after - 1], past[after]], share = (time_s - a.time_s) / (b.time_s - a.time_s);
  const turn = Math.atan2(Math.sin(b.yaw - a.yaw), Math.cos(b.yaw - a.yaw));
  return { time_s, x: a.x + share * (b.x - a.x), y: a.y + share * (b.y - a.y), yaw: a.yaw + share * turn };
}

/// [[x, y], ...] on the map of points in the car's frame.
function onMap(place, points) {
  const c = Math.cos(place.yaw), s = Math.sin(place.yaw);
  return points.map(([x, y]) => [place.x + c * x - s * y, place.y + s * x + c * y]);
}

export function makeSights() {
  let past = [], scans = new Map(), edges = new Map(), plan = null;

  function clear() {
    past = [];
    scans = new Map();
    edges = new Map();
    plan = null;
  }

  function takeScan(said) {
    let scan = scans.get(said.scan);
    // Its parts come one after the other, and some may be lost.
    if (scan?.time_s !== said.time_s) scans.set(said.scan, scan = { time_s: said.time_s, points: [] });
    const place = placeAt(past, said.time_s);
    if (!place) return;
    const inCar = said.points.map((point) => turned(said.turned_rad, point).map((value, axis) => value + said.at_m[axis]));
    onMap(place, inCar).forEach(([x, y], k) => scan.points.push([x, y, said.points[k][3]]));
  }

  /// A measurement, with what was seen since the one before.
  function take(measured) {
    const { 'car.x': x, 'car.y': y, 'car.yaw': yaw } = measured.values, time_s = measured.time_s;
    if (past.length > 0 && time_s < past.at(-1).time_s) clear();  // a reset
    if (past.at(-1)?.time_s !== time_s) past.push({ time_s, x, y, yaw });
    past.splice(0, past.length - kKept);
    for (const said of measured.sights ?? []) {
      if (said.time_s > time_s + kFresh_s) continue;  // of before a reset
      if (said.scan !== undefined) takeScan(said);
      const place = said.edges === undefined ? null : placeAt(past, said.time_s);
      if (place) edges.set(said.edges, { time_s: said.time_s, left: onMap(place, said.left), right: onMap(place, said.right) });
      if (said.plan !== undefined) plan = { time_s: said.time_s, points: said.plan };
    }
    for (const each of [scans, edges]) for (const [name, { time_s: seen_s }] of each) if (seen_s < time_s - kFresh_s) each.delete(name);
    if (plan && plan.time_s < time_s - kFresh_s) plan = null;
  }

  /// `pen(colour, pixels)` chooses a line, `path(xs, ys)` draws one; a point is `size_m` wide.
  function draw(context, { pen, path, colour, size_m }) {
    for (const { points } of scans.values())
      for (const [x, y, intensity] of points) {
        context.globalAlpha = 0.35 + 0.65 * Math.min(1, 3 * intensity);
        context.fillStyle = colour('--s1');
        context.fillRect(x - 0.5 * size_m, y - 0.5 * size_m, size_m, size_m);
      }
    context.globalAlpha = 1;
    const line = (points) => path(points.map(([x]) => x), points.map(([, y]) => y));
    for (const { left, right } of edges.values()) {
      pen('--s2', 3);
      line(left);
      line(right);
    }
    if (plan) {
      pen('--s4', 4);
      line(plan.points);
    }
  }

  /// Edges and plan as lines on the map, with the names of their colours.
  const lines = () => [...[...edges.values()].flatMap(({ left, right }) => [{ points: left, colour: '--s2' }, { points: right, colour: '--s2' }]), ...(plan ? [{ points: plan.points, colour: '--s4' }] : [])];

  const total = (map, count) => [...map.values()].reduce((sum, each) => sum + count(each), 0);
  /// How many points of each are drawn.
  const counts = () => ({ scan: total(scans, (each) => each.points.length), edges: total(edges, (each) => each.left.length + each.right.length), plan: plan?.points.length ?? 0 });
  return { take, draw, clear, lines, counts };
}
