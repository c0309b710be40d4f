// A surface map as a lit surface in three dimensions, by ogl; drawn only when something changed.

import {Camera, Geometry, Mesh, Program, Renderer, Texture, Transform} from "ogl";
import type {Scale, SurfaceMap} from "../data/maps";
import {colours} from "./colours";
import {height_under, vertices, type Turn, eye_of} from "./solid_geometry";

const kVertex = `#version 300 es
in vec3 position;
in float shade;
in float seen;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
out float vShade;
out float vSeen;
out vec3 vPlace;
void main() {
  vShade = shade;
  vSeen = seen;
  vPlace = position;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const kFragment = `#version 300 es
precision highp float;
in float vShade;
in float vSeen;
in vec3 vPlace;
uniform sampler2D table;
uniform vec2 mark;
uniform float cell;
out vec4 colour;
void main() {
  if (vSeen < 0.999) discard;
  vec3 normal = normalize(cross(dFdx(vPlace), dFdy(vPlace)));
  float light = 0.45 + 0.55 * abs(dot(normal, normalize(vec3(-0.4, 0.3, 0.85))));
  vec3 base = texture(table, vec2(clamp(vShade, 0.002, 0.998), 0.5)).rgb * light;
  float near = step(distance(vPlace.xy, mark), cell);
  colour = vec4(mix(base, vec3(1.0), 0.8 * near), 1.0);
}`;

export class SolidPainter {
  private readonly renderer: Renderer;
  private readonly camera: Camera;
  private readonly scene = new Transform();
  private readonly program: Program;
  private mesh: Mesh | null = null;
  private shape = "";
  private uploaded = "";
  private uploaded_map: SurfaceMap | null = null;

  /** Throws where the browser gives no WebGL 2. */
  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new Renderer({canvas, dpr: Math.min(window.devicePixelRatio || 1, 2), alpha: true, antialias: true, webgl: 2});
    const gl = this.renderer.gl;
    if (!gl || !this.renderer.isWebgl2) throw new Error("this browser gives no WebGL 2");
    gl.clearColor(0, 0, 0, 0);
    this.camera = new Camera(gl, {fov: 30, near: 0.1, far: 20});
    this.program = new Program(gl, {
      vertex: kVertex,
      fragment: kFragment,
      cullFace: false,
      uniforms: {table: {value: new Texture(gl, {generateMipmaps: false})}, mark: {value: [9, 9]}, cell: {value: 0}},
    });
  }

  /** @returns false: the canvas has no size yet */
  paint(map: SurfaceMap, scale: Scale, turn: Turn, cell: [number, number] | null): boolean {
    const width = this.canvas.clientWidth;
    const height = this.canvas.clientHeight;
    if (!width || !height) return false;
    this.renderer.setSize(width, height);
    this.canvas.style.width = "";
    this.canvas.style.height = "";
    this.camera.perspective({aspect: width / height});
    this.upload(map, scale, turn.lift);
    const longest = Math.max(map.nx, map.ny);
    this.program.uniforms.mark.value = cell ? [(cell[0] - (map.nx - 1) / 2) / longest, (cell[1] - (map.ny - 1) / 2) / longest] : [9, 9];
    this.program.uniforms.cell.value = Math.max(0.8 / longest, 0.008);
    const eye = eye_of(turn);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(eye[0], eye[1], eye[2]);
    this.camera.lookAt([0, 0, 0.1]);
    this.renderer.render({scene: this.scene, camera: this.camera});
    return true;
  }

  /** The cell under a place of the canvas, in CSS pixels, or null. */
  cell_at(map: SurfaceMap, scale: Scale, turn: Turn, x: number, y: number): [number, number] | null {
    return height_under(map, scale, turn, (2 * x) / this.canvas.clientWidth - 1, 1 - (2 * y) / this.canvas.clientHeight,
                        this.canvas.clientWidth / this.canvas.clientHeight);
  }

  end(): void {
    this.renderer.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  private upload(map: SurfaceMap, scale: Scale, lift: number): void {
    const key = `${scale.low} ${scale.high} ${scale.diverging} ${lift}`;
    if (this.uploaded_map === map && this.uploaded === key) return;
    const gl = this.renderer.gl;
    const {position, shade, seen, index} = vertices(map, scale, lift);
    const shape = `${map.nx} ${map.ny}`;
    if (this.shape !== shape || !this.mesh) {
      this.mesh?.setParent(null);
      const geometry = new Geometry(gl, {
        position: {size: 3, data: position, usage: gl.DYNAMIC_DRAW},
        shade: {size: 1, data: shade, usage: gl.DYNAMIC_DRAW},
        seen: {size: 1, data: seen, usage: gl.DYNAMIC_DRAW},
        index: {data: index},
      });
      this.mesh = new Mesh(gl, {geometry, program: this.program, frustumCulled: false});
      this.mesh.setParent(this.scene);
      this.shape = shape;
    } else {
      const {attributes} = this.mesh.geometry;
      for (const [name, data] of [["position", position], ["shade", shade], ["seen", seen]] as const) {
        attributes[name].data = data;
        attributes[name].needsUpdate = true;
      }
    }
    this.program.uniforms.table.value.image = colours(scale.diverging);
    Object.assign(this.program.uniforms.table.value, {width: 256, height: 1, needsUpdate: true});
    this.uploaded_map = map;
    this.uploaded = key;
  }
}
