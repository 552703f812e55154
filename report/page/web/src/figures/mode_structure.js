// What a mode shape is drawn from: bodies, struts, masses and floor points, each corner tied to the node it moves with.
import {Box3, IcosahedronGeometry, Vector3} from 'three';

const cornerSize = 0.05;  // of the size of the structure: how far a body reaches beyond its nodes
const deflection = 0.11;  // of the size: how far the node that moves most is drawn from its rest

function bodiesOf(nodes, elements) {
  const parent = nodes.map((_, i) => i);
  const root = (i) => (parent[i] === i ? i : (parent[i] = root(parent[i])));
  for (const {kind, p, q} of elements) if (kind === 'rigid') parent[root(p)] = root(q);
  const groups = new Map();
  nodes.forEach((_, i) => groups.set(root(i), [...(groups.get(root(i)) ?? []), i]));
  return [...groups.values()].filter((members) => members.length > 2);
}

/** Corners of a body: those of a small ball about each node, with the node they move with. */
function corners(members, positions, radius) {
  const ball = new IcosahedronGeometry(radius, 1).getAttribute('position');
  const list = [];
  for (const node of members) {
    const seen = new Set();
    for (let i = 0; i < ball.count; ++i) {
      const offset = new Vector3().fromBufferAttribute(ball, i);
      const key = offset.toArray().map((x) => x.toFixed(6)).join();
      if (seen.has(key)) continue;
      seen.add(key);
      list.push({node, position: positions[node].clone().add(offset)});
    }
  }
  return list;
}

export class Structure {
  constructor({nodes, elements, modes, planar}) {
    this.planar = planar;
    this.positions = nodes.map(({position}) => new Vector3(...position.map((x) => x ?? 0)));
    const box = new Box3().setFromPoints(this.positions);
    this.size = Math.max(box.getSize(new Vector3()).length(), 1e-9);
    this.elements = elements;
    this.floor = nodes.map((node, i) => (node.floor ? i : -1)).filter((i) => i >= 0);
    const heaviest = Math.max(...nodes.map(({mass}) => mass || 0));
    this.masses = nodes.map(({mass}, node) => ({node, radius: this.size * 0.055 * Math.cbrt((mass || 0) / heaviest)}))
      .filter(({radius}) => radius > 0);
    this.bodies = bodiesOf(nodes, elements).map((members) => corners(members, this.positions, cornerSize * this.size));
    this.shapes = modes.map(({displacement}) => {
      const moves = displacement.map((d) => new Vector3(...d.map((x) => x ?? 0)));
      const largest = Math.max(...moves.map((move) => move.length())) || 1;
      return moves.map((move) => move.multiplyScalar(deflection * this.size / largest));
    });
    this.drawn = this.reach();
    this.frequencies = modes.map(({frequency_hz: f}) => f);
  }

  /** Balls within which everything is that any mode draws at full deflection, either way. */
  reach() {
    const radii = this.positions.map(() => 0.03 * this.size);  // a floor point, and more than a strut
    for (const {node, radius} of this.masses) radii[node] = Math.max(radii[node], radius);
    for (const {node} of this.bodies.flat()) radii[node] = Math.max(radii[node], cornerSize * this.size);
    return this.positions.flatMap((position, node) => [{position, radius: radii[node]}, ...this.shapes.flatMap((_, m) =>
      [-1, 1].map((share) => ({position: this.moved(position, node, m, share), radius: radii[node]})))]);
  }

  /** Where a point tied to a node is when mode m has a deflection of share, -1 to 1. */
  moved(position, node, m, share, into = new Vector3()) {
    return into.copy(position).addScaledVector(this.shapes[m][node], share);
  }
}
