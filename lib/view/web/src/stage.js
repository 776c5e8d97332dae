// The mesh and what is made of it, from above or in space; a place is picked by click, or by arrows and Enter.
import {
  BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, EdgesGeometry, Group, HemisphereLight, Line, LineBasicMaterial, LineSegments,
  Mesh, MeshLambertMaterial, MOUSE, OrthographicCamera, PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, TOUCH, Vector2, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { css, el } from '../../../report/web/src/dom.js';
import { drawsSlowly, fitted } from '../../../report/web/src/drawing.js';

export const classColours = { road: '#6a7077', kerb: '#d0492e', runoff: '#69a04a', barrier: '#d9b13c', scenery: '#a9b6c4', unknown: '#b0b0b0' };

const partMaterial = (kind) => new MeshLambertMaterial({ color: classColours[kind] ?? classColours.unknown, side: DoubleSide });

const kClick_px = 5;  // a drag is further

/// `picked({x_m, y_m, z_m, part})`: map metres; z_m and part are null beside the mesh. `moved()`: the view has come to rest.
export function makeStage(picked, moved = () => {}) {
  const canvas = el('canvas', { tabindex: 0, role: 'application', 'aria-label': 'Track: arrows move the cross, Enter picks the place under it, plus and minus zoom, 0 shows all' });
  const cross = el('div', { 'aria-hidden': 'true', style: 'position:absolute;pointer-events:none;left:50%;top:50%;width:21px;height:21px;margin:-10px;display:none;background:linear-gradient(var(--cursor),var(--cursor)) 10px 0/1px 21px no-repeat,linear-gradient(var(--cursor),var(--cursor)) 0 10px/21px 1px no-repeat' });
  const where = el('div', { class: 'muted small', 'data-role': 'where', style: 'position:absolute;left:8px;bottom:4px;pointer-events:none;font-variant-numeric:tabular-nums;background:var(--panel);border-radius:4px;padding:0 6px' });
  const box = el('div', { class: 'stage', 'data-view': 'stage' }, canvas, cross, where);
  const isSlow = drawsSlowly();
  let renderer;
  try {
    renderer = new WebGLRenderer({ canvas, antialias: !isSlow, preserveDrawingBuffer: true });
  } catch {
    box.replaceChildren(el('p', { class: 'muted', style: 'padding:16px' }, 'This view needs WebGL, which this browser does not offer. Places can be typed below.'));
    return { box, clear() {}, redraw() {}, prepare() {}, setMesh: async () => null, setRoad() {}, setZones() {}, heightAt: () => null, seenAt: () => [0, 0], setMarks() {}, setBrush() {}, highlight() {}, setPlan() {}, fit() {}, state: () => null, restore() {}, picture: () => null, origin: new Vector3(), parts: [] };
  }
  const scene = new Scene(), world = new Group(), marks = new Group(), road = new Group(), zones = new Group();
  scene.add(new HemisphereLight(0xffffff, 0x9aa4ae, 2.4), world, road, zones, marks);
  const sun = new DirectionalLight(0xffffff, 1.6);
  sun.position.set(-1, -0.6, 2);
  scene.add(sun);
  const flat = new OrthographicCamera(-1, 1, 1, -1, -1e5, 1e5), round = new PerspectiveCamera(50, 1, 0.5, 60000);
  for (const camera of [flat, round]) camera.up.set(0, 0, 1);
  flat.up.set(0, 1, 0);
  const flatControls = new OrbitControls(flat, canvas), roundControls = new OrbitControls(round, canvas);
  flatControls.enableRotate = false;
  flatControls.screenSpacePanning = true;
  flatControls.mouseButtons = { LEFT: MOUSE.PAN, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN };
  flatControls.touches = { ONE: TOUCH.PAN, TWO: TOUCH.DOLLY_PAN };
  flatControls.zoomToCursor = roundControls.zoomToCursor = true;
  roundControls.maxPolarAngle = 0.495 * Math.PI;
  let isPlan = true, wanted = false, isMoving = false, centre = new Vector3(), reach = 100, extent = [100, 100], lit = null;
  const stage = { box, origin: new Vector3(), parts: [] };
  const camera = () => (isPlan ? flat : round), controls = () => (isPlan ? flatControls : roundControls);

  function draw() {
    wanted = false;
    const size = fitted(renderer, box, isMoving && isSlow);
    if (!size) return;
    const { width, height } = size;
    const aspect = width / height, half = Math.max(extent[1], extent[0] / aspect);
    Object.assign(flat, { left: -half * aspect, right: half * aspect, top: half, bottom: -half });
    round.aspect = aspect;
    flat.updateProjectionMatrix();
    round.updateProjectionMatrix();
    renderer.setClearColor(new Color(css('--bg')));
    renderer.render(scene, camera());
    box.dataset.drawn = String(Number(box.dataset.drawn ?? 0) + 1);
  }
  const redraw = () => { if (!wanted) { wanted = true; requestAnimationFrame(draw); } };
  let rest = null;
  const settle = () => { clearTimeout(rest); rest = setTimeout(moved, 400); };
  for (const each of [flatControls, roundControls]) {
    each.addEventListener('change', redraw);
    each.addEventListener('start', () => { isMoving = true; });
    each.addEventListener('end', () => { isMoving = false; redraw(); settle(); });
  }
  new ResizeObserver(redraw).observe(box);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);

  stage.redraw = redraw;
  stage.fit = () => {
    flat.zoom = 1;
    flat.position.set(centre.x, centre.y, centre.z + 1000);
    flatControls.target.copy(centre);
    round.position.set(centre.x - 0.9 * reach, centre.y - 1.3 * reach, centre.z + 1.1 * reach);
    roundControls.target.copy(centre);
    for (const each of [flatControls, roundControls]) each.update();
    redraw();
  };
  stage.setPlan = (plan) => {
    isPlan = plan;
    flatControls.enabled = plan;
    roundControls.enabled = !plan;
    redraw();
  };
  stage.setPlan(true);

  /// What is looked at, in map metres: 'plan', x, y of the middle and the zoom; or '3d', where the camera is and what it looks at.
  stage.state = () => {
    const map = (place) => place.toArray().map((value, k) => Number((value + stage.origin.getComponent(k)).toFixed(2)));
    return isPlan ? ['plan', ...map(flatControls.target).slice(0, 2), Number(flat.zoom.toFixed(4))] : ['3d', ...map(round.position), ...map(roundControls.target)];
  };
  /// False where these are no numbers of a view.
  stage.restore = ([kind, ...values]) => {
    const numbers = values.map(Number), place = (from) => new Vector3(...numbers.slice(from, from + 3)).sub(stage.origin);
    if (!numbers.every(Number.isFinite) || numbers.length !== (kind === 'plan' ? 3 : 6) || !['plan', '3d'].includes(kind)) return false;
    if (kind === 'plan') {
      if (!(numbers[2] > 0)) return false;
      flat.zoom = numbers[2];
      flatControls.target.set(numbers[0] - stage.origin.x, numbers[1] - stage.origin.y, centre.z);
      flat.position.set(flatControls.target.x, flatControls.target.y, centre.z + 1000);
    } else {
      round.position.copy(place(0));
      roundControls.target.copy(place(3));
    }
    stage.setPlan(kind === 'plan');
    controls().update();
    return true;
  };
  /// Has the program of the graphics card made before the first mesh comes: where the processor draws that takes as long as the picture itself.
  let pattern = null;
  stage.prepare = () => {
    if (pattern) return;
    const geometry = new BufferGeometry().setFromPoints([new Vector3(), new Vector3(1, 0, 0), new Vector3(0, 1, 0)]);
    geometry.computeVertexNormals();
    pattern = new Mesh(geometry, partMaterial('unknown'));
    scene.add(pattern);
    draw();
    pattern.visible = false;  // the program lives as long as its material
    redraw();
  };
  /// The picture as it is now, for saving.
  stage.picture = () => { draw(); return canvas; };

  const free = (group) => { for (const child of [...group.children]) { child.geometry.dispose(); child.material.dispose(); group.remove(child); } };

  stage.clear = () => {
    free(world);
    stage.parts = [];
    lit = null;
    delete box.dataset.parts;
    redraw();
  };

  /// Shows what `crgbuild preview` gave; resolves to what it tells of the mesh. null: no longer wanted when it was read.
  stage.setMesh = async (glb, isWanted = () => true) => {
    const gltf = await new GLTFLoader().parseAsync(glb, '');
    if (!isWanted()) return null;
    stage.clear();
    const told = gltf.scene.userData;
    stage.origin = new Vector3(...told.origin_m);
    const box3 = { low: new Vector3(Infinity, Infinity, Infinity), high: new Vector3(-Infinity, -Infinity, -Infinity) };
    gltf.scene.traverse((node) => {
      if (!node.isMesh) return;
      const geometry = node.geometry;
      geometry.computeVertexNormals();
      geometry.computeBoundingBox();
      const part = { ...node.userData, ...told.objects[node.userData.object] };
      const mesh = new Mesh(geometry, partMaterial(part.class));
      mesh.userData.part = part;
      part.mesh = mesh;
      stage.parts.push(part);
      world.add(mesh);
      // The road, where there is one, fills the view; the horizon does not.
      if (told.told_by === '' || ['road', 'kerb'].includes(part.class)) {
        box3.low.min(geometry.boundingBox.min);
        box3.high.max(geometry.boundingBox.max);
      }
    });
    centre = box3.low.clone().add(box3.high).multiplyScalar(0.5);
    extent = [box3.high.x - box3.low.x, box3.high.y - box3.low.y].map((size) => Math.max(5, 0.55 * size));
    reach = Math.max(...extent);
    stage.fit();
    box.dataset.parts = stage.parts.length;
    return told;
  };

  stage.highlight = (part) => {
    if (lit) world.remove(lit);
    lit = null;
    if (part?.mesh) {
      lit = new LineSegments(new EdgesGeometry(part.mesh.geometry, 30), new LineBasicMaterial({ color: css('--cursor') }));
      lit.renderOrder = 3;
      world.add(lit);
    }
    redraw();
  };

  const local = (x, y, z) => new Vector3(x - stage.origin.x, y - stage.origin.y, z - stage.origin.z);
  function drawLine(group, points, colour) {
    const geometry = new BufferGeometry().setFromPoints(points);
    const line = new Line(geometry, new LineBasicMaterial({ color: colour, depthTest: false }));
    line.renderOrder = 2;
    group.add(line);
  }

  /// Edges and line of a road file (getPacked('road')); null: none.
  stage.setRoad = (packed) => {
    free(road);
    if (packed) {
      const { columns } = packed.head, middle = Math.floor(columns / 2);
      const z = (i) => {
        for (let k = 0; k < columns; ++k) {
          const at = packed.z_m[i * columns + ((middle + k) % columns)];
          if (!Number.isNaN(at)) return at + 0.3;
        }
        return stage.origin.z;
      };
      for (const [x, y, colour] of [[packed.x_m, packed.y_m, css('--accent')], [packed.left_x_m, packed.left_y_m, css('--s2')], [packed.right_x_m, packed.right_y_m, css('--s2')]]) {
        const points = [];
        for (let i = 0; i < packed.head.rows; ++i) if (!Number.isNaN(x[i])) points.push(local(x[i], y[i], z(i)));
        drawLine(road, points, colour);
      }
      if (packed.head.rows > 3) {  // the beginning, and which way it goes
        const begin = local(packed.x_m[0], packed.y_m[0], z(0)), ahead = local(packed.x_m[1], packed.y_m[1], z(0)).sub(begin).setZ(0).normalize(), size = reach / 25;
        const side = new Vector3(-ahead.y, ahead.x, 0);
        const tip = begin.clone().addScaledVector(ahead, 2 * size);
        drawLine(road, [begin.clone().addScaledVector(side, size), begin.clone().addScaledVector(side, -size), begin, tip,
          tip.clone().addScaledVector(ahead, -0.7 * size).addScaledVector(side, 0.5 * size), tip, tip.clone().addScaledVector(ahead, -0.7 * size).addScaledVector(side, -0.5 * size)], css('--accent'));
      }
    }
    redraw();
  };

  /// Outlines over the road: [{points: [[x, y], ...], colour: '--name'}] in map metres.
  stage.setZones = (outlines) => {
    free(zones);
    for (const { points, colour } of outlines)
      if (points.length > 1) drawLine(zones, points.map(([x, y]) => local(x, y, centre.z + stage.origin.z + 2)), css(colour));
    box.dataset.zones = outlines.length;
    redraw();
  };

  /// Where a place of the map is seen: -1 to 1 to the right and upwards, more where it is not.
  stage.seenAt = (x, y) => {
    camera().updateMatrixWorld();
    const at = local(x, y, centre.z + stage.origin.z).project(camera());
    return Math.abs(at.z) > 1 ? [2, 2] : [at.x, at.y];
  };

  /// Height of the mesh at a place seen from above, of its road where there is one; null: nothing lies there.
  stage.heightAt = (x, y) => {
    raycaster.set(new Vector3(x - stage.origin.x, y - stage.origin.y, 1e4), new Vector3(0, 0, -1));
    const hits = raycaster.intersectObjects(world.children.filter((child) => child.isMesh), false);
    const hit = hits.find(({ object }) => ['road', 'kerb'].includes(object.userData.part.class)) ?? hits[0];
    return hit ? hit.point.z + stage.origin.z : null;
  };

  /// Points that were set, joined where `joined`: [[x, y], ...] in map metres.
  stage.setMarks = (points, joined) => {
    free(marks);
    const top = Math.max(...stage.parts.map((part) => part.mesh.geometry.boundingBox.max.z), 0);
    const spots = points.map(([x, y]) => { const p = local(x, y, 0); p.z = isPlan ? top : centre.z + 2; return p; });
    if (spots.length > 0) {
      const dots = new Points(new BufferGeometry().setFromPoints(spots), new PointsMaterial({ color: css('--cursor'), size: 9, sizeAttenuation: false, depthTest: false }));
      dots.renderOrder = 4;
      marks.add(dots);
      if (joined && spots.length > 1) drawLine(marks, spots, css('--cursor'));
    }
    redraw();
  };

  const raycaster = new Raycaster();
  function placeAt(px, py) {
    const ndc = new Vector2((2 * px) / box.clientWidth - 1, 1 - (2 * py) / box.clientHeight);
    camera().updateMatrixWorld();
    raycaster.setFromCamera(ndc, camera());
    if (isPlan) raycaster.ray.origin.z = 1e4;
    const hits = raycaster.intersectObjects(world.children.filter((child) => child.isMesh), false);
    // From above: a road below a bridge or a tree line is what is meant, where there is one.
    const hit = isPlan ? hits.find(({ object }) => ['road', 'kerb'].includes(object.userData.part.class)) ?? hits[0] : hits[0];
    if (hit) return { x_m: hit.point.x + stage.origin.x, y_m: hit.point.y + stage.origin.y, z_m: hit.point.z + stage.origin.z, part: hit.object.userData.part };
    if (!isPlan) return null;
    const at = new Vector3(ndc.x, ndc.y, 0).unproject(flat);
    return { x_m: at.x + stage.origin.x, y_m: at.y + stage.origin.y, z_m: null, part: null };
  }
  const say = (place) => { where.textContent = place ? `x ${place.x_m.toFixed(1)} m, y ${place.y_m.toFixed(1)} m${place.z_m === null ? '' : `, z ${place.z_m.toFixed(2)} m`}${place.part ? ` · ${place.part.name || 'nameless'} (${place.part.class})` : ''}` : ''; };
  const pick = (px, py) => {
    const place = placeAt(px, py);
    say(place);
    if (place) picked(place);
  };
  let down = null, stroke = null, brush = null;
  /// A drag by the first button or a finger then paints instead of moving the view: `next(points)` gets [[x, y], ...] in map metres; null: it moves again.
  stage.setBrush = (next) => {
    brush = next;
    stroke = null;
    flatControls.mouseButtons.LEFT = next ? null : MOUSE.PAN;
    roundControls.mouseButtons.LEFT = next ? null : MOUSE.ROTATE;
    flatControls.touches.ONE = next ? null : TOUCH.PAN;
    roundControls.touches.ONE = next ? null : TOUCH.ROTATE;
  };
  const paint = (event) => {
    const place = placeAt(event.offsetX, event.offsetY);
    if (place) stroke.push([place.x_m, place.y_m]);
    stage.setMarks(stroke, true);
  };
  canvas.addEventListener('pointermove', (event) => { if (stroke && event.isPrimary) paint(event); });
  canvas.addEventListener('pointerdown', (event) => { down = event.isPrimary && event.button === 0 ? [event.offsetX, event.offsetY] : null; stroke = null; if (brush && down) { stroke = []; paint(event); } cross.style.display = 'none'; });
  canvas.addEventListener('pointerup', (event) => {
    const [points, isDrag] = [stroke, down && Math.hypot(event.offsetX - down[0], event.offsetY - down[1]) >= kClick_px];
    stroke = null;
    if (points) stage.setMarks([], false);
    if (points && isDrag) brush(points);
    if (down && Math.hypot(event.offsetX - down[0], event.offsetY - down[1]) < kClick_px) pick(event.offsetX, event.offsetY);
    down = null;
  });
  const at = [0.5, 0.5];  // of the cross, in parts of the box
  canvas.addEventListener('keydown', (event) => {
    const step = event.shiftKey ? 0.1 : 0.01, moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
    if (event.key in moves) {
      cross.style.display = '';
      for (const k of [0, 1]) at[k] = Math.min(1, Math.max(0, at[k] + moves[event.key][k]));
      cross.style.left = `${100 * at[0]}%`;
      cross.style.top = `${100 * at[1]}%`;
    } else if (event.key === 'Enter') pick(at[0] * box.clientWidth, at[1] * box.clientHeight);
    else if (event.key === '0') { stage.fit(); settle(); }
    else if (event.key === '+' || event.key === '-') {
      const factor = event.key === '+' ? 1.25 : 0.8;
      settle();
      if (isPlan) flat.zoom *= factor;
      else round.position.lerp(roundControls.target, 1 - 1 / factor);
      controls().update();
      redraw();
    } else return;
    event.preventDefault();
  });
  return stage;
}
