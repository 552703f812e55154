// The live page: takes each view that the server sends and shows it; what it shows is in docs/live.md.
import {bands, fewNumbers, history} from './live/figures.js';
import {facts, fill, notes, state, table} from './live/text.js';
import {number} from './axes.js';
import {schemeSwitch} from './theme.js';

const at = (id) => document.getElementById(id);
const figures = new Map();
let view = null;

schemeSwitch(at('scheme'));

/** The figure of this name in a place, made when it is first asked for. */
function figure(place, id, make) {
  if (!figures.has(id)) figures.set(id, make(at(place), id));
  return figures.get(id);
}

/** Another run may have fewer figures. */
function hideAll() {
  figures.forEach((made) => made.hide());
}

function showLevels() {
  at('levels').hidden = view.axes.length === 0;
  if (!view.axes.length) return;
  at('window').textContent = `One-third-octave velocity over the last ${number(view.window_s)} s` +
    (view.window_s < 15.9 ? ', of 16 s once there are so many' : '') + '.';
  const limits = bands.range(view);
  view.axes.forEach((axis, i) => {
    figure('octaves', `fig-bands-${i}`, bands.make).show(`${axis.axis}, \u00b5m/s`, {view, axis, limits});
  });
  const signals = view.axes.flatMap((axis) => [[axis, axis.floor], [axis, axis.frame]]).filter(([, signal]) => signal);
  fill(at('axes-table'), table('Acceleration from 1 to 80 Hz, and the largest one-third-octave band',
    ['axis', 'signal', 'rms, mm/s\u00b2', 'peak, mm/s\u00b2', 'band, \u00b5m/s', 'at, Hz', 'class', 'rms of floor'],
    signals.map(([axis, signal]) => [axis.axis, axis.floor ? (signal === axis.floor ? 'floor' : 'frame') : '',
      number(1e3 * signal.rms_m_s2, 4), number(1e3 * signal.peak_m_s2, 4),
      number(1e6 * signal.largest_band_m_s, 4), number(signal.largest_band_hz), signal.vibration_class,
      axis.floor && signal === axis.frame ? number(signal.rms_m_s2 / axis.floor.rms_m_s2) : '']), 2));
}

function showMinute() {
  const {history: past} = view;
  at('minute').hidden = past.axes.length === 0;
  past.axes.forEach((axis, i) => {
    const lines = [{name: 'floor', values: axis.floor_rms_m_s2, colour: 'floor'},
      {name: 'frame', values: axis.frame_rms_m_s2, colour: view.run?.loop === 'passive' ? 'passive' : 'active'}];
    figure('histories', `fig-history-${i}`, history.make).show(`${axis.axis}: rms of each half second, mm/s\u00b2`, {
      time: past.time_s, scale: 1e3, unit: 'mm/s\u00b2', logarithmic: true,
      lines: lines.filter(({values}) => values.length),
    });
  });
}

function showForces() {
  const {history: past} = view;
  at('forces').hidden = view.legs.length === 0;
  if (!view.legs.length) return;
  figure('efforts', 'fig-force', history.make).show('Largest force of any leg, N', {
    time: past.time_s, scale: 1, unit: 'N', lines: [{name: 'force', values: past.force_n, colour: 'active'}],
    limit: view.force_limit_n,
  });
  if (past.wake_up_us.length) {
    const seconds = past.wake_up_us.map((_, i) => i - past.wake_up_us.length + 1);
    figure('efforts', 'fig-wake-up', history.make).show('Worst wake-up of each second, \u00b5s', {
      time: seconds, scale: 1, unit: '\u00b5s', lines: [{name: 'wake-up', values: past.wake_up_us, colour: 'text'}],
      timeName: 'seconds before now',
    });
  }
  fill(at('legs-table'), table('Commanded force over the same window', ['leg', 'rms, N', 'peak, N', 'of the limit'],
    view.legs.map((leg) => [leg.leg, number(leg.rms_n), number(leg.peak_n),
      leg.share === null ? '\u2013' : `${number(100 * leg.share)} %`]), 1));
}

function showController() {
  const {controller, timing} = view;
  at('controller').hidden = !controller && !timing.length;
  const rows = [];
  if (controller) {
    rows.push(['controller, now', controller.n_periods, controller.n_late, controller.n_lost, controller.n_missing,
      controller.n_saturated, controller.n_faults, number(controller.worst_wake_up_us),
      number(controller.recent_wake_up_us), number(controller.worst_compute_us)]);
  }
  timing.forEach((end) => rows.push([`${end.source}, in the end`, end.n_periods, end.n_late, end.n_lost, '', '', '',
    number(end.worst_wake_up_us), '', number(end.worst_compute_us)]));
  fill(at('controller-table'), table('What it says of itself; times are the worst, in \u00b5s', ['', 'periods', 'late', 'lost',
    'without a measurement', 'limited', 'faults', 'wake-up', 'in 10 s', 'compute'], rows, 1));
}

function showMessages() {
  at('messages').hidden = view.channels.length === 0;
  fill(at('channels-table'), table('Since the watch began', ['channel', 'a second', 'messages', 'damaged',
    'other version', 'other size', 'other run', 'quiet for, s'],
    view.channels.map((c) => [c.channel, c.per_s.toFixed(1), c.n_messages, c.n_broken, c.n_other_version, c.n_wrong_size,
      c.n_other_run, c.quiet_s > 1 ? c.quiet_s.toFixed(0) : '']), 1));
}

function show(next) {
  if (view && next.run?.run_id !== view.run?.run_id) hideAll();
  view = next;
  const {run} = view;
  at('title').textContent = run ? run.scene || `Run ${run.run_id}` : 'Waiting for a run';
  document.title = `${view.controller?.state ?? run?.state ?? 'waiting'} \u2013 stillframe live`;
  facts(at('facts'), view);
  state(at('state'), view);
  notes(at('notes'), view.notes);
  showLevels();
  showMinute();
  showForces();
  showController();
  showMessages();
  at('footer').textContent = `Watched for ${fewNumbers(view.watched_s)} s. The page only listens.`;
  window.stillframe.views = (window.stillframe.views ?? 0) + 1;
}

/** What is shown is old once the program that serves it has gone. */
function sayLost() {
  const badge = at('state');
  badge.className = 'badge fail';
  badge.textContent = view ? 'not connected: what is shown is old' : 'not connected';
}

// Only the newest view is drawn: a browser that is slow, or in the background, skips the others.
let newest = null, connected = false;
function draw() {
  const data = newest, began = performance.now();
  newest = null;
  show(JSON.parse(data));
  window.stillframe.drawingMs = performance.now() - began;
  if (!connected) sayLost();
}

const events = new EventSource('/events');
events.onmessage = ({data}) => {
  connected = true;
  if (newest === null) requestAnimationFrame(draw);
  newest = data;
};
events.onerror = () => {
  connected = false;
  sayLost();
};
