// The car on its road in space: from behind, from the driver's seat, from above, or as the mouse turns it. Forces of the tyres as arrows, slip as colour.
import {
  ArrowHelper, BoxGeometry, BufferGeometry, Color, CylinderGeometry, DirectionalLight, DoubleSide, Group, HemisphereLight, Line, LineBasicMaterial, Mesh, MeshLambertMaterial, PerspectiveCamera, Scene,
  Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { css, el } from '../../../report/web/src/dom.js';
import { drawsSlowly, fitted } from '../../../report/web/src/drawing.js';
import { ofShare } from './point_colours.js';
import { roadGeometry } from './road_mesh.js';

const wheels = ['fl', 'fr', 'rl', 'rr'];
const kLoad_mpn = 6e-4, kWheel_m = 0.33, kSlip = 0.15;  // metres of arrow a newton; radius; slip of the brightest colour

/// Where the camera is and what it looks at, in the car's frame: x ahead, y left, z up.
export const cameras = {
  chase: { from: [-9, 0, 3], to: [6, 0, 0.5] },
  driver: { from: [0.1, 0, 0.75], to: [20, 0, 0.2] },
  top: { from: [0, 0, 45], to: [0.01, 0, 0] },
};

/// The larger of the slip along and across, of a tyre.
export const slipOf = (values, wheel) => Math.max(Math.abs(values[`wheel.${wheel}.kappa`] ?? 0), Math.abs(values[`wheel.${wheel}.tan_alpha`] ?? 0));

/// Null where the browser has no WebGL. `words`: what the picture is called.
export function makeLiveScene(words) {
  const canvas = el('canvas', { tabindex: 0, role: 'application', 'aria-label': words, hidden: '' }), isSlow = drawsSlowly();
  let renderer;
  try {
    renderer = new WebGLRenderer({ canvas, antialias: !isSlow, preserveDrawingBuffer: true });
  } catch {
    return null;
  }
  const scene = new Scene(), camera = new PerspectiveCamera(60, 1, 0.1, 20000), car = new Group(), lines = new Group(), sun = new DirectionalLight(0xffffff, 1.5);
  sun.position.set(-1, -0.6, 2);
  scene.add(new HemisphereLight(0xffffff, 0x808890, 2), sun, car, lines);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, canvas), target = new Vector3();
  controls.enableKeys = false;
  let road = null, origin = [0, 0, 0], mode = 'chase', isFree = false;

  const body = new Mesh(new BoxGeometry(4.6, 1.1, 0.45), new MeshLambertMaterial()), nose = new Mesh(new BoxGeometry(0.5, 1.9, 0.12), body.material);
  body.position.set(0.1, 0, 0.05);
  nose.position.set(2.4, 0, -0.1);
  car.add(body, nose);
  const parts = Object.fromEntries(wheels.map((wheel) => {
    const turn = new Group(), tyre = new Mesh(new CylinderGeometry(kWheel_m, kWheel_m, 0.3, 18), new MeshLambertMaterial());
    turn.add(tyre);
    const load = new ArrowHelper(new Vector3(0, 0, 1), new Vector3(), 1), force = new ArrowHelper(new Vector3(1, 0, 0), new Vector3(), 1);
    // Seen through wheels and body.
    for (const part of [load.line, load.cone, force.line, force.cone]) { part.material.depthTest = false; part.renderOrder = 1; }
    car.add(turn, load, force);
    return [wheel, { turn, tyre, load, force }];
  }));

  const local = (x, y, z) => new Vector3(x - origin[0], y - origin[1], z - origin[2]);
  /// An arrow of this force; of less than 50 N none.
  function point(arrow, from, force_n, colour) {
    const size_n = force_n.length();
    arrow.visible = size_n > 50;
    if (!arrow.visible) return;
    arrow.position.copy(from);
    arrow.setDirection(force_n.clone().normalize());
    arrow.setLength(kLoad_mpn * size_n, Math.min(0.25, 0.3 * kLoad_mpn * size_n), 0.12);
    arrow.setColor(new Color(css(colour)));
  }

  function place(now) {
    // The axes of yaw, then pitch (nose down positive), then roll (left side up positive), as lib/vehicle has them.
    car.rotation.set(now['car.roll'] ?? 0, now['car.pitch'] ?? 0, now['car.yaw'], 'ZYX');
    car.position.copy(local(now['car.x'], now['car.y'], now['car.z'] ?? origin[2]));
    body.material.color.set(css('--accent'));
    const rgb = [0, 0, 0];
    for (const wheel of wheels) {
      const { turn, tyre, load, force } = parts[wheel], name = (what) => now[`wheel.${wheel}.${what}`], steer = wheel.startsWith('f') ? now['car.steer'] ?? 0 : 0;
      const at = new Vector3(name('contact_x') ?? (wheel.startsWith('f') ? 1.6 : -1.4), name('contact_y') ?? (wheel.endsWith('l') ? 0.8 : -0.8), name('contact_z') ?? -0.3);
      turn.position.copy(at).setZ(at.z + kWheel_m);
      turn.rotation.z = steer;
      ofShare(slipOf(now, wheel) / kSlip, rgb);
      tyre.material.color.setRGB(rgb[0] / 255, rgb[1] / 255, rgb[2] / 255, 'srgb');
      point(load, at, new Vector3(0, 0, name('fz') ?? 0), '--s3');
      point(force, at, new Vector3(name('fx') ?? 0, name('fy') ?? 0, 0).applyAxisAngle(new Vector3(0, 0, 1), steer), '--cursor');
    }
  }

  function look() {
    const { from, to } = cameras[mode] ?? cameras.chase;
    // Level, but for the driver, who leans with his car.
    const yaw = car.rotation.z, inMap = (offset) => (mode === 'driver' ? new Vector3(...offset).applyEuler(car.rotation) : new Vector3(...offset).applyAxisAngle(new Vector3(0, 0, 1), yaw)).add(car.position);
    controls.enabled = mode === 'orbit';
    if (mode === 'orbit') {
      if (!isFree) { camera.position.copy(inMap(cameras.chase.from)); target.copy(car.position); controls.target.copy(target); }
      isFree = true;
      camera.position.add(car.position.clone().sub(target));  // it goes along
      target.copy(car.position);
      controls.target.copy(target);
      controls.update();
      return;
    }
    isFree = false;
    camera.up.set(0, 0, 1);
    if (mode === 'top') camera.up.set(Math.cos(yaw), Math.sin(yaw), 0);
    camera.position.copy(inMap(from));
    camera.lookAt(inMap(to));
  }

  return {
    canvas,
    setRoad(packed) {
      if (road) { scene.remove(road); road.geometry.dispose(); road.material.dispose(); }
      road = null;
      if (!packed) return;
      const z = packed.z_m.find((each) => !Number.isNaN(each)) ?? 0;
      origin = [Math.round(packed.x_m[0]), Math.round(packed.y_m[0]), Math.round(z)];
      road = new Mesh(roadGeometry(packed, origin), new MeshLambertMaterial({ side: DoubleSide }));
      scene.add(road);
    },
    /// `now`: what is measured; `seen`: lines on the map [{points: [[x, y], ...], colour}]; null: the car stands where the road begins.
    draw(now, view, seen, begin) {
      mode = view;
      canvas.hidden = false;
      const size = fitted(renderer, canvas.parentElement, isSlow);
      if (!size) return;
      camera.aspect = size.width / size.height;
      camera.updateProjectionMatrix();
      place(now ?? { 'car.x': begin?.[0] ?? 0, 'car.y': begin?.[1] ?? 0, 'car.yaw': begin?.[2] ?? 0, 'car.z': origin[2] + 0.3 });
      body.visible = nose.visible = mode !== 'driver';
      for (const child of [...lines.children]) { child.geometry.dispose(); child.material.dispose(); lines.remove(child); }
      const height = (now?.['car.z'] ?? origin[2]) - 0.2;
      for (const { points, colour } of seen) if (points.length > 1) lines.add(new Line(new BufferGeometry().setFromPoints(points.map(([x, y]) => local(x, y, height))), new LineBasicMaterial({ color: css(colour), depthTest: false })));
      road?.material.color.set(css('--none'));
      renderer.setClearColor(new Color(css('--bg')));
      look();
      renderer.render(scene, camera);
      canvas.parentElement.dataset.view3d = mode;
    },
    hide() { canvas.hidden = true; delete canvas.parentElement?.dataset.view3d; },
  };
}
