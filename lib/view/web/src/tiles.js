// Tiles of a cloud as `lidar2mesh tiles` writes them (docs/formats.md): the index, the bytes of a tile, and which of them a view needs.

const types = { f64: Float64Array, f32: Float32Array, u16: Uint16Array, u8: Uint8Array };
const kMostOfTile = 1e6;
const isPlace = (values) => Array.isArray(values) && values.length === 3 && values.every(Number.isFinite);

/// What the page needs of a tiles.json. Throws where it is none.
export function indexOf(json) {
  const wrong = (what) => { throw new Error(`This tiles.json cannot be used: ${what}. Make the tiles again.`); };
  if (json?.schema !== 1) wrong('schema 1 wanted');
  if (!(Number.isSafeInteger(json.points) && json.points > 0)) wrong('no number of points');
  if (!isPlace(json.most_min_m) || !isPlace(json.most_max_m)) wrong('no bounds');
  if (!Array.isArray(json.fields) || json.fields.some((field) => !types[field?.type] || ![1, 3].includes(field.values))) wrong('fields of an unknown type');
  if (!json.fields.some((field) => field.name === 'xyz_m' && field.type === 'f32' && field.values === 3)) wrong('no places');
  if (!Array.isArray(json.levels) || !(json.levels[0]?.spacing_m > 0)) wrong('no levels');
  if (typeof json.file !== 'string' || json.file.includes('/')) wrong('no file of points');
  if (!Array.isArray(json.tiles) || json.tiles.length === 0) wrong('no tiles');
  const tiles = json.tiles.map((row, k) => {
    if (!Array.isArray(row) || row.length < 12 || !row.every(Number.isFinite) || row[0] < 0 || !(row[2] >= 1 && row[2] <= kMostOfTile)) wrong(`tile ${k} is none`);
    return { key: k, level: row[0], begin: row[1], points: row[2], origin: row.slice(3, 6), min: row.slice(6, 9), max: row.slice(9, 12) };
  });
  return { ...json, tiles };
}

export const bytesOf = (index, tile) => Math.ceil((tile.points * index.fields.reduce((sum, field) => sum + field.values * types[field.type].BYTES_PER_ELEMENT, 0)) / 8) * 8;

/// The byte of the file at which the places of a tile begin.
export function placesOf(index, tile) {
  const before = index.fields.slice(0, index.fields.findIndex((field) => field.name === 'xyz_m'));
  return tile.begin + tile.points * before.reduce((sum, field) => sum + field.values * types[field.type].BYTES_PER_ELEMENT, 0);
}

/// {xyz_m: Float32Array, class: Uint8Array ...} of the bytes of a tile.
export function unpackTile(index, tile, bytes) {
  if (bytes.byteLength !== bytesOf(index, tile)) throw new Error('The points do not belong to this tiles.json. Make the tiles again.');
  const out = {};
  let at = 0;
  for (const { name, type, values } of index.fields) {
    out[name] = new types[type](bytes, at, values * tile.points);
    at += out[name].byteLength;
  }
  return out;
}

/// The tiles that a view needs, the coarsest first, of `most` points at most together (but one tile at least). `view`: `isSeen(min, max)`, `place` of the camera,
/// `pxPerRad`, `finest_px`: closer than this points need not be.
export function wantedTiles(index, view, most) {
  const wanted = [];
  for (const tile of index.tiles) {
    if (!view.isSeen(tile.min, tile.max)) continue;
    const away = Math.hypot(...view.place.map((value, k) => Math.max(tile.min[k] - value, 0, value - tile.max[k])));
    // How far apart, in the picture, points are without this tile.
    const gap_px = tile.level === 0 ? Infinity : (view.pxPerRad * index.levels[0].spacing_m * 2 ** (1 - tile.level)) / Math.max(away, 1e-3);
    if (gap_px > view.finest_px) wanted.push({ tile, gap_px });
  }
  wanted.sort((a, b) => b.gap_px - a.gap_px || a.tile.key - b.tile.key);
  const out = [];
  let sum = 0;
  for (const { tile } of wanted) {
    sum += tile.points;
    if (sum > most && out.length > 0) break;
    out.push(tile);
  }
  return out;
}
