// The road in space: decimated as a whole, in full detail in chosen windows; look around or fly along.
import {
  BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Group, HemisphereLight, Mesh, MeshLambertMaterial,
  PerspectiveCamera, Scene, SphereGeometry, Spherical, MeshBasicMaterial, TOUCH, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { css, el, markRange } from './dom.js';
import { drawsSlowly, fitted } from './drawing.js';
import { scaleOf } from './colour.js';
import { micro } from './format.js';
import { onKeys, onTwoFingers, wheelIsFor } from './gestures.js';
import { saveButtons } from './save.js';

const kMovingTriangles = 60000;

export function makeScene(sheet, windows, data, state) {
  const canvas = el('canvas', { tabindex: 0, role: 'img', 'aria-label': '3-D view: plus, minus, arrows and 0 zoom and turn' });
  // On paper a picture stands for the canvas: browsers print WebGL at its size on the screen.
  const paper = el('img', { alt: '3-D view', decoding: 'sync' });
  const box = el('div', { class: 'canvas scene' }, canvas, paper);
  const exaggeration = el('input', { type: 'range', min: 1, max: 30, step: 1, value: 5, 'aria-label': 'Vertical exaggeration' });
  const exaggerationText = el('span', {}, '5×');
  const detail = el('select', { 'aria-label': 'Full detail' },
    el('option', { value: '' }, 'whole road (decimated)'),
    windows.map((window, k) => el('option', { value: k }, window.title)));
  const fly = el('button', { type: 'button' }, 'Fly along');
  const save = saveButtons('3d', () => {
    render();
    return { canvas, title: `3-D view, height ${vertical}×`, table };
  });
  const tools = el('div', { class: 'tools' },
    el('label', {}, 'Height', exaggeration, exaggerationText), el('label', {}, 'Full detail', detail), fly,
    el('span', {}, 'drag or two fingers: turn · right drag: move · click, then wheel: nearer'));
  const root = el('div', { 'data-view': 'scene' }, tools, box, save);

  const isSlow = drawsSlowly();
  let renderer, isMoving = false;
  try {
    renderer = new WebGLRenderer({ canvas, antialias: !isSlow, preserveDrawingBuffer: true });
  } catch {
    box.replaceChildren(el('p', { class: 'muted', style: 'padding:16px' }, 'The 3-D view needs WebGL, which this browser does not offer. All other views work without it.'));
    root.dataset.webgl = 'none';
    save.remove();
    tools.remove();
    state.subscribe((what) => { if (what === 'range') markRange(root, state.range[0], state.range[1]); });
    markRange(root, state.range[0], state.range[1]);
    return root;
  }
  root.dataset.webgl = 'yes';
  const scene = new Scene();
  const world = new Group();
  scene.add(world);
  const sun = new DirectionalLight(0xffffff, 2.2);
  scene.add(new HemisphereLight(0xffffff, 0x8899aa, 1.3), sun);
  const camera = new PerspectiveCamera(50, 1, 0.5, 20000);
  const controls = new OrbitControls(camera, canvas);
  controls.screenSpacePanning = false;
  controls.maxPolarAngle = 0.495 * Math.PI;
  // One finger scrolls the page, two turn and zoom.
  controls.touches = { ONE: null, TWO: TOUCH.DOLLY_ROTATE };
  canvas.style.touchAction = 'pan-y';
  onTwoFingers(canvas, () => {});
  box.addEventListener('wheel', (event) => { if (!wheelIsFor(canvas, event)) event.stopPropagation(); }, { capture: true, passive: true });
  const marker = new Mesh(new SphereGeometry(1, 16, 12), new MeshBasicMaterial());
  scene.add(marker);
  const material = new MeshLambertMaterial({ vertexColors: true, side: DoubleSide });
  const windowMaterial = new MeshLambertMaterial({ vertexColors: true, side: DoubleSide });
  let vertical = 5, chosen = null, flying = null;
  let pending = true;  // until its size is known: whoever sees that draws first
  let moved = null;  // what changed the range since the last picture

  // Map x, y, z become x, z, -y: three.js has y up.
  function geometryOf(grid, skipBegin, skipEnd) {
    const geometry = new BufferGeometry();
    const position = new Float32Array(3 * grid.z.length);
    for (let k = 0; k < grid.z.length; ++k) {
      position[3 * k] = grid.px[k];
      position[3 * k + 1] = Number.isNaN(grid.z[k]) ? 0 : grid.z[k];
      position[3 * k + 2] = -grid.py[k];
    }
    geometry.setAttribute('position', new BufferAttribute(position, 3));
    geometry.setAttribute('color', new BufferAttribute(new Float32Array(3 * grid.z.length), 3));
    setIndex(geometry, grid, skipBegin, skipEnd);
    geometry.computeVertexNormals();
    return geometry;
  }

  /// Triangles between every node, or every `step`-th one along and across.
  function indexOf(grid, skipBegin, skipEnd, step = 1) {
    const index = [];
    for (let i = 0; i + 1 < grid.rows; i += step) {
      const next = Math.min(i + step, grid.rows - 1);
      if (skipBegin !== undefined && grid.uOf(i) >= skipBegin && grid.uOf(next) <= skipEnd) continue;
      for (let j = 0; j + 1 < grid.columns; j += step) {
        const beside = Math.min(j + step, grid.columns - 1), a = i * grid.columns + j, b = i * grid.columns + beside, c = next * grid.columns + j, d = next * grid.columns + beside;
        if (Number.isNaN(grid.z[a] + grid.z[b] + grid.z[c] + grid.z[d])) continue;
        index.push(a, c, b, b, c, d);
      }
    }
    return new BufferAttribute(new Uint32Array(index), 1);
  }

  /// While it moves, a processor that draws draws fewer triangles.
  function setIndex(geometry, grid, skipBegin, skipEnd) {
    geometry.setIndex(indexOf(grid, skipBegin, skipEnd));
    geometry.userData.fine = geometry.index;
    const step = Math.ceil(Math.sqrt(geometry.index.count / 3 / kMovingTriangles));
    geometry.userData.coarse = isSlow && step > 1 ? indexOf(grid, skipBegin, skipEnd, step) : geometry.index;
  }

  const road = new Mesh(geometryOf(sheet), material);
  world.add(road);
  let windowMesh = null;

  function paint() {
    const field = sheet.fields.find((f) => f.key === state.field) ?? sheet.fields[0];
    const scale = scaleOf(field, field.values.subarray(sheet.rowOf(state.range[0]) * sheet.columns, (sheet.rowOf(state.range[1]) + 1) * sheet.columns));
    const none = new Color(css('--none'));
    const colour = new Color();
    const colours = road.geometry.getAttribute('color');
    const colourOf = (value) => {
      const rgb = scale.of(value);
      if (!rgb) return none;
      return colour.setRGB(rgb[0] / 255, rgb[1] / 255, rgb[2] / 255, 'srgb');
    };
    for (let k = 0; k < sheet.z.length; ++k) {
      const c = colourOf(field.values[k]);
      colours.setXYZ(k, c.r, c.g, c.b);
    }
    colours.needsUpdate = true;
    if (windowMesh) {
      // In full detail the height itself is what one looks for.
      const grid = windows[chosen];
      const heights = { values: grid.z, signed: false, categories: [], show: 1 };
      const windowScale = scaleOf(heights);
      const windowColours = windowMesh.geometry.getAttribute('color');
      for (let k = 0; k < grid.z.length; ++k) {
        const rgb = windowScale.of(grid.z[k]) ?? [0, 0, 0];
        colour.setRGB(rgb[0] / 255, rgb[1] / 255, rgb[2] / 255, 'srgb');
        windowColours.setXYZ(k, colour.r, colour.g, colour.b);
      }
      windowColours.needsUpdate = true;
    }
    scene.background = new Color(css('--bg'));
    marker.material.color.set(css('--cursor'));
    later();
  }

  function choose(k) {
    if (k === chosen) return;
    chosen = k;
    detail.value = k === null ? '' : String(k);
    if (windowMesh) {
      world.remove(windowMesh);
      windowMesh.geometry.dispose();
      windowMesh = null;
    }
    if (k === null) {
      setIndex(road.geometry, sheet);
    } else {
      const grid = windows[k];
      setIndex(road.geometry, sheet, grid.uBegin, grid.uOf(grid.rows - 1));
      windowMesh = new Mesh(geometryOf(grid), windowMaterial);
      world.add(windowMesh);
    }
    paint();
  }

  function pointAt(u, target = new Vector3()) {
    const i = sheet.rowOf(u);
    let j = Math.max(0, sheet.v.findIndex((v) => v >= 0));
    if (Number.isNaN(sheet.z[i * sheet.columns + j])) {
      for (let k = 0; k < sheet.columns; ++k) if (!Number.isNaN(sheet.z[i * sheet.columns + k])) { j = k; break; }
    }
    const k = i * sheet.columns + j;
    return target.set(sheet.px[k], vertical * (Number.isNaN(sheet.z[k]) ? 0 : sheet.z[k]), -sheet.py[k]);
  }

  function headingAt(u) {
    const a = pointAt(Math.max(state.uBegin, u - 2)), b = pointAt(Math.min(state.uEnd, u + 2));
    return b.sub(a).setY(0).normalize();
  }

  function frame() {
    const whole = state.range[1] - state.range[0] > 0.98 * (state.uEnd - state.uBegin);
    const first = sheet.rowOf(state.range[0]), last = sheet.rowOf(state.range[1]);
    const low = new Vector3(Infinity, Infinity, Infinity), high = new Vector3(-Infinity, -Infinity, -Infinity);
    for (let k = first * sheet.columns; k < (last + 1) * sheet.columns; k += 3) {
      if (Number.isNaN(sheet.z[k])) continue;
      const p = new Vector3(sheet.px[k], vertical * sheet.z[k], -sheet.py[k]);
      low.min(p);
      high.max(p);
    }
    if (!(low.x <= high.x)) { low.copy(pointAt(state.range[0])); high.copy(pointAt(state.range[1])); }
    const middle = low.clone().add(high).multiplyScalar(0.5);
    if (whole) {
      const wide = Math.max(high.x - low.x, (high.z - low.z) * 1.2, 20);
      const distance = (0.62 * wide) / Math.tan((camera.fov * Math.PI) / 360) / Math.max(1, Math.min(camera.aspect, 1.9));
      controls.target.copy(middle);
      camera.position.set(middle.x, middle.y + 0.75 * distance, middle.z + 0.66 * distance);
    } else {
      const u = 0.5 * (state.range[0] + state.range[1]);
      const target = pointAt(u), ahead = headingAt(u);
      const distance = Math.max(14, 0.55 * (state.range[1] - state.range[0]));
      controls.target.copy(target);
      camera.position.copy(target).addScaledVector(ahead, -distance).add(new Vector3(0, 0.45 * distance, 0));
    }
    const size = high.clone().sub(low).length();
    camera.near = Math.max(0.2, 0.0005 * size);
    camera.far = 20 * Math.max(size, 500);
    camera.updateProjectionMatrix();
    sun.position.set(middle.x - 500, middle.y + 800, middle.z - 300);
    sun.target.position.copy(middle);
    sun.target.updateMatrixWorld();
    controls.update();
    markRange(root, state.range[0], state.range[1]);
  }

  /// Follows the range that is looked at; once a picture, however often it changed.
  function follow() {
    if (moved !== 'scene-detail') {
      // The window of full detail that holds the middle of what is looked at, if that is close enough.
      const middle = 0.5 * (state.range[0] + state.range[1]);
      const near = state.range[1] - state.range[0] < 120
        ? windows.findIndex((w) => middle >= w.uBegin && middle <= w.uOf(w.rows - 1)) : -1;
      choose(near < 0 ? null : near);
    }
    moved = null;
    paint();
    frame();
  }

  function render() {
    if (moved !== null) follow();
    pending = false;
    world.scale.set(1, vertical, 1);
    marker.visible = state.cursor !== null;
    if (marker.visible) {
      pointAt(state.cursor, marker.position);
      const size = 0.008 * camera.position.distanceTo(marker.position);
      marker.scale.setScalar(Math.max(0.15, size));
    }
    const isCoarse = isSlow && (isMoving || flying !== null);
    fitted(renderer, box, isCoarse);
    for (const mesh of [road, windowMesh]) if (mesh) mesh.geometry.setIndex(mesh.geometry.userData[isCoarse ? 'coarse' : 'fine']);
    renderer.render(scene, camera);
  }

  function later() {
    if (pending) return;
    pending = true;
    // Not where it has been drawn meanwhile.
    requestAnimationFrame(() => { if (pending) render(); });
  }

  function resize() {
    fitted(renderer, box, false);
    camera.aspect = (box.clientWidth || 1) / (box.clientHeight || 1);
    camera.updateProjectionMatrix();
  }

  /// The nodes of the range that is looked at, in full detail where that is shown.
  function table() {
    const grid = chosen === null ? sheet : windows[chosen], rows = [];
    for (let i = grid.rowOf(state.range[0]); i <= grid.rowOf(state.range[1]); ++i) {
      for (let j = 0; j < grid.columns; ++j) {
        const k = i * grid.columns + j;
        if (!Number.isNaN(grid.z[k])) rows.push([grid.uOf(i), grid.v[j], grid.px[k] + data.x_base_m, grid.py[k] + data.y_base_m, grid.z[k] + grid.zBase].map(micro));
      }
    }
    return { heads: ['u / m', 'v / m', 'x / m', 'y / m', 'z / m'], rows };
  }

  onKeys(canvas, (wish) => {
    stopFlying();
    const from = camera.position.clone().sub(controls.target);
    if (wish.reset) {
      state.reset();
      return true;
    }
    const at = new Spherical().setFromVector3(from);
    if (wish.zoom) at.radius /= wish.zoom;
    else { at.theta += 0.15 * wish.dx; at.phi = Math.min(controls.maxPolarAngle, Math.max(0.02, at.phi - 0.1 * wish.dy)); }
    camera.position.copy(controls.target).add(from.setFromSpherical(at));
    controls.update();
    later();
    return true;
  });

  function stopFlying() {
    flying = null;
    fly.textContent = 'Fly along';
  }

  function step(now) {
    if (!flying) return;
    const u = flying.u + ((now - flying.at) / 1000) * 30;
    flying = { u: u > state.uEnd ? state.uBegin : u, at: now };
    const target = pointAt(flying.u), ahead = headingAt(flying.u);
    camera.position.copy(target).addScaledVector(ahead, -14).add(new Vector3(0, 5, 0));
    controls.target.copy(target).addScaledVector(ahead, 12);
    controls.update();
    state.setCursor(flying.u, 'scene');
    requestAnimationFrame(step);
  }

  fly.addEventListener('click', () => {
    if (flying) { stopFlying(); return; }
    flying = { u: state.cursor ?? state.range[0], at: performance.now() };
    fly.textContent = 'Stop';
    requestAnimationFrame(step);
  });
  exaggeration.addEventListener('input', () => {
    vertical = Number(exaggeration.value);
    exaggerationText.textContent = `${vertical}×`;
    frame();
    later();
  });
  detail.addEventListener('change', () => {
    if (detail.value === '') { choose(null); state.reset(); return; }
    const grid = windows[Number(detail.value)];
    choose(Number(detail.value));
    state.setRange(grid.uBegin, grid.uOf(grid.rows - 1), 'scene-detail');
  });
  controls.addEventListener('change', later);
  controls.addEventListener('start', () => { isMoving = true; });
  controls.addEventListener('end', () => { isMoving = false; later(); });
  canvas.addEventListener('pointerdown', stopFlying);
  state.subscribe((what, source) => {
    if (what === 'range') {
      stopFlying();
      moved = source;
    }
    if (what === 'field' || what === 'theme') paint();
    if (what === 'print') { resize(); frame(); paint(); render(); paper.src = canvas.toDataURL(); return; }
    later();
  });
  new ResizeObserver(() => { resize(); frame(); render(); }).observe(box);
  paint();
  return root;
}
