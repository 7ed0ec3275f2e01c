"use strict";
// The meshes of the arm. A pose is x, y, z (m), and a quaternion x, y, z, w.

/** The vector `v` turned by the quaternion `q`. */
function turned([x, y, z, w], v) {
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]];
}
/** The pose `b`, given in the frame of `a`. */
function joined(a, b) {
  const [p, q] = [a.slice(3), b.slice(3)], place = turned(p, b.slice(0, 3));
  return [a[0] + place[0], a[1] + place[1], a[2] + place[2],
    p[3] * q[0] + p[0] * q[3] + p[1] * q[2] - p[2] * q[1], p[3] * q[1] - p[0] * q[2] + p[1] * q[3] + p[2] * q[0],
    p[3] * q[2] + p[0] * q[1] - p[1] * q[0] + p[2] * q[3], p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2]];
}
/** The poses of base and joints at joint values. */
function frames(shape, values) {
  const all = [shape.base];
  shape.joints.forEach((joint, k) => {
    const half = values[k] / 2, s = joint.slides ? 0 : Math.sin(half), far = joint.slides ? values[k] : 0;
    const motion = [...joint.axis.map((v) => far * v), ...joint.axis.map((v) => s * v), joint.slides ? 1 : Math.cos(half)];
    all.push(joined(joined(all[k], joint.origin), motion));
  });
  return all;
}
/** Adds the meshes at joint values to a mesh of plotly. */
function addShape(mesh, shape, values) {
  const poses = frames(shape, values);
  for (const { frame, points, triangles } of shape.meshes) {
    const base = mesh.x.length, pose = poses[frame], turn = pose.slice(3);
    for (let n = 0; n < points.length; n += 3) {
      const place = turned(turn, [1e-4 * points[n], 1e-4 * points[n + 1], 1e-4 * points[n + 2]]);
      mesh.x.push(pose[0] + place[0]); mesh.y.push(pose[1] + place[1]); mesh.z.push(pose[2] + place[2]);
    }
    for (let n = 0; n < triangles.length; n += 3) {
      mesh.i.push(base + triangles[n]); mesh.j.push(base + triangles[n + 1]); mesh.k.push(base + triangles[n + 2]);
    }
  }
  return mesh;
}
