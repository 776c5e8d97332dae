// Wind and grip of a drive, set while it runs.
import { el } from '../../../report/web/src/dom.js';

const kDegree = Math.PI / 180;
const fields = {
  wind: { name: 'Wind, m/s', of: 'parameter.environment.wind_mps', unit: 1, min: 0, max: 100, step: 0.1 },
  towards: { name: 'blows to, degrees from +x', of: 'parameter.environment.wind_heading_rad', unit: kDegree, min: -360, max: 360, step: 1 },
  grip: { name: 'Grip', of: 'parameter.environment.road_grip', unit: 1, min: 0.01, max: 3, step: 0.01 },
};

/// What the fields say is sent only where somebody changed them; an empty one leaves what the unit has.
export function makeWeather() {
  let wanted = {};
  const boxes = Object.fromEntries(Object.entries(fields).map(([key, { min, max, step }]) => [key, el('input', { type: 'number', min, max, step, disabled: true, placeholder: 'as it is', 'data-role': `weather-${key}` })]));
  for (const [key, box] of Object.entries(boxes))
    box.addEventListener('change', () => {
      if (box.reportValidity() && Number.isFinite(box.valueAsNumber)) wanted[fields[key].of] = box.valueAsNumber * fields[key].unit;
    });
  const root = el('div', { class: 'tools', role: 'group', 'aria-label': 'Weather' }, Object.entries(boxes).map(([key, box]) => el('label', {}, fields[key].name, box)));

  /// What a command says of it, once.
  function take() {
    const said = wanted;
    wanted = {};
    return said;
  }

  function enable(on) {
    for (const box of Object.values(boxes)) {
      box.disabled = !on;
      if (!on) box.value = '';
    }
    if (!on) wanted = {};
  }
  return { root, take, enable };
}
