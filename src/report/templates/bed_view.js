// Turns the bed of each element of class "bed". Lengths are shown in millimetres; z is up. Uses three.js r111.
"use strict";
(function () {
  const mm = 1000;
  const ramp = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]].map(c => c.map(v => v / 255));
  const kinds = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#bbbbbb"];
  const cutColour = 0x5b3a29;  // of the filled faces

  function bytes(text) { return Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer; }

  function rampColour(t) {
    const x = Math.min(Math.max(t, 0), 1) * (ramp.length - 1), i = Math.min(Math.floor(x), ramp.length - 2), f = x - i;
    return ramp[i].map((v, k) => v + f * (ramp[i + 1][k] - v));
  }

  // Corners with normals: the mean of the facets around a corner that meet at less than 35 degrees.
  function smoothGeometry(points, triangles) {
    const facets = triangles.length / 3, normal = new Float32Array(triangles.length), around = new Map();
    for (let f = 0; f < facets; ++f) {
      const p = [0, 1, 2].map(c => [0, 1, 2].map(a => points[3 * triangles[3 * f + c] + a]));
      const u = p[1].map((v, a) => v - p[0][a]), w = p[2].map((v, a) => v - p[0][a]);
      const n = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
      for (let a = 0; a < 3; ++a) normal[3 * f + a] = n[a];
      for (let c = 0; c < 3; ++c) {
        const v = triangles[3 * f + c];
        if (!around.has(v)) around.set(v, []);
        around.get(v).push(f);
      }
    }
    const length = f => Math.hypot(normal[3 * f], normal[3 * f + 1], normal[3 * f + 2]) || 1;
    const position = new Float32Array(9 * facets), normals = new Float32Array(9 * facets);
    for (let f = 0; f < facets; ++f)
      for (let c = 0; c < 3; ++c) {
        const v = triangles[3 * f + c], sum = [0, 0, 0];
        for (const g of around.get(v)) {
          const dot = (normal[3 * f] * normal[3 * g] + normal[3 * f + 1] * normal[3 * g + 1] + normal[3 * f + 2] * normal[3 * g + 2]) / (length(f) * length(g));
          if (dot > 0.82) for (let a = 0; a < 3; ++a) sum[a] += normal[3 * g + a];
        }
        const size = Math.hypot(...sum) || 1;
        for (let a = 0; a < 3; ++a) {
          position[9 * f + 3 * c + a] = points[3 * v + a];
          normals[9 * f + 3 * c + a] = sum[a] / size;
        }
      }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(normals, 3));
    geometry.computeBoundingSphere();
    return geometry;
  }

  function surface(data) {
    return { points: new Float32Array(bytes(data.points)).map(x => mm * x), triangles: new Uint32Array(bytes(data.triangles)) };
  }

  // The direction in which a body is longest or, if that is more distinct, shortest; null of a body without one. From the moments of its
  // corners, by turning away the products of two coordinates (Jacobi).
  function axisOf(points) {
    const n = points.length / 3, mean = [0, 1, 2].map(a => { let sum = 0; for (let p = a; p < points.length; p += 3) sum += points[p]; return sum / n; });
    const m = [0, 1, 2].map(a => [0, 1, 2].map(b => { let sum = 0; for (let p = 0; p < points.length; p += 3) sum += (points[p + a] - mean[a]) * (points[p + b] - mean[b]); return sum / n; }));
    const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    for (let turn = 0; turn < 60; ++turn) {
      const [i, j] = [[0, 1], [0, 2], [1, 2]][turn % 3], angle = 0.5 * Math.atan2(2 * m[i][j], m[j][j] - m[i][i]), c = Math.cos(angle), s = Math.sin(angle);
      for (const row of [m, v]) for (let k = 0; k < 3; ++k) [row[k][i], row[k][j]] = [c * row[k][i] - s * row[k][j], s * row[k][i] + c * row[k][j]];
      for (let k = 0; k < 3; ++k) [m[i][k], m[j][k]] = [c * m[i][k] - s * m[j][k], s * m[i][k] + c * m[j][k]];
    }
    const order = [0, 1, 2].sort((a, b) => m[b][b] - m[a][a]), [large, middle, small] = order.map(a => m[a][a]);
    const long = large / middle >= middle / small;
    if ((long ? large / middle : middle / small) < 1.1) return null;
    const at = order[long ? 0 : 2];
    return new THREE.Vector3(v[0][at], v[1][at], v[2][at]);
  }

  // Each grain has a colour of its own.
  function tinted(material) {
    material.onBeforeCompile = shader => {
      shader.vertexShader = shader.vertexShader.replace("#include <common>", "attribute vec3 tint;\nvarying vec3 vTint;\n#include <common>")
        .replace("#include <begin_vertex>", "vTint = tint;\n#include <begin_vertex>");
      shader.fragmentShader = shader.fragmentShader.replace("#include <common>", "varying vec3 vTint;\n#include <common>")
        .replace("#include <color_fragment>", "#include <color_fragment>\ndiffuseColor.rgb *= vTint;");
    };
    return material;
  }

  // Draws nothing, but counts in the stencil buffer how many surfaces lie between the eye and the cut.
  function counter(side, operation, planes) {
    return new THREE.MeshBasicMaterial({ side, clippingPlanes: planes, colorWrite: false, depthWrite: false, depthTest: false, stencilWrite: true,
      stencilFunc: THREE.AlwaysStencilFunc, stencilFail: operation, stencilZFail: operation, stencilZPass: operation });
  }

  function start(box) {
    const canvas = box.querySelector("canvas"), form = box.querySelector("form"), tip = box.querySelector(".tip"), legend = box.querySelector(".legend");
    const data = JSON.parse(box.querySelector("script").textContent);
    let renderer;
    try {
      renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, stencil: true, preserveDrawingBuffer: true });
    } catch (noWebGL) {
      canvas.style.display = form.style.display = "none";
      const note = document.createElement("p");
      note.className = "off";
      note.textContent = "This browser shows no WebGL: the bed cannot be turned here.";
      box.append(note);
      return;
    }
    renderer.localClippingEnabled = true;
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(35, 1, 1, 10);
    camera.up.set(0, 0, 1);
    const low = new THREE.Vector3(...data.low_m).multiplyScalar(mm), high = new THREE.Vector3(...data.high_m).multiplyScalar(mm);
    const middle = low.clone().add(high).multiplyScalar(0.5), radius = 0.5 * high.distanceTo(low);
    const controls = new THREE.OrbitControls(camera, canvas);
    controls.enableKeys = false;
    const clip = new THREE.Plane(new THREE.Vector3(0, 0, -1), 0);
    let planes = [], wanted = true, chosen = -1;

    scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8a94, 0.75));
    const lamp = new THREE.DirectionalLight(0xffffff, 0.45);
    camera.add(lamp);
    lamp.position.set(0.6, 0.8, 1);
    scene.add(camera);

    // Grains, one instanced mesh per kind.
    const count = data.kind_of_grain.length, poses = new Float32Array(bytes(data.poses)), matrices = [], kindsOf = [];
    for (let g = 0; g < count; ++g) {
      const p = poses.subarray(7 * g, 7 * g + 7);
      matrices.push(new THREE.Matrix4().compose(new THREE.Vector3(mm * p[0], mm * p[1], mm * p[2]), new THREE.Quaternion(p[4], p[5], p[6], p[3]), new THREE.Vector3(1, 1, 1)));
    }
    data.kinds.forEach((kind, k) => {
      const grains = [];
      for (let g = 0; g < count; ++g) if (data.kind_of_grain[g] === k) grains.push(g);
      const shape = surface(kind), geometry = smoothGeometry(shape.points, shape.triangles);
      const tint = new THREE.InstancedBufferAttribute(new Float32Array(3 * grains.length), 3);
      geometry.setAttribute("tint", tint);
      const layers = [tinted(new THREE.MeshPhongMaterial({ color: 0xffffff, specular: 0x222222, shininess: 20, side: THREE.DoubleSide })),
        counter(THREE.BackSide, THREE.IncrementWrapStencilOp, []), counter(THREE.FrontSide, THREE.DecrementWrapStencilOp, [])]
        .map((material, layer) => {
          const mesh = new THREE.InstancedMesh(geometry, material, grains.length);
          grains.forEach((g, i) => matrices[g].toArray(mesh.instanceMatrix.array, 16 * i));
          mesh.frustumCulled = false;
          mesh.renderOrder = layer === 0 ? 3 : 1;
          scene.add(mesh);
          return mesh;
        });
      kindsOf.push({ name: kind.name, shape, grains, tint, layers, reach: geometry.boundingSphere });
    });

    // The filled face of the cut.
    const cap = new THREE.Mesh(new THREE.PlaneBufferGeometry(4 * radius, 4 * radius), new THREE.MeshBasicMaterial({ color: cutColour, side: THREE.DoubleSide,
      stencilWrite: true, stencilRef: 0, stencilFunc: THREE.NotEqualStencilFunc, stencilFail: THREE.ReplaceStencilOp, stencilZFail: THREE.ReplaceStencilOp, stencilZPass: THREE.ReplaceStencilOp }));
    cap.renderOrder = 2;
    cap.onAfterRender = r => r.clearStencil();
    scene.add(cap);

    // Vessel and section. The ends of the lines in which a plane cuts the vessel.
    function outline(z) {
      const ends = [];
      if (!data.vessel) {
        const corners = [[low.x, low.y], [high.x, low.y], [high.x, high.y], [low.x, high.y]].map(c => new THREE.Vector3(c[0], c[1], z));
        corners.forEach((corner, i) => ends.push(corner, corners[(i + 1) % 4]));
        return ends;
      }
      const { points, triangles } = surface(data.vessel);
      for (let t = 0; t < triangles.length; t += 3) {
        const corner = [0, 1, 2].map(c => new THREE.Vector3().fromArray(points, 3 * triangles[t + c])), cuts = [];
        for (let c = 0; c < 3; ++c) {
          const [a, b] = [corner[c], corner[(c + 1) % 3]];
          if ((a.z < z) !== (b.z < z)) cuts.push(a.clone().lerp(b, (z - a.z) / (b.z - a.z)));
        }
        if (cuts.length === 2) ends.push(...cuts);
      }
      return ends;
    }
    const vessel = new THREE.Group(), section = new THREE.Group(), line = new THREE.LineBasicMaterial({ color: 0x6b7280 });
    if (data.vessel) {
      const sides = surface(data.vessel), geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(sides.points, 3));
      geometry.setIndex(new THREE.BufferAttribute(sides.triangles, 1));
      const skin = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color: 0x7aa5d8, transparent: true, opacity: 0.1, side: THREE.DoubleSide, depthWrite: false }));
      skin.renderOrder = 4;
      vessel.add(skin, new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 30), line));
    } else {
      const size = high.clone().sub(low), edges = new THREE.LineSegments(new THREE.EdgesGeometry(new THREE.BoxBufferGeometry(size.x, size.y, size.z)), line);
      edges.position.copy(middle);
      vessel.add(edges);
    }
    scene.add(vessel);
    for (const z of data.section_m || [])
      section.add(new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(outline(mm * z)), new THREE.LineBasicMaterial({ color: 0xc2410c })));
    scene.add(section);
    // Streamlines, as thin tubes coloured by speed.
    const lines = new THREE.Group();
    let speedText = "";
    if (data.lines) {
      const numbers = new Float32Array(bytes(data.lines)), speeds = [];
      for (let i = 3; i < numbers.length; i += 4) speeds.push(numbers[i]);
      const fastest = speeds.sort((a, b) => a - b)[Math.floor(0.98 * (speeds.length - 1))] || 1, sides = 5;
      speedText = "streamlines: speed, 0 to " + Number(fastest.toPrecision(2)) + " m/s, of " + data.flow;
      let first = 0;
      for (const count of data.points_of_lines) {
        const points = [];
        for (let p = 0; p < count; ++p) points.push(new THREE.Vector3().fromArray(numbers, 4 * (first + p)).multiplyScalar(mm));
        const segments = count - 1, tube = new THREE.TubeBufferGeometry(new THREE.CatmullRomCurve3(points), segments, 0.0035 * radius, sides), colours = [];
        for (let s = 0; s <= segments; ++s) {
          const c = rampColour(numbers[4 * (first + s) + 3] / fastest);
          for (let k = 0; k <= sides; ++k) colours.push(...c);
        }
        tube.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
        const mesh = new THREE.Mesh(tube, new THREE.MeshBasicMaterial({ vertexColors: THREE.VertexColors }));
        mesh.renderOrder = 3;
        lines.add(mesh);
        first += count;
      }
    }
    lines.visible = false;
    scene.add(lines);
    // A slice of speed or pressure: a picture on a plane, without what is solid.
    const slices = {};
    let slice = null;
    if (data.slice) {
      const s = data.slice, normal = s.normal, along = normal === 1 ? 0 : 1;
      for (const values of s.values) {
        const from = new Uint8Array(bytes(values.bytes)), pixels = new Uint8Array(4 * from.length);
        from.forEach((v, i) => pixels.set(v === 255 ? [0, 0, 0, 0] : [...rampColour(v / 254).map(c => Math.round(255 * c)), 255], 4 * i));
        const texture = new THREE.DataTexture(pixels, s.width, s.height, THREE.RGBAFormat);
        texture.magFilter = texture.minFilter = THREE.NearestFilter;
        texture.needsUpdate = true;
        const plane = new THREE.Mesh(new THREE.PlaneBufferGeometry(mm * s.size_m[0], mm * s.size_m[1]),
          new THREE.MeshBasicMaterial({ map: texture, side: THREE.DoubleSide, alphaTest: 0.5 }));
        const axis = n => new THREE.Vector3().setComponent(n, 1);
        plane.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(axis(along), axis(2), axis(along).cross(axis(2))));
        plane.position.setComponent(normal, mm * s.at_m).setComponent(along, mm * (s.low_m[0] + 0.5 * s.size_m[0])).setComponent(2, mm * (s.low_m[1] + 0.5 * s.size_m[1]));
        plane.renderOrder = 3;
        plane.visible = false;
        scene.add(plane);
        slices[values.name] = { plane, text: "slice: " + values.name + ", " + values.range.map(v => Number(v.toPrecision(2))).join(" to ") + " " + values.unit + ", of " + data.flow };
        form.slice.add(new Option(values.name, values.name));
      }
    }
    // Gray values of a scan on the plane of the cut, or through the middle; over them the cut faces of grains let them shine through.
    let showScan = () => {};
    const grays = "<i style=\"background:linear-gradient(to right,#000,#fff)\"></i>";
    if (data.scan) {
      const s = data.scan, values = new Uint8Array(bytes(s.bytes)), n = s.voxels, axis = c => new THREE.Vector3().setComponent(c, 1);
      const plane = new THREE.Mesh(new THREE.PlaneBufferGeometry(1, 1),
        new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
      plane.visible = false;
      plane.renderOrder = 0;
      scene.add(plane);
      showScan = () => {
        const on = slice !== null && slice.plane === plane;
        cap.material.transparent = on;
        cap.material.opacity = on ? 0.45 : 1;
        cap.material.color.set(on ? 0xe69f00 : cutColour);
        if (!on) return;
        const a = Math.max("xyz".indexOf(form.axis.value || "y"), 0), u = a === 0 ? 1 : 0, v = a === 2 ? 1 : 2;
        const at = (low.getComponent(a) + (form.axis.value ? Number(form.at.value) : 0.5) * (high.getComponent(a) - low.getComponent(a))) / mm;
        plane.visible = at >= s.low_m[a] - 1e-9 && at <= s.low_m[a] + s.size_m[a] + 1e-9;
        const layer = Math.min(Math.max(Math.floor((at - s.low_m[a]) / s.size_m[a] * n[a]), 0), n[a] - 1), stride = [1, n[0], n[0] * n[1]];
        const pixels = new Uint8Array(4 * n[u] * n[v]);
        for (let k = 0, p = 0; k < n[v]; ++k)
          for (let i = 0; i < n[u]; ++i, p += 4) {
            pixels.fill(values[layer * stride[a] + i * stride[u] + k * stride[v]], p, p + 3);
            pixels[p + 3] = 255;
          }
        if (plane.material.map) plane.material.map.dispose();
        else plane.material.needsUpdate = true;
        plane.material.map = new THREE.DataTexture(pixels, n[u], n[v], THREE.RGBAFormat);
        plane.material.map.magFilter = plane.material.map.minFilter = THREE.NearestFilter;
        plane.material.map.needsUpdate = true;
        plane.scale.set(mm * s.size_m[u], mm * s.size_m[v], 1);
        plane.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(axis(u), axis(v), axis(u).cross(axis(v))));
        for (const c of [u, v]) plane.position.setComponent(c, mm * (s.low_m[c] + 0.5 * s.size_m[c]));
        plane.position.setComponent(a, mm * at);
      };
      slices.scan = { plane, bar: grays, text: "gray values, " + s.range.map(g => Number(g.toPrecision(3))).join(" to ") + (count ? "; orange: cut grains" : "") };
      form.slice.add(new Option("scan", "scan"));
    }
    form.slice.parentElement.style.display = data.slice || data.scan ? "" : "none";
    form.lines.parentElement.style.display = data.lines ? "" : "none";
    form.section.parentElement.style.display = data.section_m ? "" : "none";
    if (data.kinds.length < 2) form.colour.querySelector("[value=kind]").remove();
    // Angle between the vertical and the axis of a long or flat grain, in degrees; none of round ones.
    const axes = kindsOf.map(kind => axisOf(kind.shape.points)), inclinations = matrices.map((matrix, g) => {
      const axis = axes[data.kind_of_grain[g]];
      return axis ? Math.acos(Math.min(1, Math.abs(axis.clone().transformDirection(matrix).z))) * 180 / Math.PI : null;
    });
    if (axes.every(axis => !axis)) form.colour.querySelector("[value=inclination]").remove();

    function colour() {
      const how = form.colour.value, top = Math.max(...matrices.map(m => m.elements[14]), low.z + 1e-9), bottom = Math.min(...matrices.map(m => m.elements[14]), top);
      const most = Math.max(1, ...data.contacts);
      for (const kind of kindsOf) {
        kind.grains.forEach((g, i) => {
          const c = g === chosen ? [1, 0.35, 0.1]
            : how === "height" ? rampColour((matrices[g].elements[14] - bottom) / (top - bottom || 1))
            : how === "contacts" ? rampColour(data.contacts[g] / most)
            : how === "inclination" && inclinations[g] !== null ? rampColour(inclinations[g] / 90)
            : how === "kind" ? new THREE.Color(kinds[kindsOf.indexOf(kind) % kinds.length]).toArray() : [0.8, 0.78, 0.74];
          kind.tint.array.set(c, 3 * i);
        });
        kind.tint.needsUpdate = true;
      }
      const bar = "<i style=\"background:linear-gradient(to right," + ramp.map(c => "rgb(" + c.map(v => Math.round(255 * v)) + ")") + ")\"></i>";
      legend.innerHTML = !count ? "" : how === "height" ? "height of the centre, mm" + bar + bottom.toPrecision(3) + " to " + top.toPrecision(3)
        : how === "contacts" ? "grains that it touches" + bar + "0 to " + most
        : how === "inclination" ? "axis against the vertical, degrees" + bar + "0 to 90" : "";
      if (how === "kind") kindsOf.forEach((kind, k) => {
        const entry = document.createElement("div");
        entry.textContent = kind.name + " \u25a0";
        entry.style.color = kinds[k % kinds.length];
        legend.append(entry);
      });
      if (lines.visible) {
        const entry = document.createElement("div");
        entry.textContent = speedText;
        if (how === "kind" || how === "plain") entry.insertAdjacentHTML("beforeend", bar);
        legend.append(entry);
      }
      if (slice) {
        const entry = document.createElement("div");
        entry.textContent = slice.text;
        if (slice.bar || ((how === "kind" || how === "plain") && !lines.visible)) entry.insertAdjacentHTML("beforeend", slice.bar || bar);
        legend.append(entry);
      }
      wanted = true;
    }

    function cut() {
      const axis = form.axis.value, on = axis !== "", a = "xyz".indexOf(axis);
      for (const input of [form.at, form.flip]) input.disabled = !on;
      if (on) {
        const at = low.getComponent(a) + Number(form.at.value) * (high.getComponent(a) - low.getComponent(a));
        const sign = (axis === "z") !== form.flip.checked ? -1 : 1;  // the face is on the side from which the bed is seen at first
        clip.normal.set(0, 0, 0).setComponent(a, sign);
        clip.constant = -sign * at;
        cap.position.copy(middle).setComponent(a, at);
        cap.lookAt(cap.position.clone().sub(clip.normal));
        form.place.textContent = at.toPrecision(3) + " mm";
      } else {
        form.place.textContent = "";
      }
      planes = on ? [clip] : [];
      for (const kind of kindsOf)
        kind.layers.forEach((mesh, layer) => {
          mesh.material.clippingPlanes = planes;
          mesh.visible = layer === 0 || on;
        });
      cap.visible = on;
      showScan();
      wanted = true;
    }

    function reset() {
      camera.near = 0.02 * radius;
      camera.far = 20 * radius;
      controls.target.copy(middle);
      camera.position.copy(middle).add(new THREE.Vector3(-0.55, -1.0, 0.42).normalize().multiplyScalar(3.4 * radius));
      camera.updateProjectionMatrix();
      controls.update();
      wanted = true;
    }
    // From a side, for comparisons: "x", "y" or "z", from above.
    function look(axis) {
      const from = new THREE.Vector3().setComponent("xyz".indexOf(axis), 1);
      camera.position.copy(controls.target).add(from.multiplyScalar(4 * radius)).add(new THREE.Vector3(0, -1e-3 * radius, 0));
      controls.update();
      wanted = true;
    }

    // The grain under a place of the canvas, in pixels: the nearest facet that the cut has left.
    function pick(x, y) {
      const size = renderer.getSize(new THREE.Vector2()), rays = new THREE.Raycaster(), hit = new THREE.Vector3(), corner = [0, 1, 2].map(() => new THREE.Vector3());
      rays.setFromCamera(new THREE.Vector2(2 * x / size.x - 1, 1 - 2 * y / size.y), camera);
      let best = Infinity, found = -1;
      for (const kind of kindsOf)
        for (const g of kind.grains) {
          if (rays.ray.distanceToPoint(kind.reach.center.clone().applyMatrix4(matrices[g])) > kind.reach.radius) continue;
          const ray = rays.ray.clone().applyMatrix4(new THREE.Matrix4().getInverse(matrices[g])), t = kind.shape.triangles, p = kind.shape.points;
          for (let f = 0; f < t.length; f += 3) {
            for (let c = 0; c < 3; ++c) corner[c].fromArray(p, 3 * t[f + c]);
            if (!ray.intersectTriangle(corner[0], corner[1], corner[2], false, hit)) continue;
            hit.applyMatrix4(matrices[g]);
            const distance = hit.distanceTo(rays.ray.origin);
            if (distance < best && planes.every(plane => plane.distanceToPoint(hit) >= 0)) [best, found] = [distance, g];
          }
        }
      return found;
    }

    function draw() {
      const width = canvas.clientWidth, height = canvas.clientHeight, size = renderer.getSize(new THREE.Vector2());
      if (!width || !height) return;
      if (size.x !== width || size.y !== height) {
        renderer.setSize(width, height, false);
        camera.aspect = width / height;
        camera.updateProjectionMatrix();
        wanted = true;
      }
      if (!wanted) return;
      wanted = false;
      renderer.render(scene, camera);
    }
    const still = window.matchMedia && matchMedia("(prefers-reduced-motion: reduce)").matches;
    controls.autoRotate = !still;
    controls.autoRotateSpeed = 0.8;
    const stop = () => { controls.autoRotate = false; };
    for (const event of ["pointerdown", "wheel", "keydown", "touchstart"]) box.addEventListener(event, stop, { passive: true });
    controls.addEventListener("change", () => { wanted = true; });
    (function loop() {
      requestAnimationFrame(loop);
      if (document.hidden) return;
      controls.update();
      draw();
    })();

    canvas.addEventListener("pointermove", event => {
      const frame = canvas.getBoundingClientRect(), x = event.clientX - frame.left, y = event.clientY - frame.top;
      const g = event.buttons ? -1 : pick(x, y);
      if (g !== chosen) {
        chosen = g;
        colour();
      }
      tip.style.display = g < 0 ? "none" : "block";
      if (g < 0) return;
      const at = matrices[g].elements.slice(12, 15).map(v => v.toPrecision(4)).join(", ");
      tip.textContent = "grain " + g + " (" + kindsOf[data.kind_of_grain[g]].name + "): touches " + data.contacts[g] + "; at " + at + " mm";
      tip.style.left = Math.min(x + 12, canvas.clientWidth - tip.offsetWidth - 4) + "px";
      tip.style.top = y + 14 + "px";
    });
    canvas.addEventListener("pointerleave", () => {
      tip.style.display = "none";
      if (chosen >= 0) {
        chosen = -1;
        colour();
      }
    });
    canvas.addEventListener("keydown", event => {
      const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      const nearer = { "+": 0.9, "-": 1.1 }[event.key];
      if (!turn && !nearer && event.key !== "0") return;
      event.preventDefault();
      if (event.key === "0") return reset();
      const from = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target).applyAxisAngle(new THREE.Vector3(1, 0, 0), -Math.PI / 2));
      if (turn) {
        from.theta += 0.1 * turn[0];
        from.phi += 0.1 * turn[1];
        from.makeSafe();
      } else {
        from.radius *= nearer;
      }
      camera.position.copy(controls.target).add(new THREE.Vector3().setFromSpherical(from).applyAxisAngle(new THREE.Vector3(1, 0, 0), Math.PI / 2));
      wanted = true;
    });
    form.addEventListener("submit", event => event.preventDefault());
    form.colour.addEventListener("change", colour);
    for (const input of [form.axis, form.at, form.flip]) input.addEventListener("input", cut);
    for (const [input, group] of [[form.vessel, vessel], [form.section, section], [form.lines, lines]])
      input.addEventListener("change", () => {
        group.visible = input.checked;
        colour();
      });
    function chooseSlice() {
      if (slice) slice.plane.visible = false;
      slice = slices[form.slice.value] || null;
      if (slice) slice.plane.visible = true;
      if (form.slice.value === "scan" && !form.axis.value) form.axis.value = "y";
      cut();
      colour();
    }
    form.slice.addEventListener("change", chooseSlice);
    form.reset.addEventListener("click", reset);
    form.full.addEventListener("click", () => document.fullscreenElement ? document.exitFullscreen() : box.requestFullscreen());
    form.png.addEventListener("click", () => {
      const link = document.createElement("a");
      link.href = canvas.toDataURL("image/png");
      link.download = "bed.png";
      link.click();
    });
    if (data.scan) form.slice.value = "scan";
    if (!count) form.colour.parentElement.style.display = "none";
    chooseSlice();
    reset();
    draw();
    box.view = { camera, controls, renderer, form, pick, look, reset, cut, colour, kinds: kindsOf, draw: () => { wanted = true; draw(); }, matrices, low, high, vessel, section, lines, slices, inclinations };
  }

  document.querySelectorAll(".bed").forEach(start);
})();
