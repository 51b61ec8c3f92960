// Objects of a scene as three.js meshes. Scene format and build: see README.md.
import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, FrontSide, Mesh, MeshBasicMaterial,
  MeshPhongMaterial,
} from "three";

const ARRAYS = { uint8: Uint8Array, uint16: Uint16Array, uint32: Uint32Array, float32: Float32Array };

// ---- decoding ---------------------------------------------------------------------------------
export function decodeBase64(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

function readArray(buffers, description) {
  return new ARRAYS[description.type](buffers[description.buffer].buffer);
}

function readPoints(buffers, description) {
  const stored = readArray(buffers, description);
  if (!description.step) return Float32Array.from(stored);
  return Float32Array.from(stored, (n, at) => (
    description.origin[at % 3] + n * description.step[at % 3]
  ));
}

// ---- objects: one function for each kind --------------------------------------------------------
export const BUILDERS = { mesh: buildMesh };

function buildMesh(object, buffers) {
  let geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(readPoints(buffers, object.vertices), 3));
  geometry.setIndex(new BufferAttribute(readArray(buffers, object.triangles), 1));
  if (object.vertex_colours) {
    const colours = readArray(buffers, object.vertex_colours);
    geometry.setAttribute("color", new BufferAttribute(colours, 3, true));
  }
  if (object.triangle_colours) {
    geometry = paintTriangles(geometry, readArray(buffers, object.triangle_colours));
  }
  geometry.computeVertexNormals();
  const material = new MeshPhongMaterial({
    color: new Color(geometry.hasAttribute("color") ? "#ffffff" : object.colour),
    vertexColors: geometry.hasAttribute("color"),
    specular: new Color("#222222"),
    shininess: 30,
  });
  material.onBeforeCompile = glaze;
  const mesh = new Mesh(geometry, material);
  if (object.shine) mesh.add(makeGhost(geometry, object.colour));
  return mesh;
}

function makeGhost(geometry, colour) {
  // The same shape, faint, over everything: a mark inside an organ is seen through it.
  const material = new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.45, depthTest: false });
  const ghost = new Mesh(geometry, material);
  ghost.renderOrder = Infinity;
  return ghost;
}

function paintTriangles(geometry, colours) {
  // Colours that belong to triangles need vertices of their own.
  const loose = geometry.toNonIndexed();
  const repeated = new Uint8Array(colours.length * 3);
  for (let n = 0; n < repeated.length; n += 1) {
    repeated[n] = colours[3 * Math.floor(n / 9) + (n % 3)];
  }
  loose.setAttribute("color", new BufferAttribute(repeated, 3, true));
  return loose;
}

function glaze(shader) {
  // A translucent skin is denser where it is seen edge-on, as glass is: its outline stays readable
  // while the view into its middle is clear.
  shader.fragmentShader = shader.fragmentShader.replace(
    "#include <opaque_fragment>",
    `if (opacity < 1.0) {
       float facing = abs(dot(normalize(normal), normalize(vViewPosition)));
       diffuseColor.a *= mix(2.2, 0.6, smoothstep(0.0, 0.7, facing));
       diffuseColor.a = min(diffuseColor.a, 1.0);
     }
     #include <opaque_fragment>`,
  );
}

export function setOpacity(mesh, opacity) {
  const { material } = mesh;
  material.opacity = opacity;
  material.transparent = opacity < 1;
  material.depthWrite = opacity >= 1;
  // The far side of a skin would only veil what lies inside.
  material.side = opacity < 1 ? FrontSide : DoubleSide;
  material.needsUpdate = true;
}
