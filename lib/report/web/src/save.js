// Plots and their numbers as files: PNG, SVG and CSV, made in the page.
import { css, el } from './dom.js';

/// A cell of a CSV file. Numbers stay numbers. Text is quoted where it has to be, and a spreadsheet must not
/// take it for a formula: names in a report come from strangers.
function cell(value) {
  if (value === null || value === undefined) return '';
  if (typeof value === 'number') {
    if (!Number.isFinite(value)) return '';
    return String(Math.abs(value) >= 1e-3 ? Math.round(1e6 * value) / 1e6 : Number(value.toPrecision(6)) || 0);
  }
  const text = /^\s*[=+\-@|\t\r]/.test(value) ? `'${value}` : String(value);
  return /[",;\r\n\t]|^'|^\s|\s$/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

export function csvOf(heads, rows) {
  return [heads, ...rows].map((row) => row.map(cell).join(',')).join('\r\n') + '\r\n';
}

function download(name, blob) {
  const link = el('a', { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

const plain = (text) => text.normalize('NFKD').replace(/[^A-Za-z0-9._-]+/g, '-').replace(/^[-.]+|[-.]+$/g, '').slice(0, 60);

/// The picture with its title and the names of its lines, on the colour of the page.
function picture(canvas, title, names) {
  const ratio = canvas.width / (canvas.clientWidth || canvas.width), room = Math.round((title || names.length ? 26 : 0) * ratio);
  const copy = el('canvas', { width: canvas.width, height: canvas.height + room });
  const context = copy.getContext('2d');
  context.fillStyle = css('--panel');
  context.fillRect(0, 0, copy.width, copy.height);
  context.font = `${13 * ratio}px system-ui, "DejaVu Sans", sans-serif`;
  context.textBaseline = 'middle';
  context.fillStyle = css('--fg');
  context.fillText(title, 8 * ratio, 13 * ratio);
  let x = 20 * ratio + context.measureText(title).width;
  for (const { name, colour } of names) {
    context.fillStyle = colour;
    context.fillRect(x, 11 * ratio, 14 * ratio, 4 * ratio);
    context.fillStyle = css('--muted');
    context.fillText(name, x + 18 * ratio, 13 * ratio);
    x += 34 * ratio + context.measureText(name).width;
  }
  context.drawImage(canvas, 0, room);
  return copy;
}

const kNoLines = 'it is made of points, not of lines, so there is no SVG';

/// A button that saves a picture alone; `what` gives canvas and title at the time of the click.
export function pictureButton(place, what) {
  return el('button', { type: 'button', 'data-save': 'png', title: `Save this picture as PNG; ${kNoLines}`, 'aria-label': 'Save this picture as PNG', onclick: () => {
    const { canvas, title } = what();
    if (canvas) picture(canvas, title ?? '', []).toBlob((blob) => download(`${plain(title) || plain(document.title)}-${plain(place)}.png`, blob), 'image/png');
  } }, 'PNG');
}

/// Buttons that save a plot. `what` gives, at the time of the click: canvas, title, names [{name, colour}],
/// table() with {heads, rows}, and svg() where the plot `isLines`; `place` is the part of the file's name that tells which plot it is.
export function saveButtons(place, what, isLines = false) {
  const name = (ending) => `${plain(document.title.replace(/ – road report$/, '')) || 'road'}-${plain(place)}.${ending}`;
  const png = el('button', { type: 'button', 'data-save': 'png', title: isLines ? 'Save this picture as PNG' : `Save this picture as PNG; ${kNoLines}`, 'aria-label': 'Save this picture as PNG', onclick: () => {
    const { canvas, title, names } = what();
    if (canvas) picture(canvas, title ?? '', names ?? []).toBlob((blob) => download(name('png'), blob), 'image/png');
  } }, 'PNG');
  const svg = el('button', { type: 'button', 'data-save': 'svg', title: 'Save this chart as SVG', 'aria-label': 'Save this chart as SVG', onclick: () => {
    const text = what().svg?.();
    if (text) download(name('svg'), new Blob([text], { type: 'image/svg+xml' }));
  } }, 'SVG');
  const csv = el('button', { type: 'button', 'data-save': 'csv', title: 'Save the numbers in view as CSV', 'aria-label': 'Save the numbers in view as CSV', onclick: () => {
    const { heads, rows } = what().table();
    download(name('csv'), new Blob([csvOf(heads, rows)], { type: 'text/csv' }));
  } }, 'CSV');
  return el('div', { class: 'save no-print' }, png, isLines ? svg : null, csv);
}
