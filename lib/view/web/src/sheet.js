// The road that was built as the mesh's frame sees it: places of u and v.

/// `packed` of getPacked('road'), `align` of its summary.json (null: the file is in the mesh's frame).
export function makeSheet(packed, align) {
  const yaw = ((align?.yaw_deg ?? 0) * Math.PI) / 180, [tx, ty] = align?.translation_m ?? [0, 0];
  const { rows, closed, length_m: length } = packed.head;
  /// Of the road file; the mesh is turned about z, then moved.
  const toMap = ([x, y]) => [Math.cos(yaw) * x - Math.sin(yaw) * y + tx, Math.sin(yaw) * x + Math.cos(yaw) * y + ty];
  const toMesh = ([x, y]) => [Math.cos(yaw) * (x - tx) + Math.sin(yaw) * (y - ty), -Math.sin(yaw) * (x - tx) + Math.cos(yaw) * (y - ty)];
  const rowOf = (u) => {
    let low = 0, high = rows - 1;
    while (low + 1 < high) {
      const middle = (low + high) >> 1;
      if (packed.u_m[middle] <= u) low = middle; else high = middle;
    }
    return low;
  };
  return {
    length, closed, toMap, toMesh,
    /// Place in the mesh's frame, between the rows that were sent.
    at(u, v) {
      const i = rowOf(u), t = (u - packed.u_m[i]) / (packed.u_m[i + 1] - packed.u_m[i]);
      const dx = packed.x_m[i + 1] - packed.x_m[i], dy = packed.y_m[i + 1] - packed.y_m[i], along = Math.hypot(dx, dy) || 1;
      return toMesh([packed.x_m[i] + t * dx - (v * dy) / along, packed.y_m[i] + t * dy + (v * dx) / along]);
    },
    /// u of the rows from one place to another, over the start where the first is the larger.
    between(begin, end) {
      const first = packed.u_m[0], last = packed.u_m[rows - 1];
      const inside = (low, high) => [Math.max(low, first), ...Array.from(packed.u_m).filter((u) => u > low && u < high), Math.min(high, last)];
      return begin <= end ? inside(begin, end) : [...inside(begin, last), ...inside(first, end)];
    },
    /// [u from, u to] of the stretch that is seen and comes nearest to the middle; null: none is. `seenAt(x, y)`: as the stage has it.
    stretchSeen(seenAt) {
      const seen = Array.from({ length: rows }, (_, i) => seenAt(...toMesh([packed.x_m[i], packed.y_m[i]]))), isIn = (i) => Math.max(Math.abs(seen[i][0]), Math.abs(seen[i][1])) <= 1;
      let best = -1;
      for (let i = 0; i < rows; ++i) if (isIn(i) && (best < 0 || Math.hypot(...seen[i]) < Math.hypot(...seen[best]))) best = i;
      if (best < 0) return null;
      if (seen.every((_, i) => isIn(i))) return [packed.u_m[0], packed.u_m[rows - 1]];
      // The last row of a closed road is its first.
      const count = closed ? rows - 1 : rows, step = (i, by) => (closed ? (i + by + count) % count : i + by);
      let first = best % count, last = first;
      for (let next = step(first, -1); next >= 0 && next !== last && isIn(next); next = step(first, -1)) first = next;
      for (let next = step(last, 1); next < count && next !== first && isIn(next); next = step(last, 1)) last = next;
      return [packed.u_m[first], packed.u_m[last]];
    },
    /// The same road for stage.setRoad, in the mesh's frame.
    inMesh: () => {
      const out = { ...packed };
      for (const [x, y] of [['x_m', 'y_m'], ['left_x_m', 'left_y_m'], ['right_x_m', 'right_y_m']]) {
        const points = Array.from(packed[x], (value, k) => toMesh([value, packed[y][k]]));
        out[x] = points.map((p) => p[0]);
        out[y] = points.map((p) => p[1]);
      }
      const dz = align?.translation_m?.[2] ?? 0;
      if (dz !== 0) out.z_m = packed.z_m.map((z) => z - dz);
      return out;
    },
  };
}
