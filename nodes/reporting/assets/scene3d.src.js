// Objects of a scene as three.js meshes. Scene format and build: see README.md.
import {
  Box3, BufferAttribute, BufferGeometry, Color, DoubleSide, FrontSide, Matrix4, Mesh,
  MeshBasicMaterial, MeshPhongMaterial, Sphere, Vector3,
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
export const BUILDERS = { mesh: buildMesh, tube: buildTube, ride: buildRide };

function buildMesh(object, buffers) {
  let geometry = new BufferGeometry();
  const points = readPoints(buffers, object.vertices);
  geometry.setAttribute("position", new BufferAttribute(points, 3));
  geometry.setIndex(new BufferAttribute(readArray(buffers, object.triangles), 1));
  if (object.paints) {
    const colours = new BufferAttribute(new Uint8Array(points.length), 3, true);
    geometry.setAttribute("color", colours);
  }
  if (object.vertex_colours) {
    const colours = readArray(buffers, object.vertex_colours);
    geometry.setAttribute("color", new BufferAttribute(colours, 3, true));
  }
  if (object.triangle_colours) {
    geometry = paintTriangles(geometry, readArray(buffers, object.triangle_colours));
  }
  geometry.computeVertexNormals();
  const mesh = makeMesh(object, geometry);
  if (object.paints) {
    mesh.paint = (n) => paintVertices(geometry, object.paints[n], buffers);
    mesh.paint(0);
  }
  return mesh;
}

function makeMesh(object, geometry) {
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

function paintVertices(geometry, paint, buffers) {
  // Each vertex names a colour of the paint's palette.
  const palette = paint.colours.map((colour) => new Color(colour).toArray());
  const kinds = readArray(buffers, paint.kinds);
  const colours = geometry.getAttribute("color");
  for (let n = 0; n < kinds.length; n += 1) colours.setXYZ(n, ...palette[kinds[n]]);
  colours.needsUpdate = true;
}

// ---- objects over time: setFrame(n) shows one frame ---------------------------------------------
const SIDES = 10;

function buildTube(object, buffers) {
  // Tubes about curves of always as many points, swept for each frame when it is shown.
  const points = readPoints(buffers, object.points);
  const { curves, points_each: each, radius } = object;
  const rings = (each + 2) * SIDES;
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(curves * rings * 3), 3));
  geometry.setIndex(joinRings(each + 2, curves));
  const box = new Box3().setFromArray(points).expandByScalar(radius);
  geometry.boundingBox = box;
  geometry.boundingSphere = box.getBoundingSphere(new Sphere());
  const mesh = makeMesh(object, geometry);
  const items = 3 * each * curves;
  mesh.frames = points.length / items;
  mesh.setFrame = (frame) => {
    const from = items * Math.min(frame, mesh.frames - 1);
    for (let curve = 0; curve < curves; curve += 1) {
      const start = from + 3 * each * curve;
      sweep(geometry, curve * rings, points.subarray(start, start + 3 * each), radius);
    }
    geometry.getAttribute("position").needsUpdate = true;
    geometry.computeVertexNormals();
  };
  mesh.setFrame(0);
  return mesh;
}

function joinRings(rings, curves) {
  const corners = [];
  for (let ring = 0; ring + 1 < rings * curves; ring += 1) {
    if ((ring + 1) % rings === 0) continue; // from the end of one curve to the next
    for (let side = 0; side < SIDES; side += 1) {
      const [here, after] = [side, (side + 1) % SIDES].map((n) => ring * SIDES + n);
      corners.push(here, after, after + SIDES, here, after + SIDES, here + SIDES);
    }
  }
  return corners;
}

function sweep(geometry, first, points, radius) {
  // The rings of one curve, from the vertex `first` on. The frame is carried along the curve with
  // the least turn, so that no facet twists; the first and the last ring are points, as closed ends.
  const position = geometry.getAttribute("position");
  const count = points.length / 3;
  const at = (n) => new Vector3().fromArray(points, 3 * Math.min(count - 1, Math.max(0, n)));
  const across = new Vector3();
  for (let n = 0; n < count; n += 1) {
    const middle = at(n);
    const along = at(n + 1).sub(at(n - 1)).normalize();
    across.addScaledVector(along, -across.dot(along));
    if (across.length() < 1e-6) {
      across.set(Math.abs(along.x) < 0.6 ? 1 : 0, Math.abs(along.x) < 0.6 ? 0 : 1, 0);
      across.addScaledVector(along, -across.dot(along));
    }
    across.normalize();
    const other = new Vector3().crossVectors(along, across);
    for (let side = 0; side < SIDES; side += 1) {
      const turn = (2 * Math.PI * side) / SIDES;
      const out = across.clone().multiplyScalar(radius * Math.cos(turn))
        .addScaledVector(other, radius * Math.sin(turn)).add(middle);
      position.setXYZ(first + (n + 1) * SIDES + side, out.x, out.y, out.z);
      if (n === 0) position.setXYZ(first + side, middle.x, middle.y, middle.z);
      if (n === count - 1) position.setXYZ(first + (n + 2) * SIDES + side, middle.x, middle.y, middle.z);
    }
  }
}

function buildRide(object, buffers) {
  // A rigid mesh that has another place in each frame: rows of patient_from_body, 3 x 4.
  const poses = readArray(buffers, object.poses);
  const mesh = buildMesh(object, buffers);
  mesh.frames = poses.length / 12;
  mesh.matrixAutoUpdate = false;
  mesh.setFrame = (frame) => {
    const from = 12 * Math.min(frame, mesh.frames - 1);
    mesh.matrix = new Matrix4().set(...poses.subarray(from, from + 12), 0, 0, 0, 1);
    mesh.matrixWorldNeedsUpdate = true;
  };
  mesh.setFrame(0);
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
