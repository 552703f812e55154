// Mode shapes as drawings of lines and outlines, where there is no WebGL.
import {Vector3} from 'three';

/** Convex hull of points in the plane, in order. Source: A. M. Andrew, Information Processing Letters 9 (1979). */
function outline(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1) {
        const [a, b] = chain.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        chain.pop();
      }
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

export class CanvasPictures {
  constructor(structure) {
    this.structure = structure;
  }

  setColours(c) {
    this.colours = c;
  }

  draw(pictures, camera) {
    for (const {canvas, mode, share} of pictures) this.drawOne(canvas, mode, share, camera);
  }

  drawOne(canvas, mode, share, camera) {
    const {structure, colours: c} = this;
    const context = canvas.getContext('2d');
    const {width, height} = canvas;
    const unit = height / 220;
    const project = (position, node, s) => {
      const p = structure.moved(position, node, mode, s, new Vector3());
      const depth = p.distanceTo(camera.position);
      p.project(camera);
      return [(p.x + 1) / 2 * width, (1 - p.y) / 2 * height, depth];
    };
    const path = (points, close) => {
      context.beginPath();
      points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
      if (close) context.closePath();
    };
    const element = ({p, q}, s) => [project(structure.positions[p], p, s), project(structure.positions[q], q, s)];
    const hull = (corners, s) => outline(corners.map(({position, node}) => project(position, node, s)));

    context.clearRect(0, 0, width, height);
    context.lineCap = context.lineJoin = 'round';
    context.strokeStyle = c.floor;
    context.globalAlpha = 0.7;
    context.lineWidth = unit;
    for (const e of structure.elements) path(element(e, 0)), context.stroke();
    for (const corners of structure.bodies) path(hull(corners, 0), true), context.stroke();
    context.globalAlpha = 1;

    context.fillStyle = c.muted;
    for (const node of structure.floor) {
      const [x, y] = project(structure.positions[node], node, 0);
      context.beginPath();
      context.ellipse(x, y, 5 * unit, 2.5 * unit, 0, 0, 2 * Math.PI);
      context.fill();
    }
    for (const e of structure.elements) {
      const strut = e.kind === 'truss';
      context.strokeStyle = strut ? c.passive : c.active;
      context.lineWidth = (strut ? 4 : 3) * unit;
      path(element(e, share));
      context.stroke();
    }
    for (const corners of structure.bodies) {
      path(hull(corners, share), true);
      context.fillStyle = context.strokeStyle = c.active;
      context.globalAlpha = 0.22;
      context.fill();
      context.globalAlpha = 1;
      context.lineWidth = 1.3 * unit;
      context.stroke();
    }
    context.fillStyle = c.active;
    for (const {node, radius} of structure.masses) {
      const [x, y, depth] = project(structure.positions[node], node, share);
      context.beginPath();
      context.arc(x, y, radius / depth * camera.projectionMatrix.elements[5] * height / 2, 0, 2 * Math.PI);
      context.fill();
    }
  }
}
