// Opens the live page in headless Chromium while a made-up run goes on, and then another one.
//   node test_live_page.mjs STILLFRAME MADE_UP_RUN FOLDER
// To be run in a network of its own. Screenshots are left in FOLDER.
import {spawn} from 'node:child_process';
import {join} from 'node:path';

import {check, exitCode, folder, withPage} from '../browser/browser.mjs';

const [stillframe, madeUpRun] = process.argv.slice(2), out = folder(process.argv[4]);

const started = [];
function start(program, ...words) {
  const child = spawn(program, words, {stdio: ['ignore', 'pipe', 'inherit']});
  started.push(child);
  return child;
}
const ended = (child) => new Promise((resolve) => (child.exitCode !== null ? resolve() : child.once('exit', resolve)));
async function stop(child) {
  child.kill('SIGTERM');
  await ended(child);
}
const firstLine = (child) => new Promise((resolve) => {
  let text = '';
  child.stdout.on('data', (part) => {
    text += part;
    if (text.includes('\n')) resolve(text.split('\n')[0]);
  });
  child.once('exit', () => resolve(text));
});

/** Length of all paths inside the plot of each chart: one that has been drawn has long ones. */
const inked = (page) => page.evaluate(() => Object.fromEntries([...document.querySelectorAll('figure:not([hidden]) .chart')]
  .map((chart) => [chart.id, [...chart.querySelectorAll('svg path')].reduce((sum, path) => sum + path.getTotalLength(), 0)])));
const until = (page, test, ...words) => page.waitForFunction(test, words[0], {timeout: 60000, polling: 100});
const rowOf = (page, place, first) => page.evaluate(([id, name]) => [...document.querySelectorAll(`#${id} tbody tr`)]
  .map((row) => [...row.children].map((cell) => cell.textContent)).filter((cells) => cells[0] === name), [place, first]);
// What the page itself asks for, and nothing else.
const own = (url) => (problem) => ['live.css', 'live.js', 'events'].some((path) => problem === `request: ${url}${path}`);

function forget(problems, isOwn) {
  const rest = problems.filter((problem) => !isOwn(problem));
  problems.splice(0, problems.length, ...rest);
}

async function showsTheRun(page) {
  // A sine of 2 mm/s^2 has an rms of 1.414; on a busy machine the page may have to wait for a window without a gap.
  await until(page, () => Math.abs(document.querySelector('#axes-table tbody td:nth-child(3)')?.textContent - 1.414) < 0.01);
  const figures = await page.evaluate(() => window.stillframe.figures);
  for (const name of ['fig-bands-0', 'fig-history-0', 'fig-force', 'fig-wake-up']) check(figures[name], `${name} is drawn`);
  for (const [id, length] of Object.entries(await inked(page))) check(length > 700, `${id} has lines of ${length} px`);
  check(await page.textContent('#title') === 'A sample', 'the title is the scene');
  check(await page.textContent('#state') === 'active', 'the state is that of the controller');
  const facts = await page.textContent('#facts');
  check(facts.includes('1234567890123456789'), `every digit of the run's number is shown: ${facts}`);
  const [floor, frame] = await rowOf(page, 'axes-table', 'x');
  check(floor[1] === 'floor', `the first row is the floor: ${floor}`);
  check(frame[1] === 'frame' && Math.abs(frame[7] - 0.25) < 0.01, `rms of the frame over the floor's: ${frame}`);
  check(floor[6] === 'VC-B' && frame[6] === 'VC-D', `classes: ${floor[6]}, ${frame[6]}`);
  const [[, rms, peak, share]] = await rowOf(page, 'legs-table', 'leg_2');
  check(rms === '50.0' && peak === '50.0' && share === '25.0 %', `the leg: ${[rms, peak, share]}`);
  const [controller] = await rowOf(page, 'controller-table', 'controller, now');
  check(controller[2] === '1002' && controller[3] === '1003', `late and lost: ${controller}`);
}

async function goesOn(page) {
  const seen = await page.evaluate(() => window.stillframe.views);
  const before = await rowOf(page, 'channels-table', 'SF_MEASUREMENT');
  await until(page, (n) => window.stillframe.views >= n, seen + 4);
  const after = await rowOf(page, 'channels-table', 'SF_MEASUREMENT');
  check(Number(after[0][2]) > Number(before[0][2]), `the count of messages grows: ${before[0][2]}, ${after[0][2]}`);
  check((await page.evaluate(() => Object.values(window.stillframe.figures))).every(Boolean), 'all figures are drawn');
  console.log(`drawing a view takes ${Math.round(await page.evaluate(() => window.stillframe.drawingMs))} ms`);
}

async function run(url) {
  const isOwn = own(url);
  let run = start(madeUpRun, '1234567890123456789', '31000');
  await withPage(url, {viewport: {width: 1180, height: 900}}, async (page, problems) => {
    await showsTheRun(page);
    await goesOn(page);
    await page.screenshot({path: join(out, 'light.png'), fullPage: true});
    await page.click('#scheme');
    check(await page.evaluate(() => document.documentElement.dataset.scheme) === 'dark', 'the switch makes it dark');
    await goesOn(page);
    await page.screenshot({path: join(out, 'dark.png'), fullPage: true});

    await stop(run);
    await until(page, () => document.getElementById('notes').textContent.includes('no measurement for'));
    run = start(madeUpRun, '5', '0');
    await until(page, () => document.getElementById('facts').textContent.includes('run5'));
    await until(page, () => !document.getElementById('notes').textContent.includes('no measurement for'));
    await showsNumbersOf5(page);
    await page.setViewportSize({width: 420, height: 800});
    await goesOn(page);
    const width = await page.evaluate(() => document.documentElement.scrollWidth);
    check(width <= 420, `a narrow page is not wider than it is: ${width}`);
    await page.screenshot({path: join(out, 'narrow.png'), fullPage: true});
    forget(problems, isOwn);
  });
  // A second browser, while nothing is said, and the end of the program that serves it.
  await withPage(url, {}, async (page, problems) => {
    await until(page, () => window.stillframe?.views > 0);
    forget(problems, isOwn);
    check(problems.length === 0, `no problem before the end: ${problems}`);
    await stop(watch);
    await until(page, () => document.getElementById('state').textContent.includes('not connected'));
    problems.length = 0;  // the browser says that it tried to connect again
  });
}

async function showsNumbersOf5(page) {
  await until(page, () => document.querySelectorAll('#axes-table tbody tr').length === 2);
  check((await page.textContent('#facts')).includes('run5'), 'the other run is shown');
}

const watch = start(stillframe, 'watch', '--serve', '0');
const url = (await firstLine(watch)).match(/http:\S+/)?.[0] + '/';
try {
  await run(url);
  check(watch.exitCode === 0, `watch ends with 0: ${watch.exitCode}`);
} finally {
  started.forEach((child) => child.kill('SIGKILL'));
}
process.exit(exitCode());
