// A drive of a unit in real time: keys or a gamepad drive, the road goes by.
import { el, css, write } from '../../../report/web/src/dom.js';
import { fixed } from '../../../report/web/src/format.js';
import { run } from './jobs.js';
import { getPacked, tellDrive, watchRun } from './server.js';
import { kBrake_pa, kMostSteer_rad, makeGauges } from './gauges.js';
import { makeDriverHelp, pedalsToHold } from './driver_help.js';
import { makeLiveScene } from './live_scene.js';
import { makeTouchPad, padNow } from './pads.js';
import { gearsOf, infoOf, makeParameters } from './parameters.js';
import { makeSights } from './sights.js';
import { makeUnitQuestion } from './unit_question.js';
import { makeWeather } from './weather.js';

const kEvery_ms = 30;
const keysOf = { ArrowLeft: 'left', ArrowRight: 'right', ArrowUp: 'throttle', ArrowDown: 'brake', a: 'left', d: 'right', w: 'throttle', s: 'brake' };

/// Goes from `now` to `wanted` by at most `most`.
const towards = (now, wanted, most) => now + Math.min(most, Math.max(-most, wanted - now));

/// What the driver does, made smooth: keys know only all or nothing. `target_mps`: the speed to hold; 0: none.
export function pedalsOf(before, keys, pad, speed_mps, dt_s, target_mps = 0) {
  // The faster, the less: 0.3 rad at rest, a twentieth of it at 80 m/s.
  const reach = kMostSteer_rad / (1 + (speed_mps / 18) ** 2);
  const steer = pad ? -pad.steer * kMostSteer_rad * Math.max(0.15, reach / kMostSteer_rad) : (keys.has('left') - keys.has('right')) * reach;
  const pressed = pad ? { throttle: pad.throttle, brake: pad.brake } : { throttle: Number(keys.has('throttle')), brake: Number(keys.has('brake')) };
  // A speed is held while nobody touches the pedals.
  const { throttle, brake } = target_mps > 0 && pressed.throttle === 0 && pressed.brake === 0 ? pedalsToHold(target_mps, speed_mps) : pressed;
  return { steer: towards(before.steer, steer, 0.6 * dt_s), throttle: towards(before.throttle, throttle, 3 * dt_s), brake: towards(before.brake, brake, 4 * dt_s) };
}

/// The next gear up near the limit of the engine, the next down below half of it; not twice within 0.4 s.
export function gearOf(gear, engine_radps, limit_radps, since_s, gears) {
  if (since_s < 0.4) return gear;
  if (engine_radps > 0.92 * limit_radps && gear < gears) return gear + 1;
  if (engine_radps < 0.5 * limit_radps && gear > 1) return gear - 1;
  return gear;
}

export function makeLive({ changed, entriesOf, openLaps, keep }) {
  let unit = null, drive = null, road = null, timer = null, waits = false;
  const keys = new Set();
  const note = el('p', { class: 'small', role: 'status', 'data-role': 'note' });
  const roadBox = el('select', { 'aria-label': 'Road to show', 'data-role': 'road' });
  const sensorsBox = el('select', { 'aria-label': 'Sensors of the road', 'data-role': 'sensors' });
  const portBox = el('input', { type: 'number', min: 1, max: 65535, placeholder: 'UDP port', 'aria-label': 'UDP port of a run to watch', 'data-role': 'watch-port' });
  const sights = makeSights(), question = makeUnitQuestion(), weather = makeWeather(), parameters = makeParameters({ say: (text, kind) => say(text, kind) }), help = makeDriverHelp({ changed: () => draw(), say: (text, kind) => say(text, kind) });
  const canvas = el('canvas', { tabindex: 0, role: 'application', 'aria-label': 'Drive: arrows or W A S D steer, accelerate and brake' });
  const box = el('div', { class: 'stage', 'data-view': 'live' }, canvas);
  const gauges = Object.fromEntries(['speed', 'gear', 'engine', 'lap', 'last', 'best'].map((key) => [key, el('dd', { 'data-gauge': key }, '–')]));
  const names = { speed: 'Speed', gear: 'Gear', engine: 'Engine', lap: 'This lap', last: 'Last lap', best: 'Best lap' };
  const bars = makeGauges();
  const button = (role, text, action) => el('button', { type: 'button', 'data-role': role, onclick: action }, text);
  const startButton = button('start', el('strong', {}, 'Start'), start), endButton = button('end', 'End', end), resetButton = button('reset', 'Back to the start', () => { drive.wants.reset = {}; });
  const pauseButton = el('button', { type: 'button', 'data-role': 'pause', 'aria-pressed': 'false', onclick: () => {
    drive.paused = !drive.paused;
    pauseButton.setAttribute('aria-pressed', String(drive.paused));
  } }, 'Pause');
  const watchButton = button('watch', 'Watch', watch);
  const views = { ahead: 'from above, ahead', whole: 'whole track', chase: 'behind the car', driver: 'driver', top: 'over the car', orbit: 'round the car' };
  const viewBox = el('select', { 'aria-label': 'View of the drive', 'data-role': 'view' }, Object.entries(views).map(([key, text]) => el('option', { value: key }, text)));
  viewBox.addEventListener('change', () => { draw(); remember(); });
  const laps = el('div');
  const root = el('div', { class: 'work', 'data-part': 'live' }, el('div', { class: 'split' },
    el('div', {}, el('div', { class: 'tools' }, startButton, pauseButton, resetButton, endButton, el('label', {}, 'View', viewBox), el('label', {}, 'Road', roadBox), el('label', {}, 'Sensors', sensorsBox)),
      question.root, help.root, el('div', { class: 'tools' }, weather.root, el('label', {}, 'A run that is driven elsewhere', portBox), watchButton), parameters.root, box),
    el('div', { class: 'side' }, note, el('dl', { class: 'facts' }, Object.entries(gauges).map(([key, node]) => el('div', {}, el('dt', {}, names[key]), node))),
      bars.root, laps,
      el('p', { class: 'muted small' }, 'Arrows or W A S D, once the picture is clicked; or a gamepad; or a finger on the picture: sideways steers, up accelerates, down brakes. Gears shift by themselves. Where this page is left, the car brakes.'))));
  const say = (text, kind = 'muted') => { note.className = `small ${kind}`; note.textContent = text; };

  const space = makeLiveScene('Drive in space: arrows or W A S D steer, accelerate and brake');
  if (space) box.append(space.canvas);
  else for (const key of ['chase', 'driver', 'top', 'orbit']) viewBox.querySelector(`[value="${key}"]`).disabled = true;
  for (const each of [canvas, ...(space ? [space.canvas] : [])]) {
    each.addEventListener('keydown', (event) => {
      const key = keysOf[event.key.length === 1 ? event.key.toLowerCase() : event.key];
      if (!key) return;
      keys.add(key);
      event.preventDefault();
    });
    each.addEventListener('keyup', (event) => keys.delete(keysOf[event.key.length === 1 ? event.key.toLowerCase() : event.key]));
    each.addEventListener('blur', () => keys.clear());
    each.addEventListener('pointerdown', () => each.focus());
  }
  const touched = makeTouchPad([canvas, ...(space ? [space.canvas] : [])]);
  // Round the car a finger turns the view.
  const touchNow = () => (viewBox.value === 'orbit' ? null : touched());
  const isFlat = () => ['ahead', 'whole'].includes(viewBox.value);
  const remember = () => { if (unit !== null) keep(unit, [roadBox.value, viewBox.value].map(encodeURIComponent).join(',')); };

  function buttons() {
    startButton.disabled = unit === null || drive !== null;
    endButton.disabled = drive === null;
    watchButton.disabled = drive !== null;
    for (const each of [pauseButton, resetButton]) each.disabled = drive === null || drive.watched !== undefined;
    weather.enable(drive !== null && drive.watched === undefined);
    parameters.enable(drive !== null && drive.watched === undefined);
  }

  async function start() {
    const of = unit;
    let agreed;
    startButton.disabled = true;
    try {
      agreed = await question.agreed(of);
    } catch (error) { say(error.message, 'bad'); buttons(); return; }
    if (agreed === null || unit !== of || drive !== null) { say('Not started.'); buttons(); return; }
    say('Starting …');
    drive = { sequence: 0, pedals: { steer: 0, throttle: 0, brake: 0 }, gear: 1, gears: 6, shifted: 0, last: performance.now(), paused: false, lapBegin: null, lapU: null, times: [], job: null, result: null, wants: {} };
    const mine = drive;
    sights.clear();
    buttons();
    (isFlat() ? canvas : space.canvas).focus();
    run({ do: 'drive', unit: of, agreed, parameters: parameters.chosen(), ...(sensorsBox.value ? { devices: sensorsBox.value, road: roadBox.value } : {}) }, (begun) => {
      mine.job = begun.id;
      infoOf(of).then((info) => { mine.gears = gearsOf(info); }).catch((error) => say(error.message, 'warn'));
      mine.result = begun.result;
      say('Driving.');
      timer = setInterval(() => step(mine), kEvery_ms);
    }).catch((error) => ({ exit_code: 1, messages: error.message })).then(async (job) => {
      clearInterval(timer);
      drive = null;
      pauseButton.setAttribute('aria-pressed', 'false');
      buttons();
      if (job.exit_code !== 0 && !mine.ended) { say(job.messages || `crgsim ended with exit code ${job.exit_code}.`, 'bad'); return; }
      say(`The drive is in ${mine.result}.`, 'good');
      await changed();
      laps.replaceChildren(el('button', { type: 'button', 'data-role': 'to-laps', onclick: () => openLaps([`0/${mine.result}`]) }, 'Look at it among the laps'));
      root.dataset.result = mine.result;
    });
  }

  /// A run of crgsim serve --udp that another program drives: this page looks on.
  function watch() {
    if (!portBox.reportValidity() || !Number.isFinite(portBox.valueAsNumber)) { say('Which UDP port has crgsim serve been given?', 'warn'); return; }
    drive = { watched: portBox.valueAsNumber, lapBegin: null, lapU: null, times: [] };
    const mine = drive;
    sights.clear();
    buttons();
    say(`Watching UDP port ${mine.watched}; nothing has come yet.`);
    timer = setInterval(() => look(mine), kEvery_ms);
  }

  async function look(mine) {
    if (waits || drive !== mine) return;
    waits = true;
    const measured = await watchRun(mine.watched).catch(() => null);
    waits = false;
    if (drive !== mine || measured === null) return;
    if (!measured.values) {
      if (mine.heard) say(`Nothing comes from UDP port ${mine.watched} any more: the run has ended or stands still.`, 'warn');
      mine.heard = false;
      return;
    }
    if (measured.values['car.x'] === undefined || measured.values['car.y'] === undefined || measured.values['car.yaw'] === undefined) { say('This run does not measure car.x, car.y and car.yaw (--measure).', 'warn'); return; }
    if (!mine.heard) say(`Watching UDP port ${mine.watched}.`);
    mine.heard = true;
    see(mine, measured);
  }

  function end() {
    if (!drive) return;
    if (drive.watched !== undefined) {
      clearInterval(timer);
      drive = null;
      buttons();
      say('No longer watching.');
      return;
    }
    drive.ended = true;
    drive.wants.end = true;
  }

  /// One message after the other: of two on the way at once the later may arrive first, and the earlier counts no more.
  async function send(mine) {
    const { pedals, gear, wants } = mine, brake = kBrake_pa * pedals.brake;
    const set = { 'input.steering': pedals.steer, 'input.throttle': pedals.throttle, 'input.gear': gear, 'input.brake.fl': brake, 'input.brake.fr': brake, 'input.brake.rl': 0.6 * brake, 'input.brake.rr': 0.6 * brake };
    // With each message: where the page was late, the run went back to its own weather.
    mine.held = { ...mine.held, ...weather.take(), ...parameters.take() };
    Object.assign(set, mine.held);
    mine.asked = set;
    mine.sequence += 1;
    mine.wants = {};
    const measured = await tellDrive(mine.job, { sequence: mine.sequence, set, pause: mine.paused, ...wants }).catch(() => null);
    if (measured === null) mine.wants = { ...wants, ...mine.wants };
    return measured;
  }

  async function step(mine) {
    if (waits || drive !== mine) return;
    const now = performance.now(), dt = Math.min(0.1, (now - mine.last) / 1000), seen = mine.seen?.values ?? {};
    mine.last = now;
    mine.pedals = pedalsOf(mine.pedals, keys, touchNow() ?? padNow(), seen['car.vx'] ?? 0, dt, help.target_mps());
    const gear = gearOf(mine.gear, seen['car.engine'] ?? 0, seen['parameter.engine.limit_radps'] ?? 800, (now - mine.shifted) / 1000, mine.gears);
    if (gear !== mine.gear) { mine.gear = gear; mine.shifted = now; }
    waits = true;
    const measured = await send(mine);
    waits = false;
    if (drive !== mine || !measured?.values) return;
    see(mine, measured);
  }

  function see(mine, measured) {
    const stands = measured.time_s === mine.seen?.time_s && !measured.sights?.length;
    mine.seen = measured;
    // The picture of a paused drive stays; gauges show what is asked for.
    if (stands) { tell(measured.values); return; }
    sights.take(measured);
    lap(mine, measured.time_s, measured.values['car.u']);
    draw();
  }

  /// A lap ends where u falls from the end of the road to its begin.
  function lap(mine, time_s, u) {
    const length = road?.head.closed ? road.head.length_m : null;
    if (mine.lapU !== null && time_s < mine.lapTime) mine.lapBegin = null;  // a reset
    if (length && mine.lapU !== null && u < mine.lapU - 0.5 * length) {
      if (mine.lapBegin !== null) mine.times.push(time_s - mine.lapBegin);
      mine.lapBegin = time_s;
    }
    mine.lapU = u;
    mine.lapTime = time_s;
  }

  function draw() {
    const now = drive?.seen?.values;
    canvas.hidden = !isFlat();
    if (isFlat()) {
      space?.hide();
      drawFlat(now);
    } else space.draw(now, viewBox.value, [...help.lines(), ...(now ? sights.lines() : [])], road && [road.x_m[0], road.y_m[0], Math.atan2(road.y_m[1] - road.y_m[0], road.x_m[1] - road.x_m[0])]);
    if (now) tell(now);
  }

  function drawFlat(now) {
    const ratio = Math.min(2, window.devicePixelRatio || 1), width = box.clientWidth, height = box.clientHeight;
    if (width < 10) return;
    if (canvas.width !== Math.floor(width * ratio)) canvas.width = Math.floor(width * ratio);
    if (canvas.height !== Math.floor(height * ratio)) canvas.height = Math.floor(height * ratio);
    const context = canvas.getContext('2d'), whole = viewBox.value === 'whole';
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    let scale = 7 * ratio;
    if (whole && road) {
      const [low, high] = [Math.min, Math.max].map((most) => [most(...road.x_m), most(...road.y_m)]);
      scale = 0.9 * Math.min(canvas.width / (high[0] - low[0] + 20), canvas.height / (high[1] - low[1] + 20));
      context.translate(canvas.width / 2, canvas.height / 2);
      context.scale(scale, -scale);
      context.translate(-0.5 * (low[0] + high[0]), -0.5 * (low[1] + high[1]));
    } else {
      const x = now?.['car.x'] ?? road?.x_m[0] ?? 0, y = now?.['car.y'] ?? road?.y_m[0] ?? 0;
      const yaw = now?.['car.yaw'] ?? (road ? Math.atan2(road.y_m[1] - road.y_m[0], road.x_m[1] - road.x_m[0]) : 0);
      context.translate(canvas.width / 2, 0.72 * canvas.height);
      context.scale(scale, -scale);
      context.rotate(Math.PI / 2 - yaw);
      context.translate(-x, -y);
    }
    const pen = (colour, pixels) => { context.strokeStyle = css(colour); context.lineWidth = (pixels * ratio) / scale; };
    const path = (xs, ys) => {
      context.beginPath();
      let drawn = false;
      for (let k = 0; k < xs.length; ++k) {
        if (Number.isNaN(xs[k])) { drawn = false; continue; }
        if (drawn) context.lineTo(xs[k], ys[k]);
        else context.moveTo(xs[k], ys[k]);
        drawn = true;
      }
      context.stroke();
    };
    if (road) {
      pen('--fg', 2);
      path(road.left_x_m, road.left_y_m);
      path(road.right_x_m, road.right_y_m);
      pen('--none', 1);
      path(road.x_m, road.y_m);
      pen('--s3', 3);
      context.beginPath();
      context.moveTo(road.left_x_m[0], road.left_y_m[0]);
      context.lineTo(road.right_x_m[0], road.right_y_m[0]);
      context.stroke();
    }
    for (const { points, colour } of help.lines()) {
      pen(colour, 2);
      path(points.map(([x]) => x), points.map(([, y]) => y));
    }
    if (now) {
      sights.draw(context, { pen, path, colour: css, size_m: (1.5 * ratio) / scale });
      context.save();
      context.translate(now['car.x'], now['car.y']);
      context.rotate(now['car.yaw']);
      const size = whole ? (6 * ratio) / scale : 1;
      context.scale(size, size);
      context.fillStyle = css('--cursor');
      context.beginPath();
      for (const [x, y] of [[2.6, 0], [0.4, 0.9], [-2.2, 0.9], [-2.2, -0.9], [0.4, -0.9]]) context.lineTo(x, y);
      context.fill();
      context.restore();
    }
  }

  /// What the gauges show.
  function tell(now) {
    parameters.show(now);
    const counts = sights.counts();
    for (const key of Object.keys(counts)) box.dataset[key] = counts[key];
    // A run that is watched measures what its driver wants.
    const told = (name, factor, unit) => (now[name] === undefined ? '–' : `${fixed(factor * now[name], 0)}${unit}`);
    write(gauges.speed, told('car.vx', 3.6, ' km/h'));
    write(gauges.gear, bars.show(now, drive.asked).gear);
    write(gauges.engine, told('car.engine', 30 / Math.PI, ' 1/min'));
    write(gauges.lap, drive.lapBegin === null ? '–' : `${fixed(drive.seen.time_s - drive.lapBegin, 1)} s`);
    write(gauges.last, drive.times.length > 0 ? `${fixed(drive.times.at(-1), 2)} s` : '–');
    write(gauges.best, drive.times.length > 0 ? `${fixed(Math.min(...drive.times), 2)} s` : '–');
    box.dataset.time = drive.seen.time_s;
    box.dataset.speed = now['car.vx'];
  }
  new ResizeObserver(draw).observe(box);

  async function showRoad() {
    road = null;
    if (roadBox.value) {
      try {
        road = await getPacked('road', { id: roadBox.value });
      } catch (error) {
        say(error.message, 'bad');
      }
    }
    space?.setRoad(road);
    draw();
  }
  roadBox.addEventListener('change', () => { showRoad(); remember(); });

  async function open(next, state = '') {
    const [wantedRoad, wantedView] = state.split(',').map(decodeURIComponent);
    if (drive) { say('End this drive first.', 'warn'); return; }
    if (next !== unit) question.leave();
    unit = next;
    parameters.open(next);
    const { entries } = await changed(), roads = entries.filter((entry) => entry.kind === 'road' && !/\.(patch-\d+|friction)\.crg$/.test(entry.id));
    const kept = wantedRoad || roadBox.value;
    if (wantedView in views) viewBox.value = wantedView;
    roadBox.replaceChildren(el('option', { value: '' }, 'none'), ...roads.map((entry) => el('option', { value: entry.id }, entry.id.replace(/^\d+\//, ''))));
    roadBox.value = roads.some((entry) => entry.id === kept) ? kept : roads[0]?.id ?? '';
    help.offer(entries);
    const sensors = sensorsBox.value, files = entries.filter((entry) => entry.kind === 'devices');
    sensorsBox.replaceChildren(el('option', { value: '' }, 'none'), ...files.map((entry) => el('option', { value: entry.id }, entry.id.replace(/^\d+\//, ''))));
    sensorsBox.value = files.some((entry) => entry.id === sensors) ? sensors : '';
    say('');
    buttons();
    await showRoad();
  }
  buttons();
  if (entriesOf().length === 0) say('A unit is made by: crgdrive fmu vehicle.yaml --road road.crg -o car.fmu');
  return { root, open };
}
