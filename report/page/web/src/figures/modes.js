// The animated pictures of the modes: time, view and size; what draws them is WebGL or, without it, a plain canvas.
import {PerspectiveCamera, Vector3} from 'three';

import {drawn, expect, onPrint} from '../charts.js';
import {colours, onScheme} from '../theme.js';
import {CanvasPictures} from './mode_canvas.js';
import {Structure} from './mode_structure.js';
import {WebglPictures} from './mode_webgl.js';

const edge = 0.02;           // of a picture's half height and width, left free on each side
const slowestPeriod = 2.4;   // s on the screen, of the slowest mode
const frameTime = 1000 / 30;  // ms: calm on laptops
const paperSize = {width: 560, height: 420};  // pixels of a picture 6 cm wide, 240 an inch

function makePictures(structure) {
  try {
    return new WebglPictures(structure);
  } catch {
    return new CanvasPictures(structure);
  }
}

function hasWebgl() {
  const context = document.createElement('canvas').getContext('webgl2');
  context?.getExtension('WEBGL_lose_context')?.loseContext();
  return Boolean(context);
}

class Modes {
  constructor(data) {
    this.structure = new Structure(data);
    this.pictures = hasWebgl() ? makePictures(this.structure) : new CanvasPictures(this.structure);
    this.canvases = data.modes.map((_, i) => document.getElementById(`fig-mode-${i + 1}`));
    this.camera = new PerspectiveCamera(26, 4 / 3);
    this.camera.up.set(0, this.structure.planar ? 1 : 0, this.structure.planar ? 0 : 1);
    this.visible = new Set(this.canvases);
    this.time = 0;
    this.moving = !matchMedia('(prefers-reduced-motion: reduce)').matches;
    this.resetView();
  }

  resetView() {
    [this.azimuth, this.elevation] = this.structure.planar ? [0, 0] : [-0.5, 0.46];
  }

  turn(dx, dy) {
    this.azimuth -= dx;
    this.elevation = Math.max(-1.5, Math.min(1.5, this.elevation + dy));
    this.draw();
  }

  /** So near that all that moves stays in the picture, from wherever it is looked at. */
  placeCamera() {
    const {camera, structure: {drawn, planar}} = this;
    const across = Math.cos(this.elevation), a = this.azimuth;
    const away = planar ? [Math.sin(a) * across, Math.sin(this.elevation), Math.cos(a) * across]
      : [Math.sin(a) * across, -Math.cos(a) * across, Math.sin(this.elevation)];
    camera.position.set(...away);
    camera.lookAt(0, 0, 0);
    camera.updateMatrix();
    const axes = [0, 1, 2].map((i) => new Vector3().setFromMatrixColumn(camera.matrix, i));  // right, up, to the eye
    const balls = drawn.map(({position, radius}) => ({at: axes.map((axis) => axis.dot(position)), radius}));
    const most = (size) => balls.reduce((largest, ball) => Math.max(largest, size(ball)), -Infinity);
    const middle = axes.map((_, i) => (most(({at, radius}) => at[i] + radius) - most(({at, radius}) => radius - at[i])) / 2);
    const slope = Math.tan(camera.fov / 2 * Math.PI / 180) * (1 - edge);
    const distance = most(({at: [x, y, z], radius}) => z + radius - middle[2] + Math.max(
      (Math.abs(x - middle[0]) + radius) / (slope * camera.aspect), (Math.abs(y - middle[1]) + radius) / slope));
    const centre = axes.reduce((sum, axis, i) => sum.addScaledVector(axis, middle[i]), new Vector3());
    camera.position.set(...away).multiplyScalar(distance).add(centre);
    camera.near = distance / 50;
    camera.far = distance * 4;
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  share(i) {
    if (!this.moving && this.time === 0) return 1;
    const {frequencies} = this.structure;
    const speed = Math.sqrt(frequencies[i] / frequencies[0]) || 1;
    return Math.cos(2 * Math.PI * this.time / slowestPeriod * speed);
  }

  /** Draws those pictures that are seen, or all at full deflection and one size for paper. */
  draw({all = false, paper = false} = {}) {
    this.placeCamera();
    const shown = this.canvases.filter((canvas) => all || paper || this.visible.has(canvas));
    if (!shown.length) return;
    const ratio = Math.min(devicePixelRatio || 1, 2), first = this.canvases[0];
    const width = paper ? paperSize.width : Math.max(1, Math.round(first.clientWidth * ratio));
    const height = paper ? paperSize.height : Math.round(width * 3 / 4);
    for (const canvas of shown) {
      if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
    }
    this.pictures.draw(shown.map((canvas) => {
      const mode = this.canvases.indexOf(canvas);
      return {canvas, mode, share: paper ? 1 : this.share(mode)};
    }), this.camera);
    shown.forEach((canvas) => drawn(canvas.id));
  }

  setColours() {
    this.pictures.setColours(colours());
    this.draw({all: true});
  }
}

function animate(modes) {
  let before = null, since = 0;
  const step = (now) => {
    if (modes.moving && !document.hidden) {
      since += Math.min(now - (before ?? now), 100);
      if (since >= frameTime) {
        modes.time += since / 1000;
        since = 0;
        if (modes.visible.size) modes.draw();
      }
    }
    before = now;
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

function control(modes) {
  const play = document.getElementById('modes-play');
  const label = () => { play.textContent = modes.moving ? 'Pause' : 'Play'; };
  play.addEventListener('click', () => {
    modes.moving = !modes.moving;
    label();
  });
  label();
  document.getElementById('modes-view').addEventListener('click', () => {
    modes.resetView();
    modes.draw();
  });
  const keys = {ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, 0.12], ArrowDown: [0, -0.12]};
  for (const canvas of modes.canvases) {
    canvas.addEventListener('pointerdown', (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener('pointermove', (event) => {
      if (canvas.hasPointerCapture(event.pointerId)) modes.turn(event.movementX * 0.009, event.movementY * 0.009);
    });
    canvas.addEventListener('keydown', (event) => {
      if (!keys[event.key]) return;
      event.preventDefault();
      modes.turn(...keys[event.key]);
    });
  }
}

function watch(modes) {
  const observer = new IntersectionObserver((entries) => {
    for (const {target, isIntersecting} of entries) {
      if (isIntersecting) modes.visible.add(target);
      else modes.visible.delete(target);
    }
    modes.draw();
  });
  modes.canvases.forEach((canvas) => observer.observe(canvas));
  addEventListener('resize', () => modes.draw({all: true}));
  onScheme(() => modes.setColours());
  onPrint((on) => modes.draw({all: true, paper: on}));
}

export function modeShapes(data) {
  data.modes.forEach((_, i) => expect(`fig-mode-${i + 1}`));
  const modes = new Modes(data);
  modes.setColours();
  control(modes);
  watch(modes);
  animate(modes);
  window.stillframe.modeRenderer = modes.pictures.constructor === CanvasPictures ? 'canvas' : 'webgl';
}
