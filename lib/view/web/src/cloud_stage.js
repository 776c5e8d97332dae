// A cloud in space: tiles as the view needs them, drawn as points; by mouse as the other view, by keyboard flown.
import {
  Box3, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Frustum, Group, HemisphereLight, LinearSRGBColorSpace, Matrix4, Mesh, MeshLambertMaterial, PerspectiveCamera, Points, PointsMaterial, Scene,
  Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { css, el } from '../../../report/web/src/dom.js';
import { drawsSlowly, fitted } from '../../../report/web/src/drawing.js';
import { roadGeometry } from './road_mesh.js';
import { unpackTile, wantedTiles } from './tiles.js';

const kAtOnce = 4, kClick_px = 5, kReach_px = 8, kMoving_points = 150000;

/// `fetchTile(tile)` resolves to its bytes; `addTo(data, tile)` resolves when what is known of its points besides has been added; `colourOf(data, k, rgb)` writes the colour of a point, 0 to 255; `told({drawn, waiting})` after each picture;
/// `picked({x_m, y_m, z_m, data, k})` or null; `moved()` when the view has come to rest; `failed(error)`.
export function makeCloudStage({ fetchTile, addTo, colourOf, told, picked, moved, failed }) {
  const canvas = el('canvas', { tabindex: 0, role: 'application', 'aria-label': 'Scan: arrows or W A S D fly, with Shift they turn, plus and minus zoom, 0 shows all, Enter reads the point in the middle' });
  const box = el('div', { class: 'stage', 'data-view': 'cloud' }, canvas);
  const isSlow = drawsSlowly();
  let renderer;
  try {
    renderer = new WebGLRenderer({ canvas, antialias: false, preserveDrawingBuffer: true });
  } catch {
    box.replaceChildren(el('p', { class: 'muted', style: 'padding:16px' }, 'This view needs WebGL, which this browser does not offer.'));
    return { box, isSlow, open() {}, clear() {}, redraw() {}, recolour() {}, fit() {}, above() {}, state: () => null, restore() {}, refresh() {}, setRoad() {}, picture: () => null, shown: () => [], limits: {} };
  }
  renderer.outputColorSpace = LinearSRGBColorSpace;  // colours are bytes of the screen; nothing is lit
  const scene = new Scene(), world = new Group(), camera = new PerspectiveCamera(50, 1, 0.5, 60000);
  const sun = new DirectionalLight(0xffffff, 1.2);
  sun.position.set(-1, -0.6, 2);
  scene.add(world, new HemisphereLight(0xffffff, 0x808890, 1.4), sun);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, canvas);
  controls.zoomToCursor = true;
  controls.maxPolarAngle = 0.495 * Math.PI;
  const material = new PointsMaterial({ size: 2, sizeAttenuation: false, vertexColors: true });
  const limits = { most: 1e6, finest_px: 1.5 };
  let index = null, origin = [0, 0, 0], reach = 100, isLong = true, wanted = false, isMoving = false, rest = null, opened = 0, loading = 0;
  let road = null;  // {packed, mesh}
  const held = new Map();  // key of a tile -> {tile, data, points}, those used last at the end
  const busy = new Set();  // keys of tiles that are being fetched

  const from = (place) => place.map((value, k) => value - origin[k]);
  function paint({ data, points }) {
    const colours = points.geometry.getAttribute('color'), rgb = [0, 0, 0];
    for (let k = 0; k < colours.count; ++k) {
      colourOf(data, k, rgb);
      colours.array.set(rgb, 3 * k);
    }
    colours.needsUpdate = true;
  }

  function drop(each) {
    world.remove(each.points);
    each.points.geometry.dispose();
    held.delete(each.tile.key);
  }

  async function load(tile) {
    const of = opened;
    ++loading;
    try {
      const data = unpackTile(index, tile, await fetchTile(tile));
      await addTo(data, tile);
      if (of !== opened) return;
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(data.xyz_m, 3));
      geometry.setAttribute('color', new BufferAttribute(new Uint8Array(3 * tile.points), 3, true));
      delete data.time_s;  // not shown
      data.origin = tile.origin;
      const points = new Points(geometry, material);
      points.position.set(...from(tile.origin));
      points.frustumCulled = points.visible = false;
      world.add(points);
      held.set(tile.key, { tile, data, points });
      paint(held.get(tile.key));
    } catch (error) {
      if (of === opened) { stage.clear(); failed(error); }
    } finally {
      --loading;
      redraw();
    }
  }

  /// Shows the tiles of this view that are there, begins to fetch those that are not, drops what was not used for long.
  function choose(height) {
    const frustum = new Frustum().setFromProjectionMatrix(new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse)), bounds = new Box3();
    const view = {
      isSeen: (min, max) => frustum.intersectsBox(bounds.set(new Vector3(...from(min)), new Vector3(...from(max)))),
      place: camera.position.toArray().map((value, k) => value + origin[k]),
      pxPerRad: height / (2 * Math.tan((camera.fov * Math.PI) / 360)), finest_px: limits.finest_px,
    };
    const most = isMoving && isSlow ? Math.min(kMoving_points, limits.most) : limits.most, tiles = wantedTiles(index, view, most);
    for (const each of held.values()) each.points.visible = false;
    let drawn = 0, waiting = 0, kept = 0;
    for (const tile of tiles) {
      const each = held.get(tile.key);
      if (!each) {
        ++waiting;
        if (loading < kAtOnce && !busy.has(tile.key)) { busy.add(tile.key); load(tile).finally(() => busy.delete(tile.key)); }
        continue;
      }
      each.points.visible = true;
      drawn += tile.points;
      held.delete(tile.key);
      held.set(tile.key, each);
    }
    for (const each of held.values()) kept += each.tile.points;
    for (const each of [...held.values()]) {
      if (kept <= 2 * limits.most || each.points.visible) continue;
      kept -= each.tile.points;
      drop(each);
    }
    return { drawn, waiting, tiles: tiles.length - waiting };
  }

  function draw() {
    wanted = false;
    const size = fitted(renderer, box, isMoving && isSlow);
    if (!size) return;
    const { width, height, ratio } = size;
    const away = camera.position.distanceTo(controls.target);
    Object.assign(camera, { aspect: width / height, near: Math.max(0.05, away / 500), far: 20 * Math.max(away, reach) });
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    renderer.setClearColor(new Color().setStyle(css('--bg'), LinearSRGBColorSpace));
    const { drawn, waiting, tiles } = index ? choose(height * ratio) : { drawn: 0, waiting: 0, tiles: 0 };
    renderer.render(scene, camera);
    Object.assign(box.dataset, { points: drawn, tiles, waiting, drawn: Number(box.dataset.drawn ?? 0) + 1, camera: cameraText() });
    told({ drawn, waiting });
  }
  const redraw = () => { if (!wanted) { wanted = true; requestAnimationFrame(draw); } };
  const cameraText = () => camera.position.toArray().map((value) => value.toFixed(2)).join(' ');
  const settle = () => {
    clearTimeout(rest);
    delete box.dataset.rest;
    rest = setTimeout(() => { box.dataset.rest = cameraText(); moved(); }, 400);
  };
  controls.addEventListener('change', () => { redraw(); settle(); });
  controls.addEventListener('start', () => { isMoving = true; });
  controls.addEventListener('end', () => { isMoving = false; redraw(); });
  new ResizeObserver(redraw).observe(box);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);

  function lookFrom(x, y, z) {
    controls.target.set(0, 0, 0);
    camera.position.set(x, y, z);
    controls.update();
    redraw();
  }

  /// Of the points in view the one that lies nearest to this place of the picture.
  function pick(px, py) {
    const { clientWidth: width, clientHeight: height } = box, matrix = new Matrix4(), away = camera.position.distanceTo(controls.target);
    let best = null, least = kReach_px;
    for (const { tile, data, points } of held.values()) {
      if (!points.visible) continue;
      points.updateMatrixWorld();
      const m = matrix.copy(camera.matrixWorldInverse).multiply(points.matrixWorld).premultiply(camera.projectionMatrix).elements, at = data.xyz_m;
      for (let k = 0; k < tile.points; ++k) {
        const x = at[3 * k], y = at[3 * k + 1], z = at[3 * k + 2], w = m[3] * x + m[7] * y + m[11] * z + m[15];
        if (w <= 0) continue;
        const far = Math.hypot(((m[0] * x + m[4] * y + m[8] * z + m[12]) / w + 1) * 0.5 * width - px, (1 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / w) * 0.5 * height - py);
        if (far + w / away < least) {  // of two at about the same place the nearer one
          least = far + w / away;
          best = { x_m: tile.origin[0] + x, y_m: tile.origin[1] + y, z_m: tile.origin[2] + z, data, k };
        }
      }
    }
    picked(best);
  }
  let down = null;
  canvas.addEventListener('pointerdown', (event) => { down = event.isPrimary && event.button === 0 ? [event.offsetX, event.offsetY] : null; });
  canvas.addEventListener('pointerup', (event) => {
    if (down && Math.hypot(event.offsetX - down[0], event.offsetY - down[1]) < kClick_px) pick(event.offsetX, event.offsetY);
    down = null;
  });

  const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1], a: [-1, 0], d: [1, 0], w: [0, 1], s: [0, -1] };
  canvas.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const way = ways[event.key.length === 1 ? event.key.toLowerCase() : event.key], arm = camera.position.clone().sub(controls.target);
    if (way && event.shiftKey) {
      const level = Math.hypot(arm.x, arm.y), yaw = Math.atan2(arm.y, arm.x) + 0.08 * way[0], pitch = Math.min(1.55, Math.max(0.02, Math.atan2(arm.z, level) + 0.08 * way[1])), far = arm.length();
      camera.position.copy(controls.target).add(new Vector3(far * Math.cos(pitch) * Math.cos(yaw), far * Math.cos(pitch) * Math.sin(yaw), far * Math.sin(pitch)));
    } else if (way) {
      const step = 0.06 * arm.length(), right = new Vector3(1, 0, 0).applyQuaternion(camera.quaternion).setZ(0).normalize(), ahead = new Vector3(-right.y, right.x, 0);
      for (const each of [camera.position, controls.target]) each.addScaledVector(right, step * way[0]).addScaledVector(ahead, step * way[1]);
    } else if (event.key === '+' || event.key === '-') camera.position.lerp(controls.target, 1 - (event.key === '+' ? 0.8 : 1.25));
    else if (event.key === '0') { stage.fit(); settle(); }
    else if (event.key === 'Enter') pick(0.5 * box.clientWidth, 0.5 * box.clientHeight);
    else return;
    event.preventDefault();
    controls.update();
    redraw();
    settle();
  });

  /// The road, once it is known where the picture's origin is.
  function layRoad() {
    if (road?.mesh) world.remove(road.mesh);
    if (road && index) {
      road.mesh?.geometry.dispose();
      road.mesh = new Mesh(roadGeometry(road.packed, origin), new MeshLambertMaterial({ color: 0xc4c8cc, side: DoubleSide, depthWrite: false }));
      road.mesh.renderOrder = -1;
      world.add(road.mesh);
      box.dataset.road = road.mesh.geometry.index.count / 3;
    }
    redraw();
  }

  const stage = {
    box, isSlow, limits, redraw,
    clear() {
      stage.refresh();
      index = null;
    },
    /// All points are fetched again, as they are needed.
    refresh() {
      ++opened;
      for (const each of [...held.values()]) drop(each);
      redraw();
    },
    /// A road (getPacked('road')) below the points; null: none. All points are drawn over it, those below its surface too.
    setRoad(packed) {
      if (road?.mesh) {
        world.remove(road.mesh);
        road.mesh.geometry.dispose();
        road.mesh.material.dispose();
      }
      road = packed ? { packed } : null;
      delete box.dataset.road;
      layRoad();
    },
    /// What is known of the points that are drawn, tile by tile.
    shown: () => [...held.values()].filter((each) => each.points.visible).map((each) => each.data),
    /// The picture as it is now, for saving.
    picture() {
      draw();
      return canvas;
    },
    open(next) {
      stage.clear();
      index = next;
      origin = next.most_min_m.map((low, k) => Math.round(0.5 * (low + next.most_max_m[k])));
      const size = next.most_min_m.map((low, k) => next.most_max_m[k] - low);
      reach = Math.max(2, ...size);
      isLong = size[0] > size[1];
      layRoad();
      stage.fit();
    },
    recolour() {
      for (const each of held.values()) paint(each);
      redraw();
    },
    /// From the side of the cloud that is longer.
    fit() {
      const far = (1.25 * reach) / Math.min(1, box.clientWidth / Math.max(1, box.clientHeight)), [along, across] = [-0.3 * far, -0.9 * far];
      lookFrom(isLong ? along : across, isLong ? across : along, 0.6 * far);
    },
    above: () => lookFrom(0, -1e-3 * reach, (1.2 * reach) / Math.min(1, box.clientWidth / Math.max(1, box.clientHeight))),
    /// Where the camera is and what it looks at, in map metres.
    state: () => (index ? [...camera.position.toArray(), ...controls.target.toArray()].map((value, k) => Number((value + origin[k % 3]).toFixed(3))) : null),
    restore(places) {
      camera.position.set(...from(places.slice(0, 3)));
      controls.target.set(...from(places.slice(3, 6)));
      controls.update();
      redraw();
    },
  };
  return stage;
}
