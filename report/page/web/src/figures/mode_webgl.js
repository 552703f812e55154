// Mode shapes by WebGL: one renderer draws all pictures, each into its part of one canvas.
import {BufferAttribute, BufferGeometry, Color, CylinderGeometry, DirectionalLight, Group,
  HemisphereLight, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, Quaternion, Scene, SphereGeometry,
  Vector3, WebGLRenderer} from 'three';
import {ConvexGeometry} from 'three/examples/jsm/geometries/ConvexGeometry.js';

const up = new Vector3(0, 1, 0);

/** A body as triangles whose corners know their nodes. */
function bodyMesh(corners, material) {
  const geometry = new ConvexGeometry(corners.map(({position}) => position));
  const position = geometry.getAttribute('position');
  const point = new Vector3();
  const tied = Array.from({length: position.count}, (_, i) => {
    point.fromBufferAttribute(position, i);
    return corners.reduce((a, b) =>
      (b.position.distanceToSquared(point) < a.position.distanceToSquared(point) ? b : a));
  });
  return {mesh: new Mesh(geometry, material), tied};
}

export class WebglPictures {
  constructor(structure) {
    this.structure = structure;
    this.renderer = new WebGLRenderer({alpha: true, antialias: true, powerPreference: 'low-power'});
    this.renderer.setScissorTest(true);
    this.scene = new Scene();
    this.sky = new HemisphereLight(0xffffff, 0x8a98a6, 3.2);
    this.sun = new DirectionalLight(0xffffff, 1.4);
    this.scene.add(this.sky, this.sun);
    this.materials = {
      body: new MeshLambertMaterial({transparent: true, opacity: 0.42, depthWrite: false}),
      arm: new MeshLambertMaterial(), strut: new MeshLambertMaterial(), mass: new MeshLambertMaterial(),
      ground: new MeshLambertMaterial(), rest: new LineBasicMaterial({transparent: true, opacity: 0.75}),
    };
    this.addRest();
    this.addMoving();
  }

  addRest() {
    const {elements, positions} = this.structure;
    const ends = elements.flatMap(({p, q}) => [positions[p], positions[q]]);
    this.scene.add(new LineSegments(new BufferGeometry().setFromPoints(ends), this.materials.rest));
  }

  addMoving() {
    const {structure, materials} = this;
    const {size} = structure;
    const tube = new CylinderGeometry(1, 1, 1, 14);
    this.tubes = structure.elements.map((element) => {
      const strut = element.kind === 'truss';
      const mesh = new Mesh(tube, strut ? materials.strut : materials.arm);
      return {...element, mesh, radius: size * (strut ? 0.011 : 0.008)};
    });
    const ball = new SphereGeometry(1, 28, 18);
    this.balls = structure.masses.map(({node, radius}) => {
      const mesh = new Mesh(ball, materials.mass);
      mesh.scale.setScalar(radius);
      return {node, mesh};
    });
    this.bodies = structure.bodies.map((corners) => bodyMesh(corners, materials.body));
    const pad = new CylinderGeometry(0.03 * size, 0.03 * size, 0.008 * size, 24);
    pad.rotateX(Math.PI / 2);
    const pads = new Group();
    for (const node of structure.floor) {
      const mesh = new Mesh(pad, materials.ground);
      mesh.position.copy(structure.positions[node]);
      pads.add(mesh);
    }
    this.scene.add(pads, ...this.tubes.map(({mesh}) => mesh), ...[...this.balls, ...this.bodies].map(({mesh}) => mesh));
  }

  setColours(c) {
    const {body, arm, strut, mass, ground, rest} = this.materials;
    body.color = new Color(c.active);
    arm.color = new Color(c.active);
    strut.color = new Color(c.passive);
    mass.color = new Color(c.active);
    ground.color = new Color(c.muted);
    rest.color = new Color(c.floor);
  }

  pose(m, share) {
    const {structure} = this;
    const a = new Vector3(), b = new Vector3(), turn = new Quaternion();
    for (const {mesh, p, q, radius} of this.tubes) {
      structure.moved(structure.positions[p], p, m, share, a);
      structure.moved(structure.positions[q], q, m, share, b);
      mesh.position.addVectors(a, b).multiplyScalar(0.5);
      b.sub(a);
      mesh.scale.set(radius, Math.max(b.length(), 1e-9), radius);
      mesh.quaternion.copy(turn.setFromUnitVectors(up, b.normalize()));
    }
    for (const {mesh, node} of this.balls) structure.moved(structure.positions[node], node, m, share, mesh.position);
    for (const {mesh, tied} of this.bodies) {
      const position = mesh.geometry.getAttribute('position');
      tied.forEach((corner, i) => {
        structure.moved(corner.position, corner.node, m, share, a);
        position.setXYZ(i, a.x, a.y, a.z);
      });
      position.needsUpdate = true;
      mesh.geometry.computeBoundingSphere();
    }
  }

  /** Draws pictures, each {canvas, mode, share}, canvases of one size, as a camera sees them. */
  draw(pictures, camera) {
    const width = pictures[0].canvas.width, height = pictures[0].canvas.height;
    const size = this.renderer.getSize({set(x, y) { Object.assign(this, {x, y}); return this; }});
    if (size.x !== width || size.y !== height * pictures.length) {
      this.renderer.setSize(width, height * pictures.length, false);
    }
    this.sun.position.copy(camera.position).add(new Vector3(0, 0, this.structure.size));
    pictures.forEach(({mode, share}, i) => {
      this.pose(mode, share);
      this.renderer.setViewport(0, i * height, width, height);
      this.renderer.setScissor(0, i * height, width, height);
      this.renderer.render(this.scene, camera);
    });
    pictures.forEach(({canvas}, i) => {
      const context = canvas.getContext('2d');
      context.clearRect(0, 0, width, height);
      // WebGL counts rows from below.
      context.drawImage(this.renderer.domElement, 0, (pictures.length - 1 - i) * height, width, height, 0, 0, width, height);
    });
  }
}
