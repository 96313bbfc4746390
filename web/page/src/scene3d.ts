// SPDX-License-Identifier: BSD-3-Clause
// The 3D view, in W: x east, y north, z up. Loaded beside the frame of the page, not before it.
import {
  BoxGeometry, BufferGeometry, CanvasTexture, Color, ConeGeometry, CircleGeometry, CylinderGeometry, DirectionalLight,
  DoubleSide, Float32BufferAttribute, Fog, Group, HemisphereLight, Line, LineBasicMaterial, LineDashedMaterial, LineLoop,
  LineSegments, MathUtils, Mesh, MeshBasicMaterial, MeshLambertMaterial, type Object3D, PerspectiveCamera, PlaneGeometry,
  Points, PointsMaterial, Quaternion, Raycaster, Plane, Scene, SphereGeometry, Sprite, SpriteMaterial, Vector2, Vector3,
  WebGLRenderer, WireframeGeometry, BackSide, BufferAttribute,
} from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {Line2} from 'three/examples/jsm/lines/Line2.js';
import {LineGeometry} from 'three/examples/jsm/lines/LineGeometry.js';
import {LineMaterial} from 'three/examples/jsm/lines/LineMaterial.js';
import {kStale_s, type Bench, type Motion} from './bench.ts';
import {distance, type Quat, type Vec3} from './frames.ts';
import {fixed} from './numbers.ts';
import type {Camera} from './page.ts';
import type {Part, SceneVehicle} from './protocol.ts';
import {between, indexAt, waysTo, type Series} from './series.ts';
import {colour} from './theme.ts';

const kThrustScale_m_n = 0.075;
const kGrid_m = 26;
const kTrailLive_s = 12;
/** Returns of lidars so far above or below a vehicle are hardly in its way. */
const kLevel_m = 1.5;
const kChange_s = 0.25;
const kRotorSlowness = 50;
/** Without a graphics card: pixels of the drawing for one of the screen, and the time between two pictures. */
const kSlowRatio = 0.6;
const kSlowPeriod_s = 0.1;

/** How much is seen: the distance of the camera from what it looks at decides. */
export interface Scale {
  /** Lines of the grid, m. */
  step_m: 1 | 10 | 100;
  /** Times the vehicles are drawn larger than they are, so that they are seen. */
  enlarged: number;
}

export function stepFor(distance_m: number): 1 | 10 | 100 {
  return distance_m < 25 ? 1 : distance_m < 400 ? 10 : 100;
}

/** A vehicle's reach is drawn no smaller than this share of its distance. */
const kLeastReach = 0.018;

/** Lines each metre, strong ones each 5 m, that fade out into the ground. */
function makeGrid(): LineSegments {
  const ground = hex('gnd');
  const points: number[] = [];
  const colours: number[] = [];
  const mixed = new Color();
  const add = (x: number, y: number, line: Color) => {
    mixed.lerpColors(line, ground, Math.min(1, Math.hypot(x, y) / kGrid_m));
    points.push(x, y, 0);
    colours.push(mixed.r, mixed.g, mixed.b);
  };
  for (let i = -kGrid_m; i <= kGrid_m; ++i) {
    const line = hex(i % 5 === 0 ? 'grid2' : 'grid');
    const half = Math.floor(Math.sqrt(kGrid_m ** 2 - i ** 2));
    for (let j = -half; j < half; ++j) {
      add(i, j, line);
      add(i, j + 1, line);
      add(j, i, line);
      add(j + 1, i, line);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(points, 3));
  geometry.setAttribute('color', new Float32BufferAttribute(colours, 3));
  return new LineSegments(geometry, new LineBasicMaterial({vertexColors: true, depthWrite: false}));
}

/** A label over the view. */
export interface Tag {
  id: string;
  kind: 'est' | 'ref' | 'axis';
  text: string;
  x: number;
  y: number;
  /** Where its line begins; nothing without one. */
  from?: [number, number];
}

type SeriesOf = (vehicle: number, key: string) => Series | undefined;

interface Craft {
  group: Group;
  /** All but the rotors: goes where the vehicle has meshes of its own. */
  standIn: Group;
  /** From its middle to its farthest part, m. */
  reach: number;
  surfaces: {hinge: Group; index: number; sign: number}[];
  discs: {fill: MeshBasicMaterial; blades: Group; arrow: Group; k_f: number; omegaMax: number; spin: number; angle: number}[];
}

const hex = (name: string): Color => new Color(colour(name));

function segments(points: number[], material: LineBasicMaterial | LineDashedMaterial): LineSegments {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(points, 3));
  const lines = new LineSegments(geometry, material);
  lines.computeLineDistances();
  return lines;
}

function circlePoints(radius: number, parts = 40): Vector3[] {
  return Array.from({length: parts}, (_, i) => {
    const a = (2 * Math.PI * i) / parts;
    return new Vector3(radius * Math.cos(a), radius * Math.sin(a), 0);
  });
}

/** Turns z to an axis. */
function toAxis(axis: Vec3): Quaternion {
  return new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...axis).normalize());
}

function place(object: Object3D, p: Vec3, q: Quat): void {
  object.position.set(...p);
  object.quaternion.set(q[1], q[2], q[3], q[0]);
}

/** A vehicle without rotors in its description still is something to look at. */
const kUnknown: SceneVehicle = {name: 'vehicle', rotors: []};

function armOf(scene: SceneVehicle): number {
  return Math.max(0.12, ...scene.rotors.map((rotor) => Math.hypot(rotor.p_B[0], rotor.p_B[1])));
}

/** From the vehicle's middle to its farthest part. */
function reachOf(scene: SceneVehicle): number {
  const parts = [...(scene.visuals ?? []), ...(scene.parts ?? [])].map((part) =>
    Math.hypot(...part.p) + (part.size_m ? Math.max(...part.size_m) / 2 : Math.max(part.radius_m ?? 0, (part.length_m ?? 0) / 2)));
  return Math.max(armOf(scene), ...parts);
}

/** The stand-in: arms to the real hubs, discs of the real radius, the nose marked. */
function makeCraft(scene: SceneVehicle): Craft {
  const group = new Group();
  const standIn = new Group();
  group.add(standIn);
  const arm = armOf(scene);
  const body = new MeshLambertMaterial({color: hex('t3')});
  const dark = new MeshLambertMaterial({color: hex('t2')});
  const nose = new MeshLambertMaterial({color: hex('acc'), emissive: hex('acc'), emissiveIntensity: 0.35});
  const add = (geometry: BufferGeometry, material: MeshLambertMaterial, x: number, y: number, z: number) => {
    const mesh = new Mesh(geometry, material);
    mesh.position.set(x, y, z);
    standIn.add(mesh);
  };
  add(new BoxGeometry(0.9 * arm, 0.42 * arm, 0.22 * arm), body, 0, 0, 0);
  add(new BoxGeometry(0.26 * arm, 0.3 * arm, 0.1 * arm), nose, 0.42 * arm, 0, 0.1 * arm);
  for (const side of [-1, 1]) {  // landing gear
    add(new BoxGeometry(1.1 * arm, 0.03 * arm, 0.03 * arm), dark, 0, side * 0.45 * arm, -0.42 * arm);
    for (const x of [-0.3, 0.3]) {
      const leg = new Mesh(new CylinderGeometry(0.016 * arm, 0.016 * arm, 0.42 * arm), dark);
      leg.rotation.x = Math.PI / 2 + side * 0.35;
      leg.position.set(x * arm, side * 0.36 * arm, -0.24 * arm);
      standIn.add(leg);
    }
  }
  const discs = scene.rotors.map((rotor) => {
    const hub = new Vector3(...rotor.p_B);
    const length = hub.length();
    if (length > 0.01) {
      const strut = new Mesh(new CylinderGeometry(0.045 * arm, 0.045 * arm, length), dark);
      strut.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), hub.clone().normalize());
      strut.position.copy(hub).multiplyScalar(0.5);
      standIn.add(strut);
    }
    const front = rotor.p_B[0] > 0.01;
    const tint = hex(front ? 'acc' : 't2');
    const disc = new Group();
    disc.position.copy(hub).addScaledVector(new Vector3(...rotor.axis_B), 0.03);
    disc.quaternion.copy(toAxis(rotor.axis_B));
    const fill = new MeshBasicMaterial({color: tint, transparent: true, opacity: 0.2, side: DoubleSide, depthWrite: false});
    disc.add(new Mesh(new CircleGeometry(rotor.radius_m, 40), fill));
    const rim = new LineLoop(new BufferGeometry().setFromPoints(circlePoints(rotor.radius_m)), new LineBasicMaterial({color: tint}));
    disc.add(rim);
    const blades = new Group();
    const blade = new Mesh(new PlaneGeometry(rotor.radius_m * 1.9, rotor.radius_m * 0.14),
      new MeshBasicMaterial({color: tint, side: DoubleSide}));
    blades.add(blade);
    disc.add(blades);
    const arrow = new Group();  // along z, one metre long, scaled
    const green = new MeshBasicMaterial({color: hex('act')});
    const shaft = new Mesh(new CylinderGeometry(0.008, 0.008, 1), green);
    shaft.rotation.x = Math.PI / 2;
    shaft.position.z = 0.5;
    shaft.name = 'shaft';
    const tip = new Mesh(new ConeGeometry(0.025, 0.06), green);
    tip.rotation.x = Math.PI / 2;
    tip.name = 'tip';
    arrow.add(shaft, tip);
    disc.add(arrow);
    group.add(disc);
    return {fill, blades, arrow, k_f: rotor.k_f, omegaMax: rotor.omega_max_rad_s, spin: rotor.spin, angle: 0};
  });
  return {group, standIn, discs, reach: reachOf(scene), surfaces: []};
}

/** The vehicle as dashed wire. */
function makeGhost(scene: SceneVehicle, name: string): Group {
  const group = new Group();
  const arm = armOf(scene);
  const material = new LineDashedMaterial({color: hex(name), dashSize: 0.12 * arm, gapSize: 0.08 * arm});
  const points: number[] = [];
  for (const rotor of scene.rotors) {
    points.push(0, 0, 0, ...rotor.p_B);
    const ring = circlePoints(rotor.radius_m, 32).map((v) => v.applyQuaternion(toAxis(rotor.axis_B)).add(new Vector3(...rotor.p_B)));
    const loop = new Line(new BufferGeometry().setFromPoints([...ring, ring[0]!]), material);
    loop.computeLineDistances();
    group.add(loop);
  }
  points.push(0, 0, 0, arm * 0.8, 0, 0);
  group.add(segments(points, material));
  return group;
}

function makePart(part: Part, material: MeshLambertMaterial): Object3D | null {
  if (part.shape === 'box' && part.size_m) return new Mesh(new BoxGeometry(...part.size_m), material);
  if (part.shape === 'sphere') return new Mesh(new SphereGeometry(part.radius_m ?? 0.1, 24, 16), material);
  if (part.shape === 'cylinder') {
    const mesh = new Mesh(new CylinderGeometry(part.radius_m, part.radius_m, part.length_m, 32), material);
    mesh.rotation.x = Math.PI / 2;
    return new Group().add(mesh);
  }
  return null;
}

/** The ground, tinted by its height, with the edges of its triangles. */
function makeTerrain(geometry: BufferGeometry): Object3D {
  const position = geometry.getAttribute('position');
  const heights = Array.from({length: position.count}, (_, i) => position.getZ(i));
  const lowest = heights.reduce((a, b) => Math.min(a, b), Infinity);
  const range = Math.max(1, heights.reduce((a, b) => Math.max(a, b), -Infinity) - lowest);
  const mixed = new Color();
  const [low, high] = [hex('gnd'), hex('t3')];
  const colours = heights.flatMap((height) => mixed.lerpColors(low, high, (0.7 * (height - lowest)) / range).toArray());
  geometry.setAttribute('color', new Float32BufferAttribute(colours, 3));
  const edges = new LineBasicMaterial({color: hex('t3'), transparent: true, opacity: 0.25});
  return new Group().add(new Mesh(geometry, new MeshLambertMaterial({vertexColors: true, side: DoubleSide})),
    new LineSegments(new WireframeGeometry(geometry), edges));
}

/** Triangles as docs/develop/web_protocol.md has them: of a record the record's own, else by their hash; null where there are none. */
async function loadTriangles(mesh: string, own?: string[]): Promise<BufferGeometry | null> {
  const packed = own?.[Number(mesh)];
  let bytes: ArrayBuffer;
  if (packed !== undefined) {
    bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0)).buffer;
  } else {
    const answer = await fetch(`/mesh/${mesh.replace('sha256:', '')}`).catch(() => null);
    if (!answer?.ok) return null;
    bytes = await answer.arrayBuffer();
  }
  const [vertices, triangles] = new Uint32Array(bytes, 0, 2) as unknown as [number, number];
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(bytes, 8, vertices * 3), 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(bytes, 8 + vertices * 12, triangles * 3), 1));
  geometry.computeVertexNormals();
  return geometry;
}

/** Ring with a cross: where the vehicle is to be. */
function referenceTexture(): CanvasTexture {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 64;
  const g = canvas.getContext('2d')!;
  g.strokeStyle = colour('ref');
  g.lineWidth = 5;
  g.beginPath();
  g.arc(32, 32, 17, 0, 7);
  g.stroke();
  g.lineWidth = 2.5;
  g.beginPath();
  g.moveTo(2, 32);
  g.lineTo(62, 32);
  g.moveTo(32, 2);
  g.lineTo(32, 62);
  g.stroke();
  return new CanvasTexture(canvas);
}

/** Colour of an error: blue 0, the vehicle's own at half, amber at the limit, red above. */
function errorColour(share: number, stops: Color[], into: Color): Color {
  if (share < 0.5) return into.lerpColors(stops[0]!, stops[1]!, share * 2);
  if (share <= 1) return into.lerpColors(stops[1]!, stops[2]!, (share - 0.5) * 2);
  return into.copy(stops[3]!);
}

export class View3D {
  frames = 0;
  camera: PerspectiveCamera;
  tags: Tag[] = [];
  private readonly renderer: WebGLRenderer;
  private readonly controls: OrbitControls;
  private scene = new Scene();
  private readonly past: Scene[] = [];
  /** The processor draws: fewer pixels, fewer pictures. */
  private readonly slow: boolean;
  private drawn_s = -1;
  private crafts: Craft[] = [];
  private readonly cloudMaterial = new PointsMaterial({vertexColors: true, size: 3, sizeAttenuation: false});
  private ghost?: Group;
  private besideGhost?: Group;
  private trail?: Line2;
  private besideTrail?: Line2;
  private trailMaterial!: LineMaterial;
  private reference!: Sprite;
  private cloud?: Points;
  private clouds?: Bench['clouds'];
  /** Returns of lidars in the picture. */
  returns = 0;
  private path?: Points;
  private pathKey = '';
  private drop!: Line;
  private ring!: Sprite;
  private shadowTrail?: Line;
  private winds: Group[] = [];
  private gridHolder = new Group();
  private readonly backdrop = new Group();
  private axes!: LineSegments;
  private hasTerrain = false;
  /** Of the newest picture. */
  scale: Scale = {step_m: 1, enlarged: 1};
  private mode: Camera = 'follow';
  private last_s = 0;
  private changing = 0;
  private from?: {position: Vector3; target: Vector3};
  private readonly offset = new Vector3(-1.35, -1.9, 0.85);
  /** Where the camera goes, while it is on its way there. */
  private goal?: Vector3;
  private built = '';
  private shown = '';
  private meshes = 0;
  private trailKey = '';
  private lastPosition: Vector3 | null = null;
  private readonly sides = new Map<string, boolean>();
  private readonly still = matchMedia('(prefers-reduced-motion: reduce)');

  /** @throws Error where there is no WebGL */
  constructor(canvas: HTMLCanvasElement, private readonly series: SeriesOf) {
    const attributes = {alpha: true, depth: true, stencil: false, antialias: true, powerPreference: 'high-performance'} as const;
    const quick = canvas.getContext('webgl2', {...attributes, failIfMajorPerformanceCaveat: true});
    const context = quick ?? canvas.getContext('webgl2', {...attributes, antialias: false});
    this.slow = !quick;
    this.renderer = new WebGLRenderer({canvas, ...(context ? {context} : {})});
    // To look for errors is to wait for each shader's end; without a graphics card that is seconds.
    this.renderer.debug.checkShaderErrors = false;
    this.renderer.setPixelRatio(this.slow ? kSlowRatio : Math.min(2, window.devicePixelRatio || 1));
    this.camera = new PerspectiveCamera(46, 1, 0.05, 2000);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-4, -4.6, 4.6);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.maxPolarAngle = Math.PI * 0.495;
    this.controls.minDistance = 0.4;
    this.controls.maxDistance = 20000;
  }

  /** Vehicles that are drawn by meshes of their own. */
  get ownMeshes(): number {
    return this.crafts.filter((craft) => !craft.standIn.visible).length;
  }

  /** Of the world, that are drawn. */
  worldParts = 0;

  /** Numbers of the compiled shader programs. */
  get programs(): number[] {
    return (this.renderer.info.programs ?? []).map((program) => (program as unknown as {id: number}).id);
  }

  /** Draws in the colours of the theme anew. */
  restyle(): void {
    this.built = '';
  }

  setCamera(mode: Camera): void {
    if (mode === this.mode) return;
    this.from = {position: this.camera.position.clone(), target: this.controls.target.clone()};
    this.changing = this.still.matches ? 0 : kChange_s;
    this.mode = mode;
    this.lastPosition = null;
    this.goal = undefined;
    this.controls.enableRotate = mode !== 'top';
    if (mode === 'follow') this.offset.set(-1.35, -1.9, 0.85);
  }

  /** Where a ray from the pointer meets the ground, in W. */
  groundAt(x: number, y: number): Vec3 | null {
    const {clientWidth, clientHeight} = this.renderer.domElement;
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((x / clientWidth) * 2 - 1, 1 - (y / clientHeight) * 2), this.camera);
    const hit = ray.ray.intersectPlane(new Plane(new Vector3(0, 0, 1), 0), new Vector3());
    return hit ? [hit.x, hit.y, hit.z] : null;
  }

  /** Puts the camera where the whole flight is seen. */
  frameAll(bench: Bench): void {
    const far = this.extent(bench);
    this.controls.target.set(far.centre[0], far.centre[1], far.centre[2]);
    const back = Math.max(2.2, far.size * 1.8);  // a vehicle at the top of its flight is whole
    this.camera.position.set(far.centre[0] - 0.55 * back, far.centre[1] - 0.72 * back, far.centre[2] + 0.55 * back);
  }

  private extent(bench: Bench): {centre: Vec3; size: number} {
    const low: Vec3 = [0, 0, 0];
    const high: Vec3 = [0, 0, 1];
    bench.vehicles.forEach((vehicle, i) => {
      (['e', 'n', 'u'] as const).forEach((axis, k) => {
        const series = this.series(i, `truth.${axis}`) ?? this.series(i, `est.${axis}`);
        if (series) {
          for (let j = 0; j < series.v.length; j += 10) {
            low[k] = Math.min(low[k]!, series.v[j]!);
            high[k] = Math.max(high[k]!, series.v[j]!);
          }
        }
        const p = vehicle.sim?.p[k];
        if (p !== undefined) {
          low[k] = Math.min(low[k]!, p);
          high[k] = Math.max(high[k]!, p);
        }
      });
    });
    const centre = low.map((value, k) => (value + high[k]!) / 2) as Vec3;
    return {centre, size: Math.max(2, ...low.map((value, k) => high[k]! - value))};
  }

  /** Builds the static parts: when the vehicles, the theme or the selection change. */
  private build(bench: Bench): void {
    const key = `${document.documentElement.dataset.theme}|${bench.selected}|${bench.vehicles.map((v) => v.name + (v.scene?.rotors.length ?? 0)).join()}|${bench.scene?.hash}|${bench.beside.length}`;
    if (key === this.built) return;
    const first = this.built === '';
    this.built = key;
    this.past.push(this.scene);
    this.scene = new Scene();
    this.scene.background = hex('sky2');
    this.scene.fog = new Fog(hex('sky2'), 9, kGrid_m + 22);
    const light = new DirectionalLight('#ffffff', 2.2);
    light.position.set(-3, -4, 9);
    this.scene.add(light, new HemisphereLight('#ffffff', '#556070', 1.6));
    this.addSkyAndGround();
    this.addAxes();
    this.addWorld(bench);
    this.crafts = bench.vehicles.map((vehicle) => makeCraft(vehicle.scene ?? kUnknown));
    for (const {group} of this.crafts) this.scene.add(group);
    bench.vehicles.forEach((vehicle, i) => void this.addVisuals(vehicle.scene, this.crafts[i]!));
    const own = bench.vehicle?.scene ?? kUnknown;
    this.ghost = makeGhost(own, 'est');
    this.besideGhost = bench.beside.length > 0 ? makeGhost(own, 't2') : undefined;
    this.scene.add(this.ghost);
    if (this.besideGhost) this.scene.add(this.besideGhost);
    this.addTrail();
    this.reference = new Sprite(new SpriteMaterial({map: referenceTexture(), sizeAttenuation: false, depthTest: false, fog: false}));
    this.reference.scale.setScalar(0.032);
    this.drop = new Line(new BufferGeometry().setFromPoints([new Vector3(), new Vector3(0, 0, 1)]),
      new LineDashedMaterial({color: hex('t3'), dashSize: 0.008, gapSize: 0.014}));
    this.drop.computeLineDistances();
    this.ring = new Sprite(new SpriteMaterial({map: referenceTexture(), sizeAttenuation: false, depthTest: false, color: hex('t1')}));
    this.ring.scale.setScalar(0.03);
    this.ring.visible = false;
    this.scene.add(this.reference, this.drop, this.ring);
    this.addWind();
    this.path = undefined;
    this.cloud = undefined;
    this.clouds = undefined;
    this.trailKey = '';
    if (first) this.frameAll(bench);
  }

  /**
   * Frees scenes that are shown no more, after the new one was drawn: a program that no material uses is deleted, and to
   * recompile them all takes a processor without a graphics card many seconds. The newest of them stays: objects that the
   * new scene does not show yet, such as its trail, take their programs from there.
   */
  private disposePast(): void {
    for (const scene of this.past.splice(0, Math.max(0, this.past.length - 1))) {
      scene.traverse((object) => {
        const mesh = object as Mesh;
        mesh.geometry?.dispose();
        for (const material of [mesh.material].flat()) material?.dispose();
      });
    }
  }

  private addSkyAndGround(): void {
    const dome = new SphereGeometry(900, 24, 16);
    const [high, low] = [hex('sky1'), hex('sky2')];
    const colours: number[] = [];
    const position = dome.getAttribute('position');
    const mixed = new Color();
    for (let i = 0; i < position.count; ++i) {
      mixed.lerpColors(low, high, MathUtils.clamp(position.getY(i) / 420, 0, 1));
      colours.push(mixed.r, mixed.g, mixed.b);
    }
    dome.setAttribute('color', new Float32BufferAttribute(colours, 3));
    const sky = new Mesh(dome, new MeshBasicMaterial({vertexColors: true, side: BackSide, fog: false, depthWrite: false, depthTest: false}));
    sky.rotation.x = Math.PI / 2;
    sky.renderOrder = -2;
    const ground = new Mesh(new CircleGeometry(700, 48), new MeshBasicMaterial({color: hex('gnd'), depthWrite: false, depthTest: false}));
    ground.renderOrder = -1;
    this.backdrop.clear();
    this.backdrop.add(sky, ground);
    this.scene.add(this.backdrop);
    this.gridHolder = new Group();
    this.gridHolder.add(makeGrid());
    this.scene.add(this.gridHolder);
  }

  private addAxes(): void {
    this.axes = segments([0, 0, 0, 0, 5, 0, 0, 0, 0, 5, 0, 0], new LineBasicMaterial({color: hex('t3')}));
    this.scene.add(this.axes);
  }

  private addWorld(bench: Bench): void {
    const material = new MeshLambertMaterial({color: hex('grid2'), side: DoubleSide});
    this.worldParts = 0;
    this.hasTerrain = bench.scene?.world?.some((part) => part.name === 'terrain') ?? false;
    for (const part of bench.scene?.world ?? []) {
      const mesh = makePart(part, material);
      if (mesh) {
        const holder = new Group().add(mesh);
        place(holder, part.p, part.q);
        this.scene.add(holder);
        this.worldParts++;
      } else if (part.shape === 'mesh' && part.mesh) {
        void this.addMesh(part, material, bench.scene?.meshes);
      }
    }
  }

  private async addMesh(part: Part, material: MeshLambertMaterial, own?: string[]): Promise<void> {
    const scene = this.scene;
    const geometry = await loadTriangles(part.mesh!, own);
    if (!geometry) return;
    const mesh = part.name === 'terrain' ? makeTerrain(geometry) : new Mesh(geometry, material);
    place(mesh, part.p, part.q);
    scene.add(mesh);
    this.meshes++;
    if (scene === this.scene) this.worldParts++;
  }

  /** Puts a vehicle's own shapes in the place of its stand-in, once all of them are here. */
  private async addVisuals(scene: SceneVehicle | undefined, craft: Craft): Promise<void> {
    if (!scene?.visuals?.length) return;
    const material = new MeshLambertMaterial({color: hex('t3'), side: DoubleSide});
    const moving = new MeshLambertMaterial({color: hex('acc')});
    const own = new Group();
    for (const part of scene.visuals) {
      const geometry = part.shape === 'mesh' ? await loadTriangles(part.mesh ?? '', scene.meshes) : null;
      const shape = geometry ? new Mesh(geometry, material) : makePart(part, part.surface ? moving : material);
      if (!shape) return;  // the stand-in stays
      const holder = new Group();
      place(holder, part.p, part.q);
      own.add(holder);
      if (part.surface && part.size_m) {
        const hinge = new Group().add(shape);
        hinge.position.x = part.size_m[0] / 2;
        shape.position.x = -part.size_m[0] / 2;
        holder.add(hinge);
        craft.surfaces.push({hinge, ...part.surface});
      } else {
        holder.add(shape);
      }
    }
    craft.standIn.visible = false;  // kept: its materials keep their programs
    craft.group.add(own);
    this.meshes++;
  }

  private addTrail(): void {
    this.trailMaterial = new LineMaterial({linewidth: 3.5, vertexColors: true, worldUnits: false, fog: false});
    this.trail = new Line2(new LineGeometry(), this.trailMaterial);
    this.trail.visible = false;
    this.trail.frustumCulled = false;
    this.besideTrail = new Line2(new LineGeometry(),
      new LineMaterial({linewidth: 2, color: hex('t2'), dashed: true, dashSize: 0.12, gapSize: 0.1}));
    this.besideTrail.visible = false;
    this.besideTrail.frustumCulled = false;
    this.shadowTrail = new Line(new BufferGeometry(), new LineBasicMaterial({color: hex('shadow'), transparent: true, opacity: 0.5}));
    this.shadowTrail.frustumCulled = false;
    this.scene.add(this.trail, this.besideTrail, this.shadowTrail);
  }

  private addWind(): void {
    this.winds = Array.from({length: 5}, () => {
      const group = new Group();
      const material = new LineBasicMaterial({color: hex('t2'), transparent: true, opacity: 0.55});
      group.add(segments([0, 0, 0, 1, 0, 0, 1, 0, 0, 0.85, 0.07, 0, 1, 0, 0, 0.85, -0.07, 0], material));
      group.visible = false;
      this.scene.add(group);
      return group;
    });
  }

  /** One picture. */
  draw(bench: Bench, now_s: number, replay: boolean): void {
    const canvas = this.renderer.domElement;
    const [w, h] = [canvas.parentElement!.clientWidth, canvas.parentElement!.clientHeight];
    if (w === 0 || h === 0) return;
    const passed = Math.min(0.1, now_s - this.last_s);
    this.last_s = now_s;
    const size = this.renderer.getSize(new Vector2());
    if (size.x !== w || size.y !== h) {
      this.renderer.setSize(w, h, false);
      this.camera.aspect = w / h;
      this.camera.updateProjectionMatrix();
    }
    this.build(bench);
    this.moveVehicles(bench, passed);
    this.moveMarks(bench, replay);
    this.moveCloud(bench);
    this.moveTrail(bench, replay);
    this.moveWind(bench);
    this.moveCamera(bench, passed);
    this.moveScale(bench);
    const places = bench.vehicles.map((vehicle) => [bench.motion(vehicle)?.motion.p, bench.estimate(vehicle)?.p]);
    const shown = `${this.built}|${bench.time_s}|${bench.paused}|${places.join()}|${w}x${h}|${this.camera.matrixWorld.elements.join()}|${this.meshes}|${this.cloud?.id}`;
    if (shown === this.shown && this.changing === 0) return;  // nothing moved
    if (this.slow && now_s - this.drawn_s < kSlowPeriod_s) return;
    this.drawn_s = now_s;
    this.shown = shown;
    this.renderer.render(this.scene, this.camera);
    this.disposePast();
    this.tags = this.placeTags(bench, w, h);
    this.frames++;
  }

  private moveVehicles(bench: Bench, passed: number): void {
    this.crafts.forEach((craft, i) => {
      const shown = bench.motion(bench.vehicles[i]);
      craft.group.visible = Boolean(shown);
      if (!shown) return;
      place(craft.group, shown.motion.p, shown.motion.q);
      const deflections = bench.vehicles[i]?.sim?.surfaces;
      for (const {hinge, index, sign} of craft.surfaces) hinge.rotation.y = sign * (deflections?.[index] ?? 0);
      const omega = bench.vehicles[i]?.sim?.rotors;
      craft.discs.forEach((disc, k) => {
        const speed = omega?.[k] ?? 0;
        const share = disc.omegaMax > 0 ? speed / disc.omegaMax : 0;
        disc.fill.opacity = 0.08 + 0.28 * Math.min(1, share);
        if (!bench.paused && !this.still.matches) disc.angle += (disc.spin * speed * passed) / kRotorSlowness;
        disc.blades.rotation.z = disc.angle;
        disc.blades.visible = !this.still.matches;
        const length = disc.k_f * speed * speed * kThrustScale_m_n;
        disc.arrow.visible = length > 0.02;
        disc.arrow.children[0]!.scale.set(1, Math.max(1e-3, length), 1);
        disc.arrow.children[0]!.position.z = length / 2;
        disc.arrow.children[1]!.position.z = length;
      });
    });
  }

  /** Grid, fog and the vehicles' size for the distance of the camera. */
  private moveScale(bench: Bench): void {
    const {camera} = this;
    // From high above the ground is far away, however near the vehicle is.
    const away = Math.max(camera.position.distanceTo(this.controls.target), Math.abs(camera.position.z));
    const step_m = stepFor(away);
    this.gridHolder.scale.set(step_m, step_m, 1);
    this.gridHolder.visible = !this.hasTerrain;
    this.axes.scale.setScalar(step_m);
    const fog = this.scene.fog as Fog;
    fog.near = Math.max(9, 1.5 * away, this.hasTerrain ? 1000 : 0);
    fog.far = Math.max(kGrid_m + 22, 6 * away, this.hasTerrain ? 8000 : 0);
    camera.near = Math.max(0.05, away / 400);
    camera.far = Math.max(2000, 40 * away, this.hasTerrain ? 20000 : 0);
    camera.updateProjectionMatrix();
    this.backdrop.scale.set(camera.far / 2000, camera.far / 2000, 1);
    this.backdrop.children[0]!.scale.y = camera.far / 2000;  // its own y is up
    this.backdrop.position.set(camera.position.x, camera.position.y, 0);
    let enlarged = 1;
    this.crafts.forEach((craft, i) => {
      const least = (kLeastReach * camera.position.distanceTo(craft.group.position)) / craft.reach;
      craft.group.scale.setScalar(Math.max(1, least));
      if (bench.vehicles[i] === bench.vehicle) enlarged = Math.max(1, least);
    });
    this.ghost!.scale.setScalar(enlarged);
    this.besideGhost?.scale.setScalar(enlarged);
    this.scale = {step_m, enlarged};
  }

  private moveMarks(bench: Bench, replay: boolean): void {
    const estimate = bench.estimate();
    const truth = bench.truth();
    this.ghost!.visible = Boolean(estimate && truth);
    if (estimate && truth) place(this.ghost!, estimate.p, estimate.q);
    const beside = bench.beside[bench.selected];
    if (this.besideGhost) {
      this.besideGhost.visible = Boolean(beside);
      if (beside) place(this.besideGhost, beside.p, beside.q);
    }
    const reference = bench.vehicle?.reference;
    this.reference.visible = Boolean(reference);
    if (reference) this.reference.position.set(...reference.p_W);
    const shown = bench.motion();
    this.drop.visible = Boolean(shown);
    if (shown) {
      this.drop.position.set(shown.motion.p[0], shown.motion.p[1], 0);
      this.drop.scale.z = Math.max(0.001, shown.motion.p[2]);
      const strong_m = 5 * this.scale.step_m;
      this.gridHolder.position.x = Math.round(shown.motion.p[0] / strong_m) * strong_m;
      this.gridHolder.position.y = Math.round(shown.motion.p[1] / strong_m) * strong_m;
    }
    const key = replay ? 'whole' : String(Math.floor(bench.time_s ?? 0));
    if (this.path && key === this.pathKey) return;
    this.pathKey = key;
    this.makePath(bench);
  }

  /** The ordered path, dotted: of a record the whole, live as far as it is known. */
  private makePath(bench: Bench): void {
    const [n, e, u] = ['n', 'e', 'u'].map((axis) => this.series(bench.selected, `ref.${axis}`));
    const points: number[] = [];
    if (n && e && u) {
      const gap = Math.max(0.09, this.extent(bench).size / 250);
      let last: Vec3 | null = null;
      for (let i = 0; i < n.t.length; ++i) {
        const p: Vec3 = [e.v[i]!, n.v[i]!, u.v[i]!];
        if (last && distance(last, p) < gap) continue;
        points.push(...p);
        last = p;
      }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new Float32BufferAttribute(points, 3));
    if (this.path) {
      this.path.geometry.dispose();
      this.path.geometry = geometry;
      return;
    }
    this.path = new Points(geometry, new PointsMaterial({color: hex('ref'), size: 2.2, sizeAttenuation: false, transparent: true, opacity: 0.8}));
    this.path.frustumCulled = false;
    this.scene.add(this.path);
  }

  /** Returns of the lidars: strong at the height of the vehicle, where they are in its way. */
  private moveCloud(bench: Bench): void {
    if (bench.clouds === this.clouds) return;
    this.clouds = bench.clouds;
    if (this.cloud) {
      this.scene.remove(this.cloud);
      this.cloud.geometry.dispose();
      this.cloud = undefined;
    }
    const points = bench.clouds.v.flatMap((places) => Array.from(places));
    this.returns = points.length / 3;
    if (points.length === 0) return;
    const height = bench.motion()?.motion.p[2] ?? 0;
    const [away, level] = [hex('t3'), hex('amber')];
    const mixed = new Color();
    const colours: number[] = [];
    for (let i = 2; i < points.length; i += 3) {
      mixed.lerpColors(away, level, Math.exp(-(((points[i]! - height) / kLevel_m) ** 2)));
      colours.push(mixed.r, mixed.g, mixed.b);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new Float32BufferAttribute(points, 3));
    geometry.setAttribute('color', new Float32BufferAttribute(colours, 3));
    this.cloud = new Points(geometry, this.cloudMaterial);
    this.cloud.frustumCulled = false;
    this.scene.add(this.cloud);
  }

  private moveTrail(bench: Bench, replay: boolean): void {
    const t = bench.time_s ?? 0;
    const key = replay ? `${this.built}|${bench.selected}` : `${Math.floor(t * 10)}`;
    const whole = ['e', 'n', 'u'].map((axis) => this.series(bench.selected, `truth.${axis}`) ?? this.series(bench.selected, `est.${axis}`));
    const [e, n, u] = whole;
    if (!e || !n || !u || e.t.length < 2) {
      this.trail!.visible = false;
      return;
    }
    if (key !== this.trailKey) {
      this.trailKey = key;
      const from = replay ? 0 : t - kTrailLive_s;
      this.fillTrail(bench, [e, n, u], from, replay ? Infinity : t);
      if (replay && bench.beside.length > 0) this.fillBeside(bench);
    }
    if (replay) {  // only as far as it has been flown
      const geometry = this.trail!.geometry;
      const i = indexAt(this.trailTimes, t);
      geometry.instanceCount = Math.max(0, Math.min(this.trailTimes.length - 1, i));
      this.shadowTrail!.geometry.setDrawRange(0, Math.max(0, i + 1));
    }
  }

  private trailTimes: number[] = [];

  private fillTrail(bench: Bench, [e, n, u]: [Series, Series, Series] | Series[], from: number, to: number): void {
    const stops = ['tr0', 't1', 'amber', 'red'].map(hex);
    const error = this.series(bench.selected, 'error.m');
    const reference = ['e', 'n', 'u'].flatMap((axis) => this.series(bench.selected, `ref.${axis}`) ?? []);
    const ways = error && reference.length === 3 ? waysTo(reference, error, bench.errorLimit_m) : [];
    const points: number[] = [];
    const ground: number[] = [];
    const colours: number[] = [];
    const mixed = new Color();
    this.trailTimes = [];
    let last: Vec3 | null = null;
    for (let i = Math.max(0, indexAt(e!.t, from)); i < e!.t.length && e!.t[i]! <= to; ++i) {
      const p: Vec3 = [e!.v[i]!, n!.v[i]!, u!.v[i]!];
      if (last && distance(last, p) < 0.015) continue;
      last = p;
      points.push(...p);
      ground.push(p[0], p[1], 0.002);
      this.trailTimes.push(e!.t[i]!);
      const isOnItsWay = ways.some(([begin_s, end_s]) => begin_s <= e!.t[i]! && e!.t[i]! < end_s);
      const off = error && !isOnItsWay ? between(error.t, error.v, e!.t[i]!) : undefined;
      errorColour(off === undefined || !Number.isFinite(off) ? 0.25 : off / bench.errorLimit_m, stops, mixed);
      colours.push(mixed.r, mixed.g, mixed.b);
    }
    this.trail!.visible = points.length >= 6;
    if (points.length < 6) return;
    this.trail!.geometry.dispose();
    this.trail!.geometry = new LineGeometry();
    this.trail!.geometry.setPositions(points);
    this.trail!.geometry.setColors(colours);
    this.shadowTrail!.geometry.dispose();
    this.shadowTrail!.geometry = new BufferGeometry();
    this.shadowTrail!.geometry.setAttribute('position', new Float32BufferAttribute(ground, 3));
  }

  private besideSeries?: SeriesOf;
  /** Where the second run's series are. */
  setBeside(series: SeriesOf): void {
    this.besideSeries = series;
  }

  private fillBeside(bench: Bench): void {
    const [e, n, u] = ['e', 'n', 'u'].map((axis) => this.besideSeries?.(bench.selected, `truth.${axis}`));
    if (!e || !n || !u) return;
    const points: number[] = [];
    for (let i = 0; i < e.t.length; i += 5) points.push(e.v[i]!, n.v[i]!, u.v[i]!);
    if (points.length < 6) return;
    this.besideTrail!.geometry.setPositions(points);
    this.besideTrail!.computeLineDistances();
    this.besideTrail!.visible = true;
  }

  private moveWind(bench: Bench): void {
    const wind = bench.wind_W;
    const speed = wind ? Math.hypot(...wind) : 0;
    const p = bench.motion()?.motion.p ?? [0, 0, 0];
    const places: Vec3[] = [[-2.9, 1.6, 0.3], [-1.6, 3.4, 0.35], [0.3, 4.6, 0.4], [2.2, 4.4, 0.35], [2.6, 2.2, 0.3]];
    const k = Math.max(1, this.camera.position.distanceTo(this.controls.target) / 12);
    this.winds.forEach((group, i) => {
      group.visible = speed > 0.3;
      if (!group.visible || !wind) return;
      const [x, y, z] = places[i]!;
      group.position.set(p[0] + k * x, p[1] + k * y, p[2] + k * z);
      group.rotation.z = Math.atan2(wind[1], wind[0]);
      group.scale.setScalar(k * Math.min(1.6, speed * 0.2));
    });
  }

  private moveCamera(bench: Bench, passed: number): void {
    const shown = bench.motion();
    const {controls, camera} = this;
    if (this.goal) camera.position.copy(this.goal);
    this.goal = undefined;
    if (shown && this.mode !== 'orbit') {
      const p = new Vector3(...shown.motion.p);
      const k = this.roomOf(bench);
      if (this.mode === 'chase') {
        const yaw = shown.motion.rpy.yaw;
        controls.target.copy(p);
        camera.position.set(p.x - k * 1.9 * Math.sin(yaw), p.y - k * 1.9 * Math.cos(yaw), p.z + k * 0.75);
      } else if (this.mode === 'top') {
        if (!this.lastPosition) camera.position.set(p.x, p.y - 1e-3, p.z + k * 9);
        else camera.position.add(p.clone().sub(this.lastPosition));
        controls.target.copy(p);
      } else {
        if (!this.lastPosition) camera.position.copy(p).addScaledVector(this.offset, k);
        else camera.position.add(p.clone().sub(this.lastPosition));
        controls.target.copy(p);
      }
      this.lastPosition = p;
    } else if (this.mode === 'orbit' && this.lastPosition === null) {
      this.frameAll(bench);
      this.lastPosition = new Vector3();
    }
    controls.update();
    if (this.changing > 0 && this.from) {
      this.changing = Math.max(0, this.changing - passed);
      const share = MathUtils.smoothstep(1 - this.changing / kChange_s, 0, 1);
      if (this.changing > 0) this.goal = camera.position.clone();
      camera.position.lerpVectors(this.from.position, camera.position.clone(), share);
      camera.lookAt(this.from.target.clone().lerp(controls.target, share));
    }
    camera.updateMatrixWorld();
  }

  /** Times that the selected vehicle wants more room before the camera than a small multirotor. */
  private roomOf(bench: Bench): number {
    const craft = this.crafts[bench.vehicles.findIndex((vehicle) => vehicle === bench.vehicle)];
    return Math.max(1, (craft?.reach ?? 0) / 0.45);
  }

  private project(p: Vec3, w: number, h: number): [number, number] | null {
    const v = new Vector3(...p).project(this.camera);
    if (v.z > 1) return null;
    return [((v.x + 1) / 2) * w, ((1 - v.y) / 2) * h];
  }

  private placeTags(bench: Bench, w: number, h: number): Tag[] {
    const tags: Tag[] = [];
    const axis = (id: string, text: string, p: Vec3, dx = 0, dy = 0) => {
      const at = this.project(p, w, h);
      if (at && at[0] > 4 && at[0] < w - 40 && at[1] > 40 && at[1] < h - 46) tags.push({id, kind: 'axis', text, x: at[0] + dx, y: at[1] + dy});
    };
    const {step_m} = this.scale;
    axis('N', 'N', [0, 5.25 * step_m, 0], -4, -8);
    axis('E', 'E', [5.25 * step_m, 0, 0], -4, -8);
    axis('N5', `${5 * step_m} m`, [0, 4.85 * step_m, 0], 8, 2);
    axis('E5', `${5 * step_m} m`, [4.85 * step_m, 0, 0], 6, 2);
    axis('home', 'home', [0, 0, 0], -38, 2);
    const shown = bench.motion();
    if (shown) {
      const p = shown.motion.p;
      if (p[2] > 0.3) axis('height', `${fixed(p[2])} m`, [p[0], p[1], p[2] * 0.42], 8, -8);
      if (bench.vehicles.length > 1) {
        bench.vehicles.forEach((vehicle, i) => {
          const q = bench.motion(vehicle)?.motion.p;
          if (q) axis(`number${i}`, String(vehicle.system), [q[0], q[1], q[2] + 0.35], -3, -14);
        });
      }
      this.pointTags(bench, shown.motion, w, h, tags);
    }
    return tags;
  }

  /** Estimate and reference: on their side of the vehicle, which changes only after 40 px. */
  private pointTags(bench: Bench, motion: Motion, w: number, h: number, tags: Tag[]): void {
    const estimate = bench.truth() ? bench.estimate() : undefined;
    const reference = bench.vehicle?.reference;
    const add = (id: 'est' | 'ref', p: Vec3, text: string, dx: number, dy: number) => {
      const at = this.project(p, w, h);
      if (!at || at[0] < 0 || at[1] < 0 || at[0] > w || at[1] > h) return;
      const width = text.length * 6.1 + 14;
      const room = dx > 0 ? w - at[0] - dx - width : at[0] + dx - width;
      const flipped = this.sides.get(id) ?? false;
      const flip = flipped ? room < 40 : room < 0;
      this.sides.set(id, flip);
      const x = dx > 0 !== flip ? at[0] + Math.abs(dx) : at[0] - Math.abs(dx) - width;
      const y = Math.max(50, Math.min(h - 76, at[1] + dy));
      tags.push({id, kind: id, text, x: Math.max(8, Math.min(w - width - 8, x)), y, from: at});
    };
    if (estimate) {
      const old = estimate.age_s > kStale_s;
      const text = old ? `estimate as of ${fixed(estimate.age_s)} s ago` : `estimate · ${fixed(distance(motion.p, estimate.p))} m off`;
      add('est', estimate.p, text, -90, -92);
    }
    if (reference) add('ref', reference.p_W, `reference · ${fixed(distance(motion.p, reference.p_W))} m away`, 70, 78);
  }
}
