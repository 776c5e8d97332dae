// A road file (getPacked('road')) as triangles in space.
import { BufferAttribute, BufferGeometry } from 'three';

/// Which way is to the left at each row: unit vectors [x, y], from the rows before and behind.
export function leftsOf({ x_m: x, y_m: y, head: { rows, closed } }) {
  return Array.from({ length: rows }, (_, i) => {
    const before = i > 0 ? i - 1 : closed ? rows - 2 : 0, behind = i + 1 < rows ? i + 1 : closed ? 1 : rows - 1;
    const dx = x[behind] - x[before], dy = y[behind] - y[before], along = Math.hypot(dx, dy) || 1;
    return [-dy / along, dx / along];
  });
}

/// Triangles between the nodes that have a height, relative to `origin`; with normals.
export function roadGeometry(packed, origin) {
  const { rows, columns } = packed.head, lefts = leftsOf(packed), place = new Float32Array(3 * rows * columns), index = [];
  for (let i = 0; i < rows; ++i)
    for (let j = 0; j < columns; ++j) {
      const k = i * columns + j, z = packed.z_m[k];
      place.set([packed.x_m[i] + packed.v_m[j] * lefts[i][0] - origin[0], packed.y_m[i] + packed.v_m[j] * lefts[i][1] - origin[1], (Number.isNaN(z) ? origin[2] : z) - origin[2]], 3 * k);
    }
  for (let i = 0; i + 1 < rows; ++i)
    for (let j = 0; j + 1 < columns; ++j) {
      const a = i * columns + j, b = a + 1, c = a + columns, d = c + 1;
      if (!Number.isNaN(packed.z_m[a] + packed.z_m[b] + packed.z_m[c] + packed.z_m[d])) index.push(a, c, b, b, c, d);
    }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(place, 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(index), 1));
  geometry.computeVertexNormals();
  return geometry;
}
