// The road as the page knows it: where a point of the map lies on it, how high it is, what a cut across shows.
// Rows come from the piece of full detail that holds u, else from those with all columns that the page keeps of
// the whole road (`unpackDetail()`, asked for once).

import { micro } from './format.js';

export function makeSurface(sheet, windows, unpackDetail) {
  let detail = null;
  const gridAt = (u) => windows.find((w) => u >= w.uBegin && u <= w.uOf(w.rows - 1)) ?? (detail ??= unpackDetail());

  /// t in [0, 1] between rows or columns i and i + 1.
  const between = (at, count) => {
    const i = Math.min(count - 2, Math.max(0, Math.floor(at)));
    return [i, Math.min(1, Math.max(0, at - i))];
  };

  function columnAt(grid, v) {
    let low = 0, high = grid.columns - 1;
    if (!(v >= grid.v[low] - 1e-6 && v <= grid.v[high] + 1e-6)) return null;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (grid.v[middle] <= v) low = middle; else high = middle;
    }
    return [low, Math.min(1, Math.max(0, (v - grid.v[low]) / (grid.v[high] - grid.v[low])))];
  }

  /// Bilinear between the nodes around; NaN where one that counts has no height.
  function heightIn(grid, u, v) {
    const column = columnAt(grid, v);
    if (!column) return NaN;
    const [i, t] = between((u - grid.uBegin) / grid.uStep, grid.rows), [j, s] = column;
    let z = 0;
    for (const [k, weight] of [[i * grid.columns + j, (1 - t) * (1 - s)], [i * grid.columns + j + 1, (1 - t) * s],
      [(i + 1) * grid.columns + j, t * (1 - s)], [(i + 1) * grid.columns + j + 1, t * s]]) {
      if (weight > 1e-6) z += weight * grid.z[k];
    }
    return z + grid.zBase;
  }

  function positionAt(u, v) {
    const [i, t] = between((u - sheet.uBegin) / sheet.uStep, sheet.rows);
    const mix = (values) => values[i] + t * (values[i + 1] - values[i]);
    return [mix(sheet.x) + v * mix(sheet.nx), mix(sheet.y) + v * mix(sheet.ny)];
  }

  /// {u, v} of a place of the map, or null beside the road. Where stretches lie above each other: the one on top.
  function pick(x, y) {
    const v0 = sheet.v[0], v1 = sheet.v[sheet.columns - 1];
    let best = null, top = -Infinity, before = null;
    for (let i = 0; i < sheet.rows; ++i) {
      const dx = x - sheet.x[i], dy = y - sheet.y[i], nx = sheet.nx[i], ny = sheet.ny[i], size = nx * nx + ny * ny;
      const ahead = dx * ny - dy * nx, v = (dx * nx + dy * ny) / size;
      // Between the cuts through two rows: behind the one, before the other.
      if (before && before.ahead >= 0 && ahead < 0) {
        const t = before.ahead / (before.ahead - ahead), at = before.v + t * (v - before.v), u = sheet.uOf(i - 1 + t);
        if (at >= v0 && at <= v1) {
          const z = heightIn(sheet, u, at);
          if (z > top) { top = z; best = { u, v: at }; }
        }
      }
      before = { ahead, v };
    }
    return best;
  }

  return {
    pick, positionAt,
    heightAt: (u, v) => heightIn(gridAt(u), u, v),
    /// The row nearest to u: its u, all v, heights (null: none) and how far rows are apart here.
    cutAt(u) {
      const grid = gridAt(u), i = grid.rowOf(u), z = [];
      for (let j = 0; j < grid.columns; ++j) {
        const value = grid.z[i * grid.columns + j];
        z.push(Number.isNaN(value) ? null : micro(value + grid.zBase));
      }
      return { u: grid.uOf(i), v: grid.v, z, step: grid.uStep };
    },
  };
}
