// The report's data: JSON in the page, long rows of numbers packed: zlib, then base64.

function bytesOf(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let k = 0; k < binary.length; ++k) bytes[k] = binary.charCodeAt(k);
  return bytes;
}

/// Planes of bytes back to numbers; integers are differences from the one before.
async function numbersOf(packed) {
  const Kind = packed.type === 'f32' ? Float32Array : Int16Array, size = Kind.BYTES_PER_ELEMENT;
  const inflated = new Blob([bytesOf(packed.data)]).stream().pipeThrough(new DecompressionStream('deflate'));
  const planes = new Uint8Array(await new Response(inflated).arrayBuffer()), count = planes.length / size;
  const values = new Kind(count), bytes = new Uint8Array(values.buffer);
  for (let p = 0; p < size; ++p) for (let k = 0; k < count; ++k) bytes[k * size + p] = planes[p * count + k];
  if (Kind === Int16Array) for (let k = 1; k < count; ++k) values[k] += values[k - 1];
  return values;
}

/// All packed rows in a tree of values, unpacked in their places.
async function unpackAll(tree) {
  if (tree === null || typeof tree !== 'object') return;
  if (typeof tree.data === 'string' && typeof tree.type === 'string') tree.numbers = await numbersOf(tree);
  else await Promise.all(Object.values(tree).map(unpackAll));
}

export function unpack(packed) {
  return packed.numbers;
}

/// Float32Array of begin[row] + step * integer; the two smallest integers stand for NaN.
export function unpackRows(packed, columns) {
  const integers = unpack(packed.values);
  const begin = packed.begin ? unpack(packed.begin) : null;
  const values = new Float32Array(integers.length);
  for (let k = 0; k < integers.length; ++k) {
    values[k] = integers[k] <= -32767 ? NaN : (begin ? begin[Math.floor(k / columns)] : 0) + packed.step * integers[k];
  }
  return values;
}

/// A curve: the same in blocks of `columns`, the last of which is padded.
export function unpackCurve(packed) {
  return unpackRows(packed, packed.columns).subarray(0, packed.count);
}

/// Where an error map says that there is a road but nothing to compare it with.
export function unpackWithout(packed) {
  return unpack(packed.values).map((integer) => (integer === -32767 ? 1 : 0));
}

export function unpackSheet(sheet) {
  const columns = sheet.v_m.length;
  const rows = sheet.rows;
  const x = unpack(sheet.x), y = unpack(sheet.y), nx = unpack(sheet.normal_x), ny = unpack(sheet.normal_y);
  const px = new Float32Array(rows * columns), py = new Float32Array(rows * columns);
  for (let i = 0; i < rows; ++i) {
    for (let j = 0; j < columns; ++j) {
      px[i * columns + j] = x[i] + sheet.v_m[j] * nx[i];
      py[i * columns + j] = y[i] + sheet.v_m[j] * ny[i];
    }
  }
  const z = unpackRows(sheet.z, columns);
  const fields = [];
  if (sheet.fields.length > 0) {
    const elevation = Float32Array.from(z, (value) => value + sheet.z_base_m);
    fields.push({ key: 'elevation', name: 'Elevation', unit: 'm', show: 1, signed: false, categories: [], values: elevation });
  }
  for (const field of sheet.fields) {
    fields.push({
      key: field.key, name: field.name, unit: field.unit, show: field.show_factor, signed: field.signed_scale,
      categories: field.categories, values: unpackRows(field.values, columns),
    });
  }
  return {
    title: sheet.title, rows, columns, x, y, nx, ny, px, py, z, fields, v: sheet.v_m, zBase: sheet.z_base_m,
    uBegin: sheet.u_begin_m, uStep: sheet.u_step_m, uOf: (i) => sheet.u_begin_m + i * sheet.u_step_m,
    rowOf: (u) => Math.min(rows - 1, Math.max(0, Math.round((u - sheet.u_begin_m) / sheet.u_step_m))),
  };
}

/// Heights only: for cuts across the road.
export function unpackDetail(sheet) {
  const columns = sheet.v_m.length, z = unpackRows(sheet.z, columns), rows = columns > 0 ? z.length / columns : 0;
  return {
    rows, columns, z, v: sheet.v_m, zBase: sheet.z_base_m, uBegin: sheet.u_begin_m, uStep: sheet.u_step_m, uOf: (i) => sheet.u_begin_m + i * sheet.u_step_m,
    rowOf: (u) => Math.min(rows - 1, Math.max(0, Math.round((u - sheet.u_begin_m) / sheet.u_step_m))),
  };
}

/// null where uPlot shall leave a gap.
export function withGaps(values, factor = 1) {
  return Array.from(values, (value) => (value === null || Number.isNaN(value) ? null : value * factor));
}

export async function readData() {
  const data = JSON.parse(document.getElementById('report-data').textContent);
  await unpackAll(data);
  for (const { psd } of data.roughness) for (const key of Object.keys(psd)) psd[key] = unpack(psd[key]);
  return data;
}
